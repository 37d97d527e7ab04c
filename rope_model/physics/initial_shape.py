"""Initial guess for the equilibrium: a rope that hangs in two straight legs and a half circle.

The half circle spans the suspension.  If its arc would be shorter than four local elements it is
widened to that, up to a radius of a quarter of the shorter side, and the legs lean inwards.  Works
on numbers, numpy arrays and CasADi expressions.
"""

import math
from typing import Annotated, NamedTuple

from rope_model.physics.elementary import Scalar, Vector3, cos, maximum, minimum, sin, where


class InitialShape(NamedTuple):
    """Radius of the half circle (m), lengths of the legs (m), and how far each leg leans inwards (m)."""

    radius: float
    left_leg: float
    right_leg: float
    lean: float


def initial_shape(length: Scalar, middle: Scalar, width: Scalar, cell: Scalar) -> InitialShape:
    """Return the shape of a rope of ``length`` (m), lowest at arc length ``middle``, on elements of ``cell`` (m)."""
    radius = maximum(
        0.5 * width, minimum(4 * cell / math.pi, 0.25 * minimum(middle, length - middle))
    )
    left_leg = middle - 0.5 * math.pi * radius
    right_leg = length - middle - 0.5 * math.pi * radius
    return InitialShape(radius, left_leg, right_leg, radius - 0.5 * width)


def position_and_tangent(
    shape: InitialShape, s: Scalar, phi: Scalar
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return the position across and below the left end (m), and the tangent there, at arc length ``s``.

    ``phi`` is the angle by which the rope has turned up to there.  The tangent of a leg is given
    without its lean.
    """
    radius, left_leg, right_leg, lean = shape
    on_left = minimum(s, left_leg)
    on_right = maximum(s - left_leg - math.pi * radius, 0.0)
    across = radius * (1 - cos(phi)) - lean * (on_left / left_leg + on_right / right_leg)
    return across, on_left + radius * sin(phi) - on_right, sin(phi), -cos(phi)


def node_row(
    shape: InitialShape, left: Vector3, across: Vector3, s: Scalar
) -> Annotated[tuple[Scalar, ...], 7]:
    """Return r, r' and theta (7,) at arc length ``s`` of a rope from ``left`` (3,) in the direction ``across`` (3,)."""
    # rad, angle by which the rope has turned
    phi = minimum(maximum((s - shape.left_leg) / shape.radius, 0.0), math.pi)
    along, down, slope, rise = position_and_tangent(shape, s, phi)
    legs_lean = where(phi >= math.pi, shape.lean / shape.right_leg, 0.0)
    slope = slope - where(phi <= 0, shape.lean / shape.left_leg, legs_lean)
    r = left[0] + along * across[0], left[1] - down, left[2] + along * across[2]
    return (*r, slope * across[0], rise, slope * across[2], 0.0)
