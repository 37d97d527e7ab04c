"""Stick and slip of the swivels: location of the phase changes, and the next phase.

The event function of a swivel is negative while its phase may last: |M| / M_static - 1 while it sticks, the rate
against the sense of the slip while it slips.  The step that would carry it past zero is shortened to end there; then
the swivel switches and the integrator restarts with consistent accelerations.
"""

import logging
import math

import numpy as np

from rope_model.numerics.generalized_alpha import StepResult
from rope_model.physics.node import ANGLE
from rope_model.rules.end_paths import END_NODE, SIDES
from rope_model.rules.generalized_alpha import Motion
from rope_model.rules.state import Event, RopeState
from rope_model.rules.swivel_phases import (
    CHATTER_EVENTS,
    CHATTER_TIME,
    EVENT_WIDTH,
    Phase,
    SwivelState,
    frictionless,
    released_at,
    swivel_excess,
)
from rope_model.simulation.model import RopeModel, ends_of
from rope_model.simulation.rope_system import Evaluation, RopeSystem
from rope_model.simulation.stepping.events import locate

log = logging.getLogger(__name__)


def release_swivels(model: RopeModel, state: RopeState) -> RopeState:
    """Let swivels stick or slip whose release time has come."""
    swivels = list(state.swivels)
    for side, swivel in enumerate((model.scene.left, model.scene.right)):
        if state.motion.t >= released_at(swivel, swivels[side]):
            phase = Phase.SLIP if frictionless(swivel) else Phase.STICK
            swivels[side] = SwivelState(phase, swivels[side].angle, 1.0)
    if swivels == list(state.swivels):
        return state
    state = model.restart(state._replace(swivels=(swivels[0], swivels[1])))
    return switch_swivels(model, state) if excess(model.system(state), state.motion) >= 0 else state


def next_release(model: RopeModel, state: RopeState) -> float:
    """Return the next instant at which a locked swivel is released; infinity without one."""
    return float(min(map(released_at, (model.scene.left, model.scene.right), state.swivels)))


def excess(system: RopeSystem, motion: Motion) -> float:
    """Return the event function of both swivels: negative while each may stay in its phase."""
    return max(_excess_of(side, system, motion) for side in (0, 1))


def _excess_of(side: int, system: RopeSystem, motion: Motion) -> float:
    ends = ends_of(system)
    node, swivel_state, rate = END_NODE[side], ends.states[side], 0.0
    R = motion.reaction[node]
    if swivel_state.phase is Phase.SLIP:
        rate = ends.relative(
            side, motion.t, float(motion.q[node, ANGLE]), float(motion.v[node, ANGLE])
        )[1]
    tension = ends.tension(side, motion.q, motion.reaction)
    return float(swivel_excess(ends.swivels[side], swivel_state, tension, float(R[ANGLE]), rate))


def switching_step(
    model: RopeModel,
    system: RopeSystem,
    state: RopeState,
    result: StepResult[Evaluation],
    iterations_left: int,
) -> tuple[float, int] | None:
    """Return the step to the instant at which a swivel must switch, and the Newton iterations of the search.

    After ``iterations_left`` it is the step to the earliest instant known to be past the event.  None if no swivel
    switches before ``result``.
    """
    assert result.motion is not None
    at_end = excess(system, result.motion)
    if at_end < 0:
        return None

    iterations = 0

    def at(h: float) -> float:
        nonlocal iterations
        if iterations >= iterations_left:
            return -1.0
        trial = model.trial(system, state.motion, h)
        iterations += trial.newton.iterations
        return np.inf if trial.motion is None else excess(system, trial.motion)

    at_start = excess(system, state.motion)
    if at_start >= 0:  # a slip that has just begun has no rate yet
        at_start = -1e-12
    return float(
        locate(at, 0.0, result.motion.t - state.motion.t, at_start, at_end, EVENT_WIDTH)
    ), iterations


def switch_swivels(model: RopeModel, state: RopeState) -> RopeState:
    """Switch the swivels that cannot stay in their phase, and restart the motion consistently."""
    system, motion, swivels, events = model.system(state), state.motion, list(state.swivels), []
    for side in (0, 1):
        if _excess_of(side, system, motion) < 0:
            continue
        swivels[side] = _next_phase(side, model, state._replace(swivels=(swivels[0], swivels[1])))
        what = (
            "sticks"
            if swivels[side].phase is Phase.STICK
            else f"slips {'+' if swivels[side].sign > 0 else '-'}"
        )
        events.append(Event(motion.t, f"{SIDES[side]} swivel {what}"))
        log.debug("t = %.9f s: %s", *events[-1][:2])
    state = state._replace(
        swivels=(swivels[0], swivels[1]),
        counts=state.counts.plus(swivel_events=len(events)),
        events=(*state.events, *events),
    )
    return model.restart(state)


def chatters(state: RopeState) -> bool:
    """Return whether the swivels switch back and forth faster than any rope can move."""
    times = [event.t for event in state.events if "swivel" in event.what]
    return len(times) >= CHATTER_EVENTS and times[-1] - times[-CHATTER_EVENTS] < CHATTER_TIME


def _next_phase(side: int, model: RopeModel, state: RopeState) -> SwivelState:
    """Return the next phase of a swivel that cannot stay in its own: stick if its friction can hold, else slip."""
    swivel_state, motion = state.swivels[side], state.motion
    if swivel_state.phase is Phase.SLIP:
        angle = ends_of(model.system(state)).relative(
            side, motion.t, motion.q[END_NODE[side], ANGLE], 0.0
        )[0]
        swivel_state = SwivelState(Phase.STICK, float(angle), 0.0)
        swivels = (
            (swivel_state, state.swivels[1]) if side == 0 else (state.swivels[0], swivel_state)
        )
        state = model.restart(state._replace(swivels=swivels))
        if _excess_of(side, model.system(state), state.motion) < 0:
            return swivel_state
    return SwivelState(
        Phase.SLIP,
        swivel_state.angle,
        math.copysign(1.0, -state.motion.reaction[END_NODE[side], ANGLE]),
    )
