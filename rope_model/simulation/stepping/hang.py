"""Equilibrium at the start: the rope is hung up straight, takes its permanent curvature, then its twist.

Where the sump's floor is higher than the loop of a rope that hangs freely, the straight rope is laid down on it first.

Its swivels hold.  If one that starts relaxed cannot, the rope is hung up again while that one turns against the
friction of its slip: neither coupling nor installed twist winds up its loop.  That friction is below the one that holds
it at rest.  A straight rope at rest carries the same torque all along, so only the swivel with the least friction
turns.  On a curved rope the other may have to turn as well.

A rope whose ends are not plumb hangs with ends close together; they move apart and lean step by step; it relaxes again.
"""

import math
from dataclasses import replace

import numpy as np

from rope_model.parameters import Scene
from rope_model.physics.initial_curvature import max_curvature
from rope_model.physics.node import ANGLE
from rope_model.rules.end_conditions import partly_placed
from rope_model.rules.end_paths import END_NODE, EndMotion, EndPath
from rope_model.rules.fidelity import flexible
from rope_model.rules.generalized_alpha import Motion
from rope_model.rules.messages import messages
from rope_model.rules.messages.fidelity_rules import not_plumb
from rope_model.rules.state import RopeState
from rope_model.rules.statics import (
    CURVATURE_STEPS,
    FLOOR_STEP,
    MAX_CORRECTIONS,
    MAX_FLOOR_STEPS,
    MAX_TURN,
    MIN_TWIST_STEP,
    PLACING_STEPS,
    TWIST_STEP,
)
from rope_model.rules.swivel_phases import Phase, SwivelState, beyond_rest, relaxes
from rope_model.simulation.curvature import is_curved, partly_curved
from rope_model.simulation.mesh.adaptation import update_loop_yaw
from rope_model.simulation.model import RopeModel, ends_of, energies
from rope_model.simulation.stepping.statics import StaticsError, find_equilibrium


def hang(model: RopeModel, state: RopeState, ends: tuple[EndMotion, EndMotion]) -> RopeState:
    """Return ``state`` at rest: its rope is hung up in a loop, its ends move and lean to ``ends``, and it relaxes."""
    state = _hang_in_loop(model, state)
    for k in range(PLACING_STEPS if not_plumb(model.scene) else 0):
        on_the_way = paths_at_rest(model.scene, state.motion.t, ends, (k + 1) / PLACING_STEPS)
        state, _ = equilibrium_in_frame(model, state._replace(paths=on_the_way))
    return _relax(model, None, state) if not_plumb(model.scene) else state


def paths_at_rest(
    scene: Scene, t: float, ends: tuple[EndMotion, EndMotion], placed: float
) -> tuple[EndPath, EndPath]:
    """Return the paths of both ends at rest on their way; those of plumb ends at their positions."""
    left, right, placed = *ends, placed if not_plumb(scene) else 1.0
    first, second = (
        partly_placed(scene, left, right, -1.0, placed),
        partly_placed(scene, right, left, 1.0, placed),
    )
    return EndPath.at_rest(t, first), EndPath.at_rest(t, second)


def _hang_in_loop(model: RopeModel, state: RopeState) -> RopeState:
    """Return ``state`` at rest, hung up straight and untwisted, then curved, twisted and relaxed."""
    end_angles = model.system(state).prescribed_motion(state.motion.t)[0, [0, -1], ANGLE].tolist()
    twist, straight = end_angles[1] - end_angles[0], _untwisted(state, end_angles[0])
    hung = _turn_in(model, *_let_curve(model, _turn_right_end(straight, -twist)), twist)
    return _relax(model, [_untwisted(state, other) for other in reversed(end_angles)], hung)


def _lay_down(model: RopeModel, state: RopeState) -> tuple[RopeState, int]:
    """Return ``state`` at rest, laid down on the floor, and the number of corrections.

    It hangs freely first, and the floor rises to its level in steps.  In the way of a rope that hangs freely, the floor
    would push it up by its legs, to an equilibrium of two compressed bars.
    """
    total, shaft, lowest = 0, model.scene.shaft, float(state.motion.q[:, 1].min())
    below = shaft.sump.level - lowest if shaft.contact.stiffness > 0 else 0.0
    parts = min(math.ceil(below / FLOOR_STEP), MAX_FLOOR_STEPS) if below > 0 else 0
    for k in range(parts):
        raised = replace(shaft, sump=replace(shaft.sump, level=lowest + below * k / parts))
        state, corrections = equilibrium_in_frame(
            replace(model, scene=model.scene.with_(shaft=raised)), state
        )
        total += corrections
    state, corrections = equilibrium_in_frame(model, state)
    return state, total + corrections


def _let_curve(model: RopeModel, state: RopeState) -> tuple[RopeState, int]:
    """Return ``state`` at rest, its rope first straight and then curved step by step, and the number of corrections."""
    rope = model.scene.rope
    if not is_curved(rope, flexible(state.fidelity)):
        return _lay_down(model, state)
    state, total = _lay_down(
        replace(model, scene=model.scene.with_(rope=partly_curved(rope, 0.0))), state
    )
    for k in range(1, CURVATURE_STEPS + 1):
        part = replace(
            model, scene=model.scene.with_(rope=partly_curved(rope, k / CURVATURE_STEPS))
        )
        try:
            state, corrections = equilibrium_in_frame(part, state)
        except StaticsError as error:
            reached, whole = max_curvature(part.scene.rope), max_curvature(rope)
            raise StaticsError(messages.fails_at_curvature(reached, whole, str(error))) from error
        total += corrections
    return state, total


def _turn_in(model: RopeModel, state: RopeState, total: int, twist: float) -> RopeState:
    """Return ``state`` with ``twist`` (rad) added, so slowly that the increments do not matter.

    A step that turns the frame by more than MAX_TURN is rejected; the next goes at most half way to the rejected
    twist.  If a step of MIN_TWIST_STEP still does, the branch ends at a limit point: the rope snaps through and the
    search continues from the new equilibrium.  ``total`` is the number of corrections so far.
    """
    left, beyond, size = twist, math.inf, TWIST_STEP
    while left != 0:
        size = min(size, 0.5 * abs(left - beyond))
        step = math.copysign(size, twist) if size < abs(left) else left
        last = abs(step) <= MIN_TWIST_STEP
        if total >= MAX_CORRECTIONS:
            raise StaticsError(
                messages.fails_at_twist(
                    twist - left, twist, abs(step), total, messages.takes_too_long()
                )
            )
        try:
            after, corrections = equilibrium_in_frame(
                model, _twist_evenly(state, step), math.inf if last else MAX_TURN
            )
        except StaticsError as error:
            total += error.corrections
            if not error.turned:
                why = messages.fails_at_twist(twist - left, twist, abs(step), total, str(error))
                raise StaticsError(why) from error
            beyond = left - step
            continue
        total += corrections
        left -= step
        if abs(after.offsets[1] - state.offsets[1] - step) > MAX_TURN:
            after = after._replace(snap_twist=twist - left)
        state, size = after, min(2 * abs(step), TWIST_STEP)
        if last:
            beyond = math.inf
    return state


def _relax(model: RopeModel, straight: list[RopeState] | None, state: RopeState) -> RopeState:
    """Return ``state`` if its swivels hold, else with those that start relaxed where they have slid to.

    ``straight`` are the rope hung up straight, untwisted as seen from the right end, and from the left one; from these
    the first swivel slips, or else, without them, from ``state``.
    """
    slips: dict[int, SwivelState] = {}
    while loose := {
        side: friction for side, friction in _loose(model, state).items() if side not in slips
    }:
        side = min(loose, key=loose.__getitem__)
        slips[side] = SwivelState(
            Phase.SLIP, 0.0, math.copysign(1.0, -state.motion.reaction[END_NODE[side], ANGLE])
        )
        if straight and len(slips) == 1:
            state, _ = _let_curve(model, _with_swivels(straight[side], slips))
        else:
            state, _ = equilibrium_in_frame(model, _with_swivels(state, slips))
        m, ends = state.motion, model.ends(state)
        angles = {k: ends.relative(k, m.t, float(m.q[END_NODE[k], ANGLE]), 0.0)[0] for k in slips}
        rests = {k: SwivelState(Phase.LOCKED, angle, 0.0) for k, angle in angles.items()}
        state, _ = equilibrium_in_frame(model, _with_swivels(state, rests))
        if not is_curved(model.scene.rope, flexible(state.fidelity)):
            break
    return state


def _loose(model: RopeModel, state: RopeState) -> dict[int, float]:
    """Return the sides whose swivel relaxes and does not hold, with the friction (N m) of its slip."""
    ends, m, loose = ends_of(model.system(state)), state.motion, dict[int, float]()
    for side, node in enumerate(END_NODE):
        swivel, R = ends.swivels[side], m.reaction[node]
        if (
            relaxes(swivel, state.swivels[side], m.t)
            and beyond_rest(swivel, ends.tension(side, m.q, m.reaction), float(R[ANGLE])) >= 0
        ):
            loose[side] = ends.friction(side, m.q, m.reaction, kinetic=True)
    return loose


def _untwisted(state: RopeState, angle: float) -> RopeState:
    """Return ``state`` with this ``angle`` (rad) all along."""
    q = state.motion.q.copy()
    q[:, ANGLE] = angle
    return state._replace(motion=replace(state.motion, q=q))


def _with_swivels(state: RopeState, swivels: dict[int, SwivelState]) -> RopeState:
    """Return ``state`` with these swivels by side."""
    left, right = (swivels.get(side, state.swivels[side]) for side in (0, 1))
    return state._replace(swivels=(left, right))


def equilibrium_in_frame(
    model: RopeModel, state: RopeState, max_turn: float = math.inf
) -> tuple[RopeState, int]:
    """Return ``state`` in equilibrium, and the number of corrections."""
    m, zeros = state.motion, np.zeros_like(state.motion.q)
    equilibrium = find_equilibrium(model.system(state), m.q, m.t, max_turn=max_turn)
    motion = Motion(m.t, equilibrium.q, zeros, zeros, zeros, zeros, 0.0, equilibrium.reaction)
    state = _turn_right_end(
        state._replace(motion=motion, director=equilibrium.director), equilibrium.end_rotation
    )
    balance = (
        model.system(state).evaluate(equilibrium.q, zeros, zeros, equilibrium.reaction).balance
    )
    # a loop that yaws by psi turns the frame of the right end by -2 psi: this shows full turns
    yaw = state.loop_yaw - 0.5 * equilibrium.end_rotation
    books = energies(state.energy_balance, balance)
    return update_loop_yaw(
        state._replace(energy_balance=books, loop_yaw=yaw)
    ), equilibrium.iterations


def _turn_right_end(state: RopeState, angle: float) -> RopeState:
    """Return ``state`` with the right end turned by ``angle`` (rad) against its conveyance."""
    left, right = state.offsets
    return state._replace(offsets=(left, right + angle))


def _twist_evenly(state: RopeState, angle: float) -> RopeState:
    """Return ``state`` with ``angle`` (rad) of twist spread along the rope."""
    m, s = state.motion, state.partition.nodes_s
    q = m.q.copy()
    q[:, ANGLE] += angle * (s / s[-1])
    return _turn_right_end(state._replace(motion=replace(m, q=q)), angle)
