"""The lowest rung: an inextensible rope without bending stiffness, two straight legs and a half circle.

With the ends' heights y1, y2 (speeds v1, v2, accelerations a1, a2), R half their distance, legs of length
l1 = (L - pi R + y1 - y2) / 2 and l2 = L - pi R - l1, the rope flows through the half circle at u = (v1 - v2) / 2
while that sinks or rises at w = (v1 + v2) / 2.  The momentum of the three parts gives the tensions

    at the ends of the half circle:  (rho pi R (g + w_t) + 2 rho u^2 -+ rho pi R u_t) / 2  left and right
    at the conveyances:              plus rho l (g + a)

so an end carries weight, inertia and the thrust rho u^2 of the turning rope.  No side forces, no torque, no waves:
for the design of controllers.  The rope must stay taut.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..numerics.generalized_alpha import Motion
from ..parameters import Scene
from .ends import EndPath, nominal_points
from .rope_system import POSITION, SLOPE, Array
from .statics import hanging_guess


@dataclass(frozen=True)
class RigidRope:
    """Tensions at the two ends (N), kinetic energy and potential energy of the weight (J), motion of the nodes."""

    tensions: tuple[float, float]
    kinetic: float
    gravity: float
    motion: Motion


def rigid_rope(scene: Scene, paths: tuple[EndPath, EndPath], t: float, nodes_s: Array) -> RigidRope:
    """The rope at ``t``; ValueError where it would have to push."""
    rho, g, L = scene.rope.mass_per_length, scene.layout.gravity, scene.rope.length
    (x1, v1, a1), (x2, v2, a2) = (path(t) for path in paths)
    ends = nominal_points(scene.layout.spacing) + np.array([x1[:3], x2[:3]])
    R = 0.5 * math.hypot(*(ends[1] - ends[0])[[0, 2]])
    y1, y2 = float(x1[1]), float(x2[1])
    l1 = 0.5 * (L - math.pi * R + y1 - y2)
    l2 = L - math.pi * R - l1
    u, u_t = 0.5 * float(v1[1] - v2[1]), 0.5 * float(a1[1] - a2[1])
    w, w_t = 0.5 * float(v1[1] + v2[1]), 0.5 * float(a1[1] + a2[1])
    arc = rho * math.pi * R
    common = 0.5 * (arc * (g + w_t) + 2 * rho * u * u)
    below = common - 0.5 * arc * u_t, common + 0.5 * arc * u_t
    tensions = (below[0] + rho * l1 * (g + float(a1[1])), below[1] + rho * l2 * (g + float(a2[1])))
    if min(*below, *tensions) < 0:
        raise ValueError(
            f"the rope goes slack: tension {min(*below, *tensions):.4g} N at t = {t:g} s, which the rigid rung cannot "
            "follow; use a flexible one (model.rung = auto, planar or torsional) or a gentler motion"
        )
    kinetic = 0.5 * rho * (l1 * float(v1[1]) ** 2 + l2 * float(v2[1]) ** 2) + 0.5 * arc * (w * w + u * u)
    middle = y1 - l1 - 2 * R / math.pi
    gravity = g * (rho * l1 * (y1 - 0.5 * l1) + rho * l2 * (y2 - 0.5 * l2) + arc * middle)

    q = hanging_guess(nodes_s, ends[0], ends[1])
    v, a, reaction = np.zeros_like(q), np.zeros_like(q), np.zeros_like(q)
    v[:, POSITION] = -u * q[:, SLOPE]
    v[:, 1] += w
    for node, x_t, x_tt, tension in ((0, v1, a1, tensions[0]), (-1, v2, a2, tensions[1])):
        v[node, POSITION], a[node, POSITION] = x_t[:3], x_tt[:3]
        reaction[node, 1] = tension
    return RigidRope(tensions, kinetic, gravity, Motion(t, q, v, a, a, np.zeros_like(q), 0.0, reaction))
