"""Forces at points of the rope that change linearly in time; vectors have their components first."""

from typing import Annotated

from rope_model.physics.elementary import Scalar, Vector3, cross, maximum, minimum


def time_fraction(start: Scalar, stop: Scalar, t: Scalar) -> Scalar:
    """Return the fraction, 0 to 1, of the time from ``start`` to ``stop`` that has passed at ``t``."""
    return minimum(maximum((t - start) / (stop - start), 0.0), 1.0)


def point_load(point: Vector3, force: Vector3) -> Annotated[tuple[Scalar, ...], 6]:
    """Return a force at a point and its moment about the origin (6,)."""
    return (force[0], force[1], force[2], *cross(point, force))
