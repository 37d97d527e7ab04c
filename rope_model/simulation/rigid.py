"""Rigid rope, the lowest fidelity: physics.inextensible between the ends, and the transition to a flexible rope.

It has no side forces, torque or waves and serves the design of controllers.  The rope must stay taut.

The flexible rope that replaces it starts from the equilibrium between the ends of that instant and moves with it.
"""

from dataclasses import dataclass, replace

import numpy as np

from rope_model.arrays import Array
from rope_model.parameters import Scene
from rope_model.physics.centreline import suspension_points
from rope_model.physics.inextensible import (
    Flow,
    energies,
    flow,
    min_tension,
    rigid_tensions,
    tension,
)
from rope_model.physics.node import ANGLE, POSITION, SLOPE
from rope_model.rules.end_paths import EndMotion
from rope_model.rules.generalized_alpha import Motion
from rope_model.rules.messages import messages
from rope_model.rules.stepping import DIFFERENCE, NEWTON_TOLERANCE, SETTLING_TIME
from rope_model.simulation.ends.ends import HangingEnds
from rope_model.simulation.rope_system import RopeSystem
from rope_model.simulation.stepping.statics import find_equilibrium, hanging_guess

Ends = tuple[EndMotion, EndMotion]


@dataclass(frozen=True)
class RigidRope:
    """Tensions at both ends (N), kinetic energy and potential energy of the weight (J), motion of the nodes."""

    tensions: tuple[float, float]
    kinetic: float
    gravity: float
    motion: Motion


def rigid_rope(scene: Scene, ends: Ends, t: float, nodes_s: Array) -> RigidRope:
    """Return the rope at ``t``; ValueError if it goes slack."""
    left, right = ends
    tensions = rigid_tensions(scene.rope, scene.layout, left, right)
    if (least := min_tension(tensions)) < 0:
        raise ValueError(messages.rope_goes_slack(least, t))
    kinetic, gravity = energies(scene.rope, scene.layout, tensions, left, right)

    q = hanging_guess(nodes_s, *np.array(suspension_points(scene.layout, left, right)))
    v, a, reaction = (
        _flow_velocities(q, flow(left.vy, right.vy)),
        np.zeros_like(q),
        np.zeros_like(q),
    )
    for node, end, tension_there in (
        (0, left, tensions.at_ends[0]),
        (-1, right, tensions.at_ends[1]),
    ):
        v[node, POSITION], a[node, POSITION] = end.velocity, end.acceleration
        reaction[node, 1] = tension_there
    return RigidRope(
        tensions.at_ends, kinetic, gravity, Motion(t, q, v, a, a, np.zeros_like(q), 0.0, reaction)
    )


def rigid_tension(motion: Motion, s: Array, y: Array, rho: float, gravity: float) -> Array:
    """Return the tension (N) at arc lengths ``s`` and heights ``y`` of the rigid rope in ``motion``."""
    rate, rise = flow(float(motion.a[0, 1]), float(motion.a[-1, 1])), y - motion.q[0, 1]
    return np.asarray(tension(rho, gravity, rate, float(motion.reaction[0, 1]), rise, s))


def flexible_start(system: RopeSystem, ends: HangingEnds, rigid: Motion) -> Motion:
    """Return a flexible rope in place of the rigid one, moving as the equilibria between the moving ``ends`` do.

    Velocities and accelerations are differences of the rope's own equilibria.  Those of the rigid one, put on its
    nodes, would stretch the elements around the loop and disturb the forces.
    """
    t, d = rigid.t, DIFFERENCE
    left, right = (path.at_constant_acceleration(t) for path in ends.paths)
    coasting = replace(ends, paths=(left, right))
    rest = find_equilibrium(system.with_boundary(coasting), rigid.q, t)
    coasting = replace(coasting, offsets=(ends.offsets[0], ends.offsets[1] + rest.end_rotation))
    before, after = (
        find_equilibrium(system.with_boundary(coasting), rest.q, at) for at in (t - d, t + d)
    )
    for shape in (rest, before, after):  # all angles count from the rigid rope
        shape.q[:, ANGLE] -= system.frame_turn(shape.q)
    v, a = (after.q - before.q) / (2 * d), (after.q - 2 * rest.q + before.q) / d**2
    return with_elastic_strain(system, replace(rigid, q=rest.q, v=v, a=a, reaction=rest.reaction))


def with_elastic_strain(system: RopeSystem, motion: Motion) -> Motion:
    """Return ``motion`` with the stretch and twist that its accelerations need.

    An inertia that corresponds to SETTLING_TIME lets them adjust and holds the rope's position.
    """
    m, c = motion, np.array([1.0, 0.0, SETTLING_TIME**-2])
    solution = system.solve(m.q, m.v, m.a, m.reaction, c, NEWTON_TOLERANCE)
    if not solution.newton.converged:
        return motion
    return replace(motion, q=solution.q, reaction=solution.evaluation.reaction)


def _flow_velocities(q: Array, flow: Flow) -> Array:
    """Return the velocities (nodes, 7) of the ``flow`` along the rope ``q`` (nodes, 7)."""
    v = np.zeros_like(q)
    v[:, POSITION] = -flow.u * q[:, SLOPE]
    v[:, 1] += flow.w
    return v
