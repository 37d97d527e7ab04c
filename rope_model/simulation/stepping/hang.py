"""The rope at rest: hung up straight and untwisted, let take its permanent curvature, then turned in to its twist."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rope_model.numerics.generalized_alpha import Motion
from rope_model.simulation.curvature import is_curved
from rope_model.simulation.fidelity import flexible
from rope_model.simulation.mesh.adaptation import with_loop_yaw
from rope_model.simulation.messages import messages
from rope_model.simulation.model import RopeModel, energies
from rope_model.simulation.rope_system import ANGLE
from rope_model.simulation.state import RopeState
from rope_model.simulation.stepping.statics import StaticsError, find_equilibrium

#: parts in which the permanent curvature comes in
CURVATURE_STEPS = 8
#: rad of twist put in at once, at most and at least
TWIST_STEP, LEAST_TWIST_STEP = 1.0, 0.01
#: rad: a rope whose frame turns by more at the right end, twice the loop's yaw, has left the way it was on
MOST_TURN = 2.0
#: corrections after which turning in is given up: a fifth above the most that a rope needed in tests/work.py
MOST_CORRECTIONS = 100_000


def hang(model: RopeModel, state: RopeState) -> RopeState:
    """``state`` at rest, hung up straight and untwisted, then curved and turned in."""
    q, held = state.motion.q, model.system(state).prescribed_motion(state.motion.t)[0]
    q[:, ANGLE] = held[0, ANGLE]
    twist = float(held[-1, ANGLE] - held[0, ANGLE])
    return _turn_in(model, *_let_curve(model, _turn_right_end(state, -twist)), twist)


def _let_curve(model: RopeModel, state: RopeState) -> tuple[RopeState, int]:
    """``state`` at rest, its rope straight first and then curved by and by, and the corrections that it took."""
    rope, made = model.scene.rope, 0
    if not is_curved(rope, flexible(state.fidelity)):
        return equilibrium_in_frame(model, state)
    for k in range(CURVATURE_STEPS + 1):
        k0 = rope.initial_curvature * k / CURVATURE_STEPS
        part = replace(model, scene=model.scene.with_(rope=replace(rope, initial_curvature=k0)))
        try:
            state, corrections = equilibrium_in_frame(part, state)
        except StaticsError as error:
            if k == 0:
                raise
            raise StaticsError(messages.fails_at_curvature(k0, rope.initial_curvature, str(error))) from error
        made += corrections
    return state, made


def _turn_in(model: RopeModel, state: RopeState, made: int, twist: float) -> RopeState:
    """``state`` with ``twist`` (rad) more, put in so slowly that the speed does not matter.

    Steps are halved where the rope turns far, and go half the way to there as long as they get closer.  Where the
    shortest turns far, the way it was on ends at a limit point: it snaps over, and goes on from where it comes to rest.
    ``made`` are the corrections so far.
    """
    left, beyond, size = twist, math.inf, TWIST_STEP
    while left != 0:
        size = min(size, 0.5 * abs(left - beyond))
        step = math.copysign(size, twist) if size < abs(left) else left
        last = abs(step) <= LEAST_TWIST_STEP
        if made >= MOST_CORRECTIONS:
            raise StaticsError(messages.fails_at_twist(twist - left, twist, abs(step), made, messages.takes_too_long()))
        try:
            after, corrections = equilibrium_in_frame(
                model, _twist_evenly(state, step), math.inf if last else MOST_TURN
            )
        except StaticsError as error:
            made += error.corrections
            if not error.turned:
                why = messages.fails_at_twist(twist - left, twist, abs(step), made, str(error))
                raise StaticsError(why) from error
            beyond = left - step
            continue
        made += corrections
        left -= step
        if abs(after.offsets[1] - state.offsets[1] - step) > MOST_TURN:
            after = after._replace(snapped_at=twist - left)
        state, size = after, min(2 * abs(step), TWIST_STEP)
        if last:
            beyond = math.inf
    return state


def equilibrium_in_frame(model: RopeModel, state: RopeState, most_turn: float = math.inf) -> tuple[RopeState, int]:
    """Return ``state`` in equilibrium, and the corrections that it took."""
    m, rest = state.motion, np.zeros_like(state.motion.q)
    found = find_equilibrium(model.system(state), m.q, m.t, most_turn=most_turn)
    motion = Motion(m.t, found.q, rest, rest, rest, rest, 0.0, found.reaction)
    state = _turn_right_end(state._replace(motion=motion), found.turn)
    balance = model.system(state).evaluate(found.q, rest, rest, found.reaction).balance
    # a loop that yaws by psi turns the frame of the right end by -2 psi: which shows full turns on a long way
    yaw = state.loop_yaw - 0.5 * found.turn
    books = energies(state.energy_balance, balance)
    return with_loop_yaw(state._replace(energy_balance=books, loop_yaw=yaw)), found.iterations


def _turn_right_end(state: RopeState, angle: float) -> RopeState:
    """The right end turned by ``angle`` (rad) against its conveyance."""
    left, right = state.offsets
    return state._replace(offsets=(left, right + angle))


def _twist_evenly(state: RopeState, angle: float) -> RopeState:
    """The row with the angle spread along the rope."""
    m, s = state.motion, state.partition.nodes_s
    q = m.q.copy()
    q[:, ANGLE] += angle * (s / s[-1])
    return _turn_right_end(state._replace(motion=replace(m, q=q)), angle)
