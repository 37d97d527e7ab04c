"""Forces at places of the rope, which change linearly in time.  Vectors have their components first."""

from typing import Any

from rope_model.physics.elementary import cross, larger, smaller


def part_of_time(start: Any, stop: Any, t: Any) -> Any:
    """Share of the time from ``start`` to ``stop`` at ``t``, between 0 and 1."""
    return smaller(larger((t - start) / (stop - start), 0.0), 1.0)


def point_load(place: Any, force: Any) -> tuple[Any, ...]:
    """A force at a place and its moment about the origin, (6,)."""
    return (force[0], force[1], force[2], *cross(place, force))
