"""Changes of mesh and fidelity during a run, which leave the rope's motion as it is; unwrapping of the loop's yaw."""

import logging
import math
from dataclasses import replace
from typing import Any

import numpy as np

from rope_model.numerics.generalized_alpha import Solution
from rope_model.physics.accuracy import BOUNDED_MESH_ERROR, effective_tolerance
from rope_model.physics.centreline import nearest_turn
from rope_model.physics.node import POSITION, SLOPE
from rope_model.rules.end_conditions import right_offset
from rope_model.rules.end_paths import ends_at
from rope_model.rules.fidelity import lowest_sufficient
from rope_model.rules.mesh_pattern import DUE_EARLY, transformation_due
from rope_model.rules.messages import fidelity_messages, messages
from rope_model.rules.messages.fidelity_rules import carries_torque
from rope_model.rules.partition import Partition
from rope_model.rules.state import Event, RopeState
from rope_model.rules.stepping import RELAXATION_TIME
from rope_model.simulation.mesh.partition import transform, window_due
from rope_model.simulation.mesh.transfer import transfer_fields
from rope_model.simulation.model import RopeModel, ends_of, energies, update_angles
from rope_model.simulation.rigid import flexible_start, with_elastic_strain
from rope_model.simulation.rope_system import Evaluation
from rope_model.simulation.wires import carry, start_hysteresis

log = logging.getLogger(__name__)


def transform_if_due(model: RopeModel, state: RopeState) -> RopeState | str:
    """Return the state on the transformed mesh if a transformation is due, or the reason for a failure."""
    t = state.motion.t
    bottom, places = model.bottom_s(state.paths, t), model.dividers(state.paths, t)
    while (direction := transformation_due(state.partition, bottom, DUE_EARLY)) or window_due(
        state.partition, places
    ):
        transformed = _on_partition(model, state, transform(state.partition, direction, places))
        if isinstance(transformed, str):
            return transformed
        state = transformed
    return state


def _on_partition(model: RopeModel, state: RopeState, new: Partition) -> RopeState | str:
    """Transfer the state to ``new`` and relax its stiff part; return the reason if that fails."""
    if state.fidelity == "rigid":  # shape and energies of a rigid rope do not depend on the mesh
        return state._replace(partition=new)
    old_s, new_s = state.partition.nodes_s, new.nodes_s
    m = state.motion
    names = ("q", "v", "a", "b", "a_rate")
    fields = transfer_fields(np.array([getattr(m, name) for name in names]), old_s, new_s)
    carried: dict[str, Any] = dict(zip(names, fields, strict=True))
    reaction = np.zeros_like(m.reaction)
    reaction[[0, -1]] = m.reaction[[0, -1]]
    z = carry(state.hysteresis, state.partition.lengths, new.lengths)
    moved = state._replace(
        partition=new, motion=replace(m, **carried, reaction=reaction), hysteresis=z
    )
    solver = model.scene.solver
    time, step_min = RELAXATION_TIME, solver.step_min
    tolerance = float(
        effective_tolerance(solver.newton_tolerance, solver.work_max, BOUNDED_MESH_ERROR)
    )
    while not (solution := _dynamic_equilibrium(model, moved, time, tolerance)).newton.converged:
        log.debug(
            "t = %.6f s: transformation within %.3g s rejected: %s",
            m.t,
            time,
            solution.newton.status.text,
        )
        if time <= step_min:
            return messages.transformation_fails(step_min, solution.newton.status.text)
        time = max(0.5 * time, step_min)
        moved = moved._replace(counts=moved.counts.plus(rejections=1))
    moved = moved._replace(
        counts=moved.counts.plus(given_up=int(solution.newton.error > solver.newton_tolerance))
    )
    system = model.system(moved)
    z = system.update_hysteresis(solution.q).z
    moved = update_angles(
        system, moved._replace(motion=replace(moved.motion, q=solution.q), hysteresis=z)
    )
    return _with_energy_change(model, moved)


def _dynamic_equilibrium(
    model: RopeModel, state: RopeState, time: float, tolerance: float
) -> Solution[Evaluation]:
    """Return the equilibrium of the state with its accelerations.

    Where elements merge, the new cubic is a little too short or too long, which the stiffness would turn into a blow.
    An inertia that corresponds to this ``time`` (s) lets the stiff part relax and holds the rest.
    """
    m = state.motion
    return model.system(state).solve(
        m.q, m.v, m.a, m.reaction, np.array([1.0, 0.0, time**-2]), tolerance
    )


def raise_fidelity(model: RopeModel, state: RopeState, why: str) -> RopeState:
    """Return the state at the lowest fidelity that can follow the present motion.

    If the lower fidelity left nothing out, nothing else changes.  Otherwise the rope takes the stretch and twist of the
    next higher fidelity at once; a rigid one, which has no shape of its own, also takes the equilibrium's shape and
    motion.
    """
    fidelity = lowest_sufficient(
        model.scene, ends_at(state.paths, state.paths[0].stop), model.forces.s.size
    )
    reason = fidelity_messages.cannot_follow(state.fidelity, why)
    log.info("t = %.6f s: model: %s, because %s", state.motion.t, fidelity, reason)
    event = Event(state.motion.t, f"model {fidelity}")
    ends = state.motion.q[[0, -1], POSITION].tolist()
    above = state._replace(
        fidelity=fidelity,
        fidelity_reason=reason,
        events=(*state.events, event),
        offsets=(0.0, right_offset(*ends)),
    )
    if state.fidelity != "rigid" and not carries_torque(model.scene):
        return model.restart(above)
    system = model.system(above)
    if state.fidelity == "rigid":
        motion = flexible_start(system, ends_of(system), state.motion)
    else:
        motion = with_elastic_strain(system, state.motion)
    z = system.update_hysteresis(motion.q).z
    above = model.restart(update_angles(system, above._replace(motion=motion, hysteresis=z)))
    m, before = above.motion, state.energy_balance
    after = energies(before, model.system(above).evaluate(m.q, m.v, m.a, m.reaction).balance)
    if not above.hysteresis.size:
        above = above._replace(
            hysteresis=start_hysteresis(model.scene, state.partition.lengths.size)
        )
    return above._replace(
        energy_balance=after._replace(
            transformations=before.transformations + after.total - before.total
        )
    )


def update_loop_yaw(state: RopeState) -> RopeState:
    """Return the state with the loop's yaw at its lowest node, unwrapped from its last value."""
    q = state.motion.q
    d = q[q[:, 1].argmin(), SLOPE].tolist()
    return state._replace(loop_yaw=nearest_turn(math.atan2(-d[2], d[0]), state.loop_yaw))


def _with_energy_change(model: RopeModel, state: RopeState) -> RopeState:
    """Return a transformed state with its energy change in the energy balance."""
    m, before = state.motion, state.energy_balance
    after = energies(before, model.system(state).evaluate(m.q, m.v, m.a, m.reaction).balance)
    kinetic, total = after.kinetic - before.kinetic, after.total - before.total
    event = Event(m.t, "transformation", kinetic, total - kinetic)
    log.debug("t = %.6f s: %s, kinetic energy %+.3g J, potential %+.3g J", *event)
    return state._replace(
        energy_balance=after._replace(transformations=before.transformations + total),
        counts=state.counts.plus(transformations=1),
        events=(*state.events, event),
    )
