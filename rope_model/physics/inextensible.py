"""Rigid model: an inextensible rope without bending stiffness, two straight legs and a half circle between them.

With the ends' heights y1, y2 (speeds v1, v2, accelerations a1, a2), R half their distance, legs of
length l1 = (L - pi R + y1 - y2) / 2 and l2 = L - pi R - l1, the rope flows through the half circle
at u = (v1 - v2) / 2 while that sinks or rises at w = (v1 + v2) / 2.  The momentum of the three
parts gives the tensions

    at the ends of the half circle:  (rho pi R (g + w_t) + 2 rho u^2 +- rho pi R u_t) / 2  left and right
    at the conveyances:              plus rho l (g + a)

so an end carries weight, inertia and the thrust rho u^2 of the turning rope.  In between, with the
height y and the arc length s from the left end,

    T(s) = T(0) + rho (g + w_t) (y - y1) - rho u_t s .

``rope`` and ``layout`` are those of a scene; works on numbers and CasADi expressions.
"""

import math
from typing import NamedTuple, Protocol

from rope_model.parameters import Layout, Rope
from rope_model.physics.centreline import SuspensionPoint, suspension_points
from rope_model.physics.elementary import Scalar, hypot, minimum


class SuspensionMotion(SuspensionPoint, Protocol):
    """Position of a suspension point, with its upward speed (m/s) and acceleration (m/s^2)."""

    @property
    def vy(self) -> Scalar: ...
    @property
    def ay(self) -> Scalar: ...


class Flow(NamedTuple):
    """Speed u from the right leg into the left one, and upward speed w of the loop (m/s), or their rates (m/s^2)."""

    u: float
    w: float


class RigidTensions(NamedTuple):
    """Tensions (N) at conveyances and below legs, lengths (m) of legs; mass (kg) and radius (m) of the half circle."""

    at_ends: tuple[float, float]
    below: tuple[float, float]
    legs: tuple[float, float]
    arc: float
    radius: float


def left_leg_length(length: Scalar, left: Scalar, right: Scalar) -> Scalar:
    """Return the length (m) of the left leg of a rope between ends at the heights ``left`` and ``right`` (m).

    It is the arc length of the lowest point of a rope of this ``length`` without a half circle.
    """
    return 0.5 * (length + left - right)


def flow(v1: Scalar, v2: Scalar) -> Flow:
    """Return the flow between ends that rise at ``v1`` and ``v2``; from their accelerations, its rates."""
    return Flow(0.5 * (v1 - v2), 0.5 * (v1 + v2))


def rigid_tensions(
    rope: Rope, layout: Layout, left: SuspensionMotion, right: SuspensionMotion
) -> RigidTensions:
    """Return the tensions for ends with these motions."""
    rho = rope.mass_per_length
    g = layout.gravity
    L = rope.length
    start, stop = suspension_points(layout, left, right)
    radius = 0.5 * hypot(stop[0] - start[0], stop[2] - start[2])
    half = math.pi * radius
    l1 = left_leg_length(L - half, left.y - right.y, 0.0)
    l2 = L - half - l1
    u = flow(left.vy, right.vy).u
    rate = flow(left.ay, right.ay)
    arc = rho * half
    common = 0.5 * (arc * (g + rate.w) + 2 * rho * u * u)
    below = common + 0.5 * arc * rate.u, common - 0.5 * arc * rate.u
    return RigidTensions(
        (below[0] + rho * l1 * (g + left.ay), below[1] + rho * l2 * (g + right.ay)),
        below,
        (l1, l2),
        arc,
        radius,
    )


def min_tension(tensions: RigidTensions) -> Scalar:
    """Return the smallest tension (N)."""
    return minimum(
        minimum(tensions.below[0], tensions.below[1]),
        minimum(tensions.at_ends[0], tensions.at_ends[1]),
    )


def energies(
    rope: Rope,
    layout: Layout,
    tensions: RigidTensions,
    left: SuspensionMotion,
    right: SuspensionMotion,
) -> tuple[Scalar, Scalar]:
    """Return kinetic energy and potential energy of the weight (J) for ends with these motions."""
    rho = rope.mass_per_length
    l1, l2 = tensions.legs
    u, w = flow(left.vy, right.vy)
    kinetic = 0.5 * rho * (
        l1 * (left.vy * left.vy) + l2 * (right.vy * right.vy)
    ) + 0.5 * tensions.arc * (w * w + u * u)
    middle = left.y - l1 - 2 * tensions.radius / math.pi
    weights = (
        rho * l1 * (left.y - 0.5 * l1) + rho * l2 * (right.y - 0.5 * l2) + tensions.arc * middle
    )
    return kinetic, layout.gravity * weights


def tension(
    rho: Scalar, gravity: Scalar, rate: Flow, at_end: Scalar, rise: Scalar, s: Scalar
) -> Scalar:
    """Return the tension (N) at arc length ``s``, ``rise`` (m) above the left end; ``rate`` is that of the Flow."""
    return at_end + rho * ((gravity + rate.w) * rise - rate.u * s)
