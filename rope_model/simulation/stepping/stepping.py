"""One step of the rope: step-size control, swivel events and transformations."""

import logging
from dataclasses import replace

from rope_model.numerics.generalized_alpha import StepResult
from rope_model.physics.accuracy import ACCEPT_BELOW, STEP_ITERATIONS, next_step, substeps
from rope_model.rules.end_paths import ends_at
from rope_model.rules.mesh_pattern import MAX_OVERSHOOT, distance_past_limit
from rope_model.rules.messages import messages
from rope_model.rules.state import RopeState
from rope_model.rules.swivel_phases import EVENT_WIDTH
from rope_model.simulation.ends import switching
from rope_model.simulation.mesh.adaptation import transform_if_due, update_loop_yaw
from rope_model.simulation.model import RopeModel, largest_end_force, powers
from rope_model.simulation.rigid import rigid_rope
from rope_model.simulation.rope_system import Evaluation, RopeSystem
from rope_model.simulation.stepping.events import locate
from rope_model.simulation.stepping.statics import StaticsError

log = logging.getLogger(__name__)


#: accepted trial step, the state before it with updated counts and step control, and true if it ends at the stop
_Accepted = tuple[StepResult[Evaluation], RopeState, bool]


def step_towards(
    model: RopeModel, state: RopeState, t_end: float, newton_limit: int
) -> RopeState | str:
    """Return the state after one accepted step towards ``t_end``, or the reason for a failure.

    ``newton_limit`` is the number of Newton iterations since the start beyond which accuracy is given up.
    """
    if state.fidelity == "rigid":
        return _rigid_step(model, state, t_end)
    transformed = transform_if_due(model, state)
    if isinstance(transformed, str):
        return transformed
    state = switching.release_swivels(model, transformed)
    system = model.system(state)
    stop = _next_stop(model, state, t_end)
    while True:
        accepted = _accepted_step(model, system, state, stop, newton_limit)
        if isinstance(accepted, str):
            return accepted
        result, state, reaches_stop = accepted
        counts = state.counts
        assert result.motion is not None
        end = result.motion.t
        # reserve iterations for the step to the event and one after it
        iterations_left = newton_limit - counts.newton - 2 * STEP_ITERATIONS
        if (
            event := switching.switching_step(model, system, state, result, iterations_left)
        ) is None:
            break
        h, iterations = event
        counts = counts.plus(newton=iterations, given_up=int(iterations >= iterations_left))
        if iterations_left <= 0:  # the swivel switches at the step's end
            break
        result = model.trial(system, state.motion, h)
        counts = counts.plus(newton=result.newton.iterations)
        if result.motion is not None:
            break
        # a shorter step may not reach the event, or find it more easily
        shorter = max(0.5 * (end - state.motion.t), model.scene.solver.step_min)
        if shorter > 0.75 * (end - state.motion.t):
            return messages.step_to_event_fails(result.newton.status.text)
        log.debug(
            "t = %.6f s: step to a swivel event rejected: %s",
            state.motion.t,
            result.newton.status.text,
        )
        state = state._replace(step_next=shorter, counts=counts.plus(rejections=1))
    after = model.commit(state, system, result)._replace(counts=counts.plus(steps=1))
    if reaches_stop and after.motion.t == end:
        after = after._replace(motion=replace(after.motion, t=stop))  # exactly, not up to rounding
    if event is not None:
        after = switching.switch_swivels(model, after)
        if switching.chatters(after):
            return messages.swivel_chatters()
    return update_loop_yaw(after)


def _rigid_step(model: RopeModel, state: RopeState, t_end: float) -> RopeState | str:
    """Move the rigid rope with its ends in one step."""
    try:
        after = as_rigid(model, state, t_end)
    except (StaticsError, ValueError) as error:
        return str(error)
    powers_after, h = powers(model.system(after), after.motion), t_end - state.motion.t
    work = after.energy_balance.work_ends + 0.5 * h * (state.powers.ends + powers_after.ends)
    force = max(after.errors.force, largest_end_force(after.motion))
    return after._replace(
        powers=powers_after,
        energy_balance=after.energy_balance._replace(work_ends=work),
        errors=after.errors._replace(time=after.errors.time + h, force=force),
        counts=after.counts.plus(steps=1),
    )


def _accepted_step(
    model: RopeModel, system: RopeSystem, state: RopeState, stop: float, newton_limit: int
) -> _Accepted | str:
    """Return a step towards ``stop`` that converges with an allowed error, halved as often as necessary.

    If the Newton budget allows no more steps, a larger error is accepted.
    """
    solver, t = model.scene.solver, state.motion.t
    step_next, cause = min(state.step_next, solver.step_max), ""
    iterations = rejections = 0
    parts = substeps(stop - t, step_next, float(_steps_left(newton_limit - state.counts.newton)))
    h = (stop - t) / parts
    while True:
        result = model.trial(system, state.motion, h)
        iterations += result.newton.iterations
        error = model.relative_error(state, result)
        if error <= ACCEPT_BELOW * solver.tolerance:
            break
        left = _steps_left(newton_limit - state.counts.newton - iterations)
        if result.motion is not None and stop - t > 0.5 * h * left:
            step_next = h
            break
        cause = (
            result.newton.status.text
            if result.motion is None
            else messages.error_too_large(error / solver.tolerance)
        )
        log.debug("t = %.6f s: step %.3g s rejected: %s", t, h, cause)
        rejections += 1
        if h <= solver.step_min:
            return messages.step_fails(h, solver.step_min, cause)
        h = max(0.5 * h, solver.step_min)
        parts, step_next = 2, h
    then = next_step(solver, h, step_next, error, bool(cause), t + h, state.calm_since)
    given_up = int(then.given_up or result.newton.error > solver.newton_tolerance)
    counts = state.counts.plus(newton=iterations, rejections=rejections, given_up=given_up)
    return (
        result,
        state._replace(step_next=then.length, calm_since=then.calm_since, counts=counts),
        parts == 1,
    )


def _next_stop(model: RopeModel, state: RopeState, t_end: float) -> float:
    """Return the instant at which the next steps must end: the host's or a release.

    It is that of a transformation if a step would carry the loop too far beyond the limit.  Otherwise the
    transformation waits for the step's end, because a step that is cut short costs more accuracy than a mesh that is a
    little late.
    """
    t, stop = state.motion.t, min(t_end, switching.next_release(model, state))
    ahead = min(stop, t + min(state.step_next, model.scene.solver.step_max))

    def due(time: float) -> float:
        return float(distance_past_limit(state.partition, model.bottom_s(state.paths, time)))

    # the next step finds a crossing between these instants, at most one step late
    at_start = due(t)
    for time in (0.5 * (t + ahead), ahead):
        if at_start < 0 and (at_time := due(time)) >= MAX_OVERSHOOT * state.partition.coarse:
            return min(locate(due, t, time, at_start, at_time, EVENT_WIDTH), stop)
    return stop


def as_rigid(model: RopeModel, state: RopeState, t: float) -> RopeState:
    """Return ``state`` as the rigid model has it at ``t``."""
    transformed = transform_if_due(model, state._replace(motion=replace(state.motion, t=t)))
    assert not isinstance(transformed, str)  # the transformation of a rigid rope cannot fail
    state = transformed
    rope = rigid_rope(model.scene, ends_at(state.paths, t), t, state.partition.nodes_s)
    return state._replace(
        motion=rope.motion,
        energy_balance=state.energy_balance._replace(kinetic=rope.kinetic, gravity=rope.gravity),
    )


def _steps_left(iterations_left: int) -> int:
    """Return the number of steps that so many Newton iterations allow, at least one."""
    return max(iterations_left // STEP_ITERATIONS, 1)
