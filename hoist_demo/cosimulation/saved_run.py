"""States of a run that are saved, and from which another goes on: checkpoints and ends of trips."""

import logging
from copy import deepcopy

from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.run_state import RunState, SavedState, TripEnd
from hoist_demo.cosimulation.schemes.interface import ParticipantFailed
from hoist_demo.cosimulation.trip_plan import TripPlan

_log = logging.getLogger(__name__)


def save_state(run: RunState, k: int) -> None:
    """Save the state at sample k in the run, in place of the one before."""
    run.saved = None  # frees the memory of the state before
    # the controller may change the state that it is called with
    controller = deepcopy(run.controller)
    run.saved = SavedState(
        sample=k,
        partners=run.coupled.save(),
        controller=controller,
        scheme_state=run.scheme_state,
        emergency_at=run.course.winding.emergency_at,
    )


def checkpoint_of(plan: TripPlan, run: RunState, *, cause: str, hoist: str) -> Checkpoint | None:
    """Return the saved state with the cause of the stop; None if no state was saved.

    ``hoist`` is the name or file that the checkpoint states.
    """
    saved = run.saved
    if saved is None:
        return None
    (plant, drive_input), snapshot = saved.partners
    rope = b""
    if snapshot is not None:
        try:
            rope = plan.rope.to_bytes(snapshot)
        except ParticipantFailed as error:
            _log.warning("the rope's last good state is lost: %s", error)
    return Checkpoint(
        sample=saved.sample,
        t=plan.sample_time(saved.sample),
        plant=plant,
        controller=saved.controller,
        input=drive_input,
        scheme_state=saved.scheme_state,
        rope=rope,
        recording=run.recorder.recording(),
        identity=plan.identity,
        cause=cause,
        hoist=hoist,
        emergency_at=saved.emergency_at,
    )


def go_to_checkpoint(plan: TripPlan, run: RunState, checkpoint: Checkpoint) -> None:
    """Put the run into the state of a checkpoint."""
    drive_state = (checkpoint.plant, checkpoint.input)
    run.coupled.restore((drive_state, plan.rope.from_bytes(checkpoint.rope)))
    run.recorder.resume(checkpoint.recording, checkpoint.sample)
    run.controller = deepcopy(checkpoint.controller)
    run.scheme_state = checkpoint.scheme_state
    if checkpoint.emergency_at is not None:
        # what opened the safety circuit may be over
        run.course = run.course.with_emergency_stop(checkpoint.emergency_at)
    run.first = checkpoint.sample
    run.steps = checkpoint.sample * plan.coupling.per_sample


def trip_end(plan: TripPlan, run: RunState) -> TripEnd:
    """Return the end of a completed trip."""
    start_height, _ = plan.start_heights
    return TripEnd(
        t=plan.sample_time(plan.sample_count),
        landing=start_height + plan.trajectory.points[-1].position,
        plant=run.drive.state,
        input=run.drive.input,
        scheme_state=run.scheme_state,
    )
