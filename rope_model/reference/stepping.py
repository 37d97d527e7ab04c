"""One step of the rope: step-size control, swivel events, transformations.

A step is rejected and halved if Newton's method fails or its local error is above twice the allowed
one; the smallest step that fails ends the run with its cause (docs/theory/time.md, "Step-size
control").  A step across a swivel's event is shortened to end there; the swivel changes its phase
and the integrator restarts (docs/theory/ends.md, "The swivel"). The mesh is transformed at the end
of the step in which that becomes due.
"""

import math
from dataclasses import dataclass, replace

from rope_model.method.events import Bracket, narrowed_bracket, trial_x
from rope_model.method.generalized_alpha import Coefficients, Motion, local_error
from rope_model.method.step_control import (
    ACCEPT_BELOW,
    AcceptedStep,
    next_step,
    step_error,
    step_limits,
)
from rope_model.method.step_errors import ErrorSums
from rope_model.method.stepping import MIN_INTERVAL
from rope_model.method.swivel_phases import (
    CHATTER_EVENTS,
    CHATTER_TIME,
    EVENT_WIDTH,
    JUST_BEFORE,
    Phase,
    SwivelState,
    frictionless,
    released_at,
)
from rope_model.parameters import Scene
from rope_model.physics.centreline import nearest_turn
from rope_model.physics.node import ANGLE, END_NODE, SIDES
from rope_model.reference.energies import after_step
from rope_model.reference.equations import HEIGHT, STRETCH, Equations
from rope_model.reference.generalized_alpha import Step, largest_error, restart, step
from rope_model.reference.newton import Cause, Failure
from rope_model.reference.outputs import yaw_of
from rope_model.reference.passages import with_passages
from rope_model.reference.state import LoggedEvent, State
from rope_model.reference.swivel import Ends, slip, stick
from rope_model.reference.transformation import with_mesh_for

NEGLIGIBLE_REST = 1e-9  #: steps: a rest of the interval below it needs no step of its own


@dataclass(frozen=True)
class Accepted:
    """Step that is taken."""

    new: Motion  #: behind the step
    before: State  #: with the work of the search for it in its counts
    h: float  #: s, length of the step that was tried; it is longer than the step to an event
    error: float  #: local error over the allowed one
    rejected: bool  #: true if longer steps failed
    switches: bool  #: true if it ends at an event of a swivel
    reaches_stop: bool


def step_towards(scene: Scene, state: State, t_end: float) -> State | Failure:
    """Return the state after one accepted step towards ``t_end`` (s)."""
    on_mesh = with_mesh_for(scene, state, state.motion.t)
    if isinstance(on_mesh, Failure):
        return on_mesh
    released = _released(scene, on_mesh)
    if isinstance(released, Failure):
        return released
    state = released
    if t_end - state.motion.t < MIN_INTERVAL:
        return replace(state, motion=_carried(state.motion, t_end))
    ends = state.ends(scene)
    equations = ends.equations(state.mesh, state.motion.q)
    stop = min(t_end, _next_release(scene, state))
    accepted = _accepted(scene, ends, equations, state, stop)
    if isinstance(accepted, Failure):
        return accepted

    old = state.motion
    new = accepted.new
    if accepted.reaches_stop:
        new = replace(new, t=stop)  # exactly, not up to rounding
    following = next_step(
        solver=scene.solver,
        accepted=AcceptedStep(
            h=accepted.h,
            t=old.t + accepted.h,
            error=accepted.error,
            rejected=accepted.rejected,
        ),
        step_next=min(accepted.before.step_next, scene.solver.step_max),
        calm_since=state.calm_since,
    )
    after = replace(
        accepted.before,
        motion=new,
        energies=after_step(state.energies, equations, ends, old, new),
        step_next=float(following.length),
        calm_since=float(following.calm_since),
    )
    after = after.with_angles(equations).counted(steps=1)
    loop_yaw = float(nearest_turn(yaw_of(after.motion.q), after.loop_yaw))
    after = replace(after, loop_yaw=loop_yaw)
    after = with_passages(after)
    if accepted.switches:
        switched = _switched(scene, after)
        if isinstance(switched, Failure):
            return switched
        after = switched
    if _chatters(after):
        return _failed_step(Cause.CHATTER, old.t, accepted.h)
    return after


def _carried(motion: Motion, t: float) -> Motion:
    """Return the ``motion`` at ``t`` (s), less than MIN_INTERVAL after it.

    A release or an event close to the host's instant leaves such a rest.  In a step of its length
    rounding would be all that changes the motion, and would count as forces.
    """
    return replace(motion, t=t, q=motion.q + (t - motion.t) * motion.v)


def _accepted(
    scene: Scene, ends: Ends, equations: Equations, state: State, stop: float
) -> Accepted | Failure:
    """Return a step towards ``stop`` (s) that converges with an allowed error."""
    solver = scene.solver
    old = state.motion
    step_next = min(state.step_next, solver.step_max)
    rejected = False
    while True:
        parts = max(math.ceil((stop - old.t) / step_next - NEGLIGIBLE_REST), 1)
        h = (stop - old.t) / parts
        trial = _trial(scene, equations, old, h)
        state = state.counted(newton=trial.corrections)
        error = _error(scene, state, equations, trial)
        good = trial.motion is not None and error <= ACCEPT_BELOW * solver.tolerance
        switches = False
        if good and trial.motion is not None and _excess(ends, trial.motion) >= 0:
            switches = True
            trial = _trial_to_event(scene, equations, ends, old, trial.motion)
            state = state.counted(newton=trial.corrections)
        if good and trial.motion is not None:
            before = replace(state, step_next=step_next)
            reaches_stop = parts == 1 and not switches
            return Accepted(trial.motion, before, h, error, rejected, switches, reaches_stop)
        if h <= solver.step_min:
            return _failed_step(trial.cause or Cause.ERROR, old.t, h)
        rejected = True
        step_next = max(0.5 * h, solver.step_min)
        state = state.counted(rejections=1)


def _failed_step(cause: Cause, t: float, h: float) -> Failure:
    """Return the failure of a step of ``h`` (s) from ``t`` (s)."""
    return Failure(cause, t, f"a step of {h:.3g} s")


def _trial(scene: Scene, equations: Equations, old: Motion, h: float) -> Step:
    """Return a trial step of ``h`` (s) with the scene's parameters of the method."""
    return step(equations, old, h, scene.solver.rho_inf, scene.solver.newton_tolerance)


def _error(scene: Scene, state: State, equations: Equations, trial: Step) -> float:
    """Return the local error of a trial step over the allowed one.

    (docs/theory/time.md, eq-local; docs/theory/errors.md, eq-share and eq-flow)
    """
    new = trial.motion
    if new is None:
        return math.inf
    old = state.motion
    method = Coefficients(scene.solver.rho_inf)
    constant = float(local_error(method, 1.0, 1.0))
    bottom = state.bottom_s(scene, old.t)
    end_speed = float(old.v[0, HEIGHT] - old.v[-1, HEIGHT])
    limits = step_limits(scene, ErrorSums(), bottom, end_speed, constant)
    position = largest_error(equations, old, new, scene.solver.rho_inf)
    change = max(abs(float(new.a[node, STRETCH] - old.a[node, STRETCH])) for node in END_NODE)
    return float(step_error(limits, new.h, position, float(local_error(method, new.h, change))))


# swivels


def _released(scene: Scene, state: State) -> State | Failure:
    """Return the state with swivels free to slip whose release time has come."""
    swivels = [_released_swivel(scene, state, side) for side in range(len(SIDES))]
    if swivels == list(state.swivels):
        return state
    released = _restarted(scene, replace(state, swivels=(swivels[0], swivels[1])))
    if isinstance(released, Failure):
        return released
    if _excess(released.ends(scene), released.motion) < 0:
        return released
    return _switched(scene, released)


def _released_swivel(scene: Scene, state: State, side: int) -> SwivelState:
    """Return the swivel on this side: released if its time has come, else as it is."""
    swivel = state.ends(scene).data(side)
    present = state.swivels[side]
    if released_at(swivel, present) - state.motion.t >= MIN_INTERVAL:
        return present
    if frictionless(swivel):
        return slip(present.angle, -1.0)
    return stick(present.angle)


def _next_release(scene: Scene, state: State) -> float:
    """Return the next instant (s) at which a locked swivel is released; infinity without one."""
    left, right = state.swivels
    return float(min(released_at(scene.left, left), released_at(scene.right, right)))


def _excess(ends: Ends, motion: Motion) -> float:
    """Return the event function of both swivels: negative while each may stay in its phase."""
    return max(ends.excess(side, motion) for side in range(len(SIDES)))


def _trial_to_event(
    scene: Scene, equations: Equations, ends: Ends, old: Motion, beyond: Motion
) -> Step:
    """Return a trial step, no longer than that to ``beyond``, to the instant at which a swivel leaves its phase.

    It ends past that instant by up to EVENT_WIDTH, the upper end of the bracket: an event that is
    due at once, as after a retuning, still takes a step.  Its corrections are those of the whole
    search.
    """
    corrections = 0

    def tried(part: float) -> Step:
        nonlocal corrections
        trial = _trial(scene, equations, old, part)
        corrections += trial.corrections
        return trial

    def excess_after(part: float) -> float:
        motion = tried(part).motion
        return math.inf if motion is None else _excess(ends, motion)

    bracket = Bracket(
        low=0.0,
        high=beyond.h,
        f_low=min(_excess(ends, old), JUST_BEFORE),
        f_high=_excess(ends, beyond),
        side=0,
        stalled=0,
    )
    while bracket.high - bracket.low > EVENT_WIDTH:
        part = float(trial_x(bracket, EVENT_WIDTH))
        if not bracket.low < part < bracket.high:
            break
        bracket = narrowed_bracket(bracket, part, excess_after(part))
    trial = tried(float(bracket.high))
    return replace(trial, corrections=corrections)


def _switched(scene: Scene, state: State) -> State | Failure:
    """Return the state with the next phase of the swivels that cannot stay in theirs, restarted."""
    ends = state.ends(scene)
    excesses = [ends.excess(side, state.motion) for side in range(len(SIDES))]
    due = min(0.0, max(excesses))  # the turn of the frame may round an event's excess below 0
    for side, name in enumerate(SIDES):
        if excesses[side] < due:
            continue
        phase = _next_phase(scene, state, side)
        if isinstance(phase, Failure):
            return phase
        state = _with_swivel(state, side, phase)
        what = "sticks" if phase.phase is Phase.STICK else f"slips {'+' if phase.sign > 0 else '-'}"
        event = LoggedEvent(state.motion.t, f"{name} swivel {what}")
        state = replace(state, events=(*state.events, event)).counted(swivel_events=1)
    return _restarted(scene, state)


def _next_phase(scene: Scene, state: State, side: int) -> SwivelState | Failure:
    """Return the next phase of a swivel: stick if its friction can hold, else slip."""
    motion = state.motion
    present = state.swivels[side]
    if present.phase is Phase.SLIP:
        present = stick(state.ends(scene).relative(side, motion)[0])
        held = _restarted(scene, _with_swivel(state, side, present))
        if isinstance(held, Failure):
            return held
        if held.ends(scene).excess(side, held.motion) < 0:
            return present
        motion = held.motion
    return slip(present.angle, float(motion.reaction[END_NODE[side], ANGLE]))


def _with_swivel(state: State, side: int, swivel: SwivelState) -> State:
    """Return the state with another state of the swivel on this side."""
    left, right = state.swivels
    return replace(state, swivels=(swivel, right) if side == 0 else (left, swivel))


def _restarted(scene: Scene, state: State) -> State | Failure:
    """Return the state with consistent accelerations and no history."""
    m = state.motion
    motion = restart(state.equations(scene), m.t, m.q, m.v)
    if isinstance(motion, Failure):
        return motion
    return replace(state, motion=motion)


def _chatters(state: State) -> bool:
    """Return whether the swivels switch back and forth faster than any rope can move."""
    times = [event.t for event in state.events if "swivel" in event.what]
    return len(times) >= CHATTER_EVENTS and times[-1] - times[-CHATTER_EVENTS] < CHATTER_TIME
