"""Inextensible rope without bending stiffness: two straight legs and a half circle between them.

With the ends' heights y1, y2 (speeds v1, v2, accelerations a1, a2), R half their distance, legs of length
l1 = (L - pi R + y1 - y2) / 2 and l2 = L - pi R - l1, the rope flows through the half circle at u = (v1 - v2) / 2
while that sinks or rises at w = (v1 + v2) / 2.  The momentum of the three parts gives the tensions

    at the ends of the half circle:  (rho pi R (g + w_t) + 2 rho u^2 +- rho pi R u_t) / 2  left and right
    at the conveyances:              plus rho l (g + a)

so an end carries weight, inertia and the thrust rho u^2 of the turning rope.  In between, with the height y and the
arc length s from the left end,

    T(s) = T(0) + rho (g + w_t) (y - y1) - rho u_t s .

``rope`` and ``layout`` are those of a scene; works on numbers and CasADi expressions.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from .elementary import hypot, smaller


class Flow(NamedTuple):
    """u, from the right leg into the left one, and w, of the loop, upwards; m/s, or their rates."""

    u: float
    w: float


class Pull(NamedTuple):
    """Tensions (N) at the conveyances and below the legs, lengths of the legs (m), half circle's mass (kg), radius (m).

    Left and right.
    """

    tensions: tuple[float, float]
    below: tuple[float, float]
    legs: tuple[float, float]
    arc: float
    radius: float


def flow(v1: Any, v2: Any) -> Flow:
    """Of ends that rise with ``v1`` and ``v2``; of its rates, for their accelerations."""
    return Flow(0.5 * (v1 - v2), 0.5 * (v1 + v2))


def pull(rope: Any, layout: Any, ends: Any, v: Any, a: Any) -> Pull:
    """For ``ends`` (2, 3) with speeds and accelerations upwards (2,)."""
    rho, g, L = rope.mass_per_length, layout.gravity, rope.length
    radius = 0.5 * hypot(ends[1][0] - ends[0][0], ends[1][2] - ends[0][2])
    half = math.pi * radius
    l1 = 0.5 * (L - half + (ends[0][1] - ends[1][1]))
    l2 = L - half - l1
    u, rate = flow(v[0], v[1]).u, flow(a[0], a[1])
    arc = rho * half
    common = 0.5 * (arc * (g + rate.w) + 2 * rho * u * u)
    below = common + 0.5 * arc * rate.u, common - 0.5 * arc * rate.u
    return Pull((below[0] + rho * l1 * (g + a[0]), below[1] + rho * l2 * (g + a[1])), below, (l1, l2), arc, radius)


def lowest(pull: Any) -> Any:
    """The smallest tension, N."""
    return smaller(smaller(pull.below[0], pull.below[1]), smaller(pull.tensions[0], pull.tensions[1]))


def energies(rope: Any, layout: Any, pull: Any, y: Any, v: Any) -> tuple[Any, Any]:
    """Kinetic energy and potential energy of the weight (J), for the ends' heights and speeds upwards (2,)."""
    rho, (l1, l2), (u, w) = rope.mass_per_length, pull.legs, flow(v[0], v[1])
    kinetic = 0.5 * rho * (l1 * (v[0] * v[0]) + l2 * (v[1] * v[1])) + 0.5 * pull.arc * (w * w + u * u)
    middle = y[0] - l1 - 2 * pull.radius / math.pi
    weights = rho * l1 * (y[0] - 0.5 * l1) + rho * l2 * (y[1] - 0.5 * l2) + pull.arc * middle
    return kinetic, layout.gravity * weights


def tension(rho: Any, gravity: Any, rate: Any, at_end: Any, rise: Any, s: Any) -> Any:
    """Tension (N) at the arc length ``s`` and ``rise`` (m) above the left end, with ``at_end`` there; rate: of flow."""
    return at_end + rho * ((gravity + rate.w) * rise - rate.u * s)
