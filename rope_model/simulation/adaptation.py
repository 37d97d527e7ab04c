"""Changes of the rope's description that leave the rope as it is: mesh, the frame's pole, the fidelity of the model."""

from __future__ import annotations

import logging
import math
from dataclasses import replace
from typing import Any

import numpy as np

from ..numerics.generalized_alpha import Solution
from ..physics.frame import best_pole, pole_change_angle, pole_margin, smallest_rotation_rate
from .fidelity import carries_torque, ends_after, lowest_sufficient
from .mesh import Partition, transform, transformation_due
from .model import RopeModel, ends_of, energies
from .rigid import flexible_start, with_elastic_strain
from .rope_system import ANGLE, SLOPE, Evaluation
from .state import Event, RopeState
from .transfer import transfer_fields

log = logging.getLogger(__name__)

#: 1 + p . t below which a new frame pole is taken; 0 is singular
POLE_MARGIN = 0.35
#: cosine of the yaw between pole and the loop's lowest tangent below which the pole follows the loop
POLE_FOLLOWS = 0.5
#: s: what is slower keeps its shape in a transformation
RELAXATION_TIME = 0.1


def transform_if_due(model: RopeModel, state: RopeState) -> RopeState:
    """The state on the transformed mesh when the loop has travelled far enough (by a hair less, for rounding)."""
    while direction := transformation_due(state.partition, model.bottom(state.paths, state.motion.t), 1e-7):
        state = _on_partition(model, state, transform(state.partition, direction))
    return state


def _on_partition(model: RopeModel, state: RopeState, new: Partition) -> RopeState:
    if state.fidelity == "rigid":  # its shape and energies do not come from the mesh
        return state._replace(partition=new)
    old_s, new_s = state.partition.nodes_s, new.nodes_s
    m = state.motion
    names = ("q", "v", "a", "b", "a_rate")
    fields = transfer_fields(np.array([getattr(m, name) for name in names]), old_s, new_s)
    carried: dict[str, Any] = dict(zip(names, fields, strict=True))
    reaction = np.zeros_like(m.reaction)
    reaction[[0, -1]] = m.reaction[[0, -1]]
    moved = state._replace(partition=new, motion=replace(m, **carried, reaction=reaction))
    solution = _dynamic_equilibrium(model, moved)
    if solution.newton.converged:
        moved = moved._replace(motion=replace(moved.motion, q=solution.q))
    return _with_energy_change(model, moved, "transformation")


def _dynamic_equilibrium(model: RopeModel, state: RopeState) -> Solution[Evaluation]:
    """The state in equilibrium with its accelerations.

    Where elements became fewer, the new cubic is a little too short or too long; in another frame theta, linear within
    an element, stands for a little more or less twist.  The stiffness would turn either into a blow.  An inertia that
    stands for RELAXATION_TIME lets the stiff part give way and holds the rest.
    """
    m = state.motion
    c = np.array([1.0, 0.0, RELAXATION_TIME**-2])
    return model.system(state).solve(m.q, m.v, m.a, m.reaction, c, model.scene.solver.newton_tolerance)


def with_good_pole(model: RopeModel, state: RopeState) -> RopeState:
    """The moving rope in a frame whose singularity is far from its tangents, in equilibrium with its accelerations."""
    moved = in_good_frame(state)
    if moved is state:
        return state
    solution = _dynamic_equilibrium(model, moved)
    if not solution.newton.converged:  # the old frame serves for another step
        return state
    motion = replace(moved.motion, q=solution.q, reaction=solution.evaluation.reaction)
    return _with_energy_change(model, moved._replace(motion=motion), "new frame pole")


def in_good_frame(state: RopeState) -> RopeState:
    """Theta and its rate expressed in a frame whose singularity is far from every tangent of the rope."""
    if state.fidelity != "torsional":  # nothing is counted from the frame
        return state
    d = state.motion.q[:, SLOPE]
    t = d / np.sqrt(np.einsum("ij,ij->i", d, d))[:, None]
    bottom = t[np.argmin(state.motion.q[:, 1])] * [1.0, 0.0, 1.0]
    margin = pole_margin(state.pole, t)
    if margin >= POLE_MARGIN and state.pole @ bottom >= POLE_FOLLOWS * math.hypot(bottom[0], bottom[2]):
        return state
    # the lowest tangent suits a loop that hangs in any vertical plane as X suits it at the start
    old, new, m = state.pole, bottom / max(float(np.linalg.norm(bottom)), 1e-12), state.motion
    if pole_margin(new, t) < POLE_MARGIN:
        new = best_pole(t)
    if pole_margin(new, t) <= margin - 0.1 or new @ old > 0.99:
        return state
    angle = pole_change_angle(old, new, t)
    q, v = m.q.copy(), m.v.copy()
    q[:, ANGLE] += angle
    rates = [smallest_rotation_rate(p, d.T, m.v[:, SLOPE].T) for p in (old, new)]
    v[:, ANGLE] += rates[0] - rates[1]
    return state._replace(
        pole=new,
        offsets=(state.offsets[0] + float(angle[0]), state.offsets[1] + float(angle[-1])),
        motion=replace(m, q=q, v=v),
    )


def raise_fidelity(model: RopeModel, state: RopeState, why: str) -> RopeState:
    """The state at the lowest fidelity that can follow what this one cannot.

    Nothing else changes where nothing was left out.  Otherwise the rope takes the stretch and twist of the next higher
    fidelity at once; a rigid one, which has no shape of its own, also takes the equilibrium's shape and motion.
    """
    fidelity = lowest_sufficient(model.scene, ends_after(state.paths))
    reason = f"the {state.fidelity} model cannot follow {why}"
    log.info("t = %.6f s: model: %s, because %s", state.motion.t, fidelity, reason)
    event = Event(state.motion.t, f"model {fidelity}")
    above = state._replace(fidelity=fidelity, fidelity_reason=reason, events=(*state.events, event))
    if state.fidelity != "rigid" and not carries_torque(model.scene):
        return model.restart(above)
    system = model.system(above)
    if state.fidelity == "rigid":
        motion = flexible_start(system, ends_of(system), state.motion)
    else:
        motion = with_elastic_strain(system, state.motion)
    above = model.restart(above._replace(motion=motion))
    m, before = above.motion, state.energy_balance
    after = before._replace(**energies(model.system(above).evaluate(m.q, m.v, m.a, m.reaction).balance))
    return above._replace(
        energy_balance=after._replace(transformations=before.transformations + after.total - before.total)
    )


def with_loop_yaw(state: RopeState) -> RopeState:
    """The loop's yaw at its lowest node, counted on from its last value."""
    q = state.motion.q
    d = q[np.argmin(q[:, 1]), SLOPE]
    return state._replace(loop_yaw=nearest_turn(math.atan2(-d[2], d[0]), state.loop_yaw))


def nearest_turn(angle: float, last: float) -> float:
    """``angle`` (rad) with the full turns that bring it closest to ``last``."""
    return angle + 2 * math.pi * round((last - angle) / (2 * math.pi))


def _with_energy_change(model: RopeModel, state: RopeState, what: str) -> RopeState:
    """A changed description with its energy change in the energy_balance."""
    m, before = state.motion, state.energy_balance
    evaluation = model.system(state).evaluate(m.q, m.v, m.a, m.reaction)
    after = before._replace(**energies(evaluation.balance))
    kinetic, total = after.kinetic - before.kinetic, after.total - before.total
    event = Event(m.t, what, kinetic, total - kinetic)
    log.debug("t = %.6f s: %s, kinetic energy %+.3g J, potential %+.3g J", *event)
    counts = state.counts
    return state._replace(
        energy_balance=after._replace(transformations=before.transformations + total),
        counts=counts.plus(transformations=1) if what == "transformation" else counts.plus(pole_changes=1),
        events=(*state.events, event),
    )
