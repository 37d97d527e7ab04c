"""The lowest fidelity of the model: physics.inextensible between the ends, and the way up from it.

No side forces, no torque, no waves: for the design of controllers.  The rope must stay taut.

The flexible rope that takes over starts from the equilibrium between the ends of that instant and moves as that does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..numerics.generalized_alpha import Motion
from ..parameters import Scene
from ..physics.inextensible import Flow, Pull, energies, flow, lowest, pull, tension
from . import messages
from .ends import EndMotion, EndPath, HangingEnds, nominal_points
from .rope_system import ANGLE, POSITION, SLOPE, Array, RopeSystem
from .statics import find_equilibrium, hanging_guess

#: s, above 1/omega of the legs' longitudinal (0.02 s) and torsional modes (0.06 s), below that of the loop (1 s)
SETTLING_TIME = 0.1
#: m
NEWTON_TOLERANCE = 1e-7
#: s between equilibria: at 8 m/s around a loop of 1 m their second differences err by 1e-3 m/s^2, by rounding alike
DIFFERENCE = 2e-3


@dataclass(frozen=True)
class RigidRope:
    """Tensions at the two ends (N), kinetic energy and potential energy of the weight (J), motion of the nodes."""

    tensions: tuple[float, float]
    kinetic: float
    gravity: float
    motion: Motion


def lowest_tension(scene: Scene, ends: tuple[EndMotion, EndMotion]) -> float:
    """The smallest tension (N) of the rope; negative where it would have to push."""
    points = nominal_points(scene.layout.spacing) + np.array([end.position for end in ends])
    return float(lowest(_pull(scene, points, (ends[0].vy, ends[1].vy), (ends[0].ay, ends[1].ay))))


def _pull(scene: Scene, ends: Array, v: tuple[float, float], a: tuple[float, float]) -> Pull:
    """``ends`` (2, 3); speeds and accelerations upwards."""
    return pull(scene.rope, scene.layout, ends.tolist(), v, a)


def rigid_rope(scene: Scene, paths: tuple[EndPath, EndPath], t: float, nodes_s: Array) -> RigidRope:
    """The rope at ``t``; ValueError where it would have to push."""
    (x1, v1, a1), (x2, v2, a2) = (path(t) for path in paths)
    ends = nominal_points(scene.layout.spacing) + np.array([x1[:3], x2[:3]])
    speeds = float(v1[1]), float(v2[1])
    now = _pull(scene, ends, speeds, (float(a1[1]), float(a2[1])))
    if (least := lowest(now)) < 0:
        raise ValueError(messages.rope_goes_slack(least, t))
    kinetic, gravity = energies(scene.rope, scene.layout, now, (float(x1[1]), float(x2[1])), speeds)

    q = hanging_guess(nodes_s, ends[0], ends[1])
    v, a, reaction = _flow_velocities(q, flow(*speeds)), np.zeros_like(q), np.zeros_like(q)
    for node, x_t, x_tt, end_tension in ((0, v1, a1, now.tensions[0]), (-1, v2, a2, now.tensions[1])):
        v[node, POSITION], a[node, POSITION] = x_t[:3], x_tt[:3]
        reaction[node, 1] = end_tension
    return RigidRope(now.tensions, kinetic, gravity, Motion(t, q, v, a, a, np.zeros_like(q), 0.0, reaction))


def rigid_tension(motion: Motion, s: Array, y: Array, rho: float, gravity: float) -> Array:
    """Tension (N) at arc lengths ``s`` and heights ``y`` of the rigid rope in ``motion``."""
    rate, rise = flow(float(motion.a[0, 1]), float(motion.a[-1, 1])), y - motion.q[0, 1]
    along: Array = tension(rho, gravity, rate, float(motion.reaction[0, 1]), rise, s)
    return along


def rigid_added_mass(scene: Scene, paths: tuple[EndPath, EndPath], t: float, h: float) -> tuple[float, float]:
    """kg: how much each end's pull grows with an upward acceleration held over ``h``, by differences."""
    size, masses = 1e-3, []
    before = perturbed_tensions(scene, paths, t, np.zeros((2, 3, 3)))
    for side in (0, 1):
        change = np.zeros((2, 3, 3))
        change[side, :, 1] = 0.5 * h * h * size, h * size, size
        masses.append(float(perturbed_tensions(scene, paths, t, change)[side] - before[side]) / size)
    return masses[0], masses[1]


def perturbed_tensions(scene: Scene, paths: tuple[EndPath, EndPath], t: float, change: Array) -> Array:
    """(2,) N, of ends with ``change`` (ends; position, speed, acceleration; axes) added to their motions."""
    x, v, a = (np.array([path(t)[k][:3] for path in paths]) + change[:, k] for k in range(3))
    ends = nominal_points(scene.layout.spacing) + x
    pull = _pull(scene, ends, (float(v[0, 1]), float(v[1, 1])), (float(a[0, 1]), float(a[1, 1])))
    return np.array(pull.tensions)


def flexible_start(system: RopeSystem, ends: HangingEnds, rigid: Motion) -> Motion:
    """A flexible rope in place of the rigid one, moving as the equilibria between the moving ``ends`` do.

    Velocities and accelerations are differences of the rope's own equilibria.  Those of the rigid one, put on its
    nodes, would stretch the elements around the loop, and throw the forces.
    """
    t, d = rigid.t, DIFFERENCE
    left, right = (path.at_constant_acceleration(t) for path in ends.paths)
    coasting = replace(ends, paths=(left, right))
    rest = find_equilibrium(system.with_boundary(coasting), rigid.q, t)
    coasting = replace(coasting, offsets=(ends.offsets[0], ends.offsets[1] + rest.turn))
    before, after = (find_equilibrium(system.with_boundary(coasting), rest.q, at) for at in (t - d, t + d))
    for found in (rest, before, after):  # all counted from the rigid rope
        found.q[:, ANGLE] -= system.frame_turn(found.q)
    v, a = (after.q - before.q) / (2 * d), (after.q - 2 * rest.q + before.q) / d**2
    return with_elastic_strain(system, replace(rigid, q=rest.q, v=v, a=a, reaction=rest.reaction))


def with_elastic_strain(system: RopeSystem, motion: Motion) -> Motion:
    """``motion`` with the stretch and twist that its accelerations ask for.

    An inertia that stands for SETTLING_TIME lets them adjust and holds the rope's place.
    """
    m, c = motion, np.array([1.0, 0.0, SETTLING_TIME**-2])
    solution = system.solve(m.q, m.v, m.a, m.reaction, c, NEWTON_TOLERANCE)
    if not solution.newton.converged:
        return motion
    return replace(motion, q=solution.q, reaction=solution.evaluation.reaction)


def _flow_velocities(q: Array, flow: Flow) -> Array:
    """Velocities (nodes, 7) of the ``flow`` along the rope ``q`` (nodes, 7)."""
    v = np.zeros_like(q)
    v[:, POSITION] = -flow.u * q[:, SLOPE]
    v[:, 1] += flow.w
    return v
