"""The co-simulation: a controller that samples, and drive and rope coupled between two samples.

    controller(t_k) -> record -> scheme over [t_k, t_k + T] in communication steps H -> ... ,
    t_k = start + k T.

T is H unless the controller samples less often; where it samples more often, T is H and the drive
calls it within its step. A rope or drive that cannot go on, or a coupling that cannot be solved,
ends the loop; the record stays, and the result names the cause. A guard of the rope that trips, and
head ropes that go slack, stop the hoist (``Course``) at the next sample. The state is saved every
SAVE_INTERVAL, and where the user stops the run, as a checkpoint, from which ``run`` goes on.
"""

import logging
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from hoist_demo.control.controller import Command, ControllerFactory, Gains
from hoist_demo.control.trajectory import Course, Trajectory, s_curve
from hoist_demo.cosimulation.checkpoint import CONTROLLER, Checkpoint
from hoist_demo.cosimulation.compiled_trip import CompiledTrip, SampleReached
from hoist_demo.cosimulation.drive_signals import with_drive_signals
from hoist_demo.cosimulation.loading import Loading
from hoist_demo.cosimulation.participants.hoist_partner import DriveCommand
from hoist_demo.cosimulation.participants.plain_data import encode
from hoist_demo.cosimulation.run_state import Result, RunState
from hoist_demo.cosimulation.sampling import (
    Sampling,
    make_controller,
    under_safety_circuit,
)
from hoist_demo.cosimulation.saved_run import (
    checkpoint_of,
    go_to_checkpoint,
    save_state,
    trip_end,
)
from hoist_demo.cosimulation.schemes.catalogue import find_scheme
from hoist_demo.cosimulation.schemes.interface import (
    SUCCESS,
    ParticipantFailed,
    RopePlant,
    Scheme,
)
from hoist_demo.cosimulation.schemes.stability import StabilityEstimate, predict_stability
from hoist_demo.cosimulation.trip_plan import NeighbouringTrips, TripPlan
from hoist_demo.cosimulation.trip_start import StartFailed, start_run
from hoist_demo.drive.plant import SIDE_FORCES
from hoist_demo.parameters import Coupling, Hoist, Winding, require_trip_fits
from hoist_demo.recording.time_series import Recording
from rope_model import Status

_log = logging.getLogger(__name__)
#: Called after every step with the fraction done and the time [s]; False stops the run.
Progress = Callable[[float, float], bool]
SAVE_INTERVAL = 5.0  #: Simulated time from one saved state to the next [s].
_NO_FORCES = np.zeros(len(SIDE_FORCES))


class Host:
    """Co-simulates a drive and a rope over one trip."""

    def __init__(
        self,
        rope: RopePlant,
        hoist: Hoist | None = None,
        winding: Winding | None = None,
        coupling: Coupling | None = None,
        gains: Gains | None = None,
        controller: ControllerFactory | None = None,
        *,
        trajectory: Trajectory | None = None,
        scheme: Scheme | None = None,
        neighbours: NeighbouringTrips | None = None,
    ) -> None:
        """Prepare a trip; None stands for the defaults.

        ``controller`` makes a controller of the hoist and the motor's torque at rest [N m];
        default: SpeedController. ``trajectory`` replaces the winding's S-curve, ``scheme`` the one
        that ``coupling`` names. ``neighbours`` are the trips of a duty before and after this one.
        """
        hoist = hoist or Hoist()
        winding = winding or Winding()
        coupling = coupling or Coupling()
        neighbours = neighbours or NeighbouringTrips()
        before = neighbours.before
        if before is not None:
            coupling = replace(coupling, start=before.t)
            before = before.with_zeroed_totals()
        require_trip_fits(hoist, winding)
        trajectory = trajectory or s_curve(winding)
        self.plan = TripPlan(
            rope=rope,
            hoist=hoist,
            winding=winding,
            coupling=coupling,
            gains=gains,
            controller=controller,
            trajectory=trajectory,
            scheme=scheme or find_scheme(coupling.scheme),
            before=before,
            loading=Loading(hoist, neighbours.next_hoist, trajectory.duration, winding.settle),
        )
        self.stability: StabilityEstimate | None = None
        self._save_interval = max(1, round(SAVE_INTERVAL / coupling.period))  # samples

    def run(
        self,
        progress: Progress | None = None,
        save_to: Path | None = None,
        resume: Checkpoint | None = None,
        name: str = "",
    ) -> Result:
        """Wind once; ``progress`` is called at every sample and may stop the run.

        When the run stops before its end, its last good state is in the result and is written to
        ``save_to``, with the ``name`` or file of the hoist; ValueError at the first sample for a
        controller whose state cannot be written. With ``resume`` the run goes on from such a state,
        with the same bits as if it had never stopped.
        """
        if resume is not None:
            resume.require_fits(self.plan.identity)
        try:
            run = self._start()
        except StartFailed as failure:
            course = self.plan.course
            return self._result(Recording({}, {}), steps=0, cause=str(failure), course=course)
        if resume is not None:
            go_to_checkpoint(self.plan, run, resume)
        cause = self._wind(run, progress, save_to).message
        checkpoint = saved = end = None
        if cause:
            checkpoint = checkpoint_of(self.plan, run, cause=cause, hoist=name)
        if checkpoint is not None and save_to is not None:
            try:
                checkpoint.write(save_to)
                saved = save_to
            except (ValueError, OSError) as error:  # keep the record of the run all the same
                cause += f"; {save_to} is not written: {error}"
        if not cause and run.course == self.plan.course:
            end = trip_end(self.plan, run)
        recording = with_drive_signals(run.recorder.recording(), self.plan.hoist)
        result = self._result(recording, run.steps, cause, run.course)
        return replace(result, checkpoint=checkpoint, saved=saved, end=end)

    def _start(self) -> RunState:
        """Return the run at its start, and predict whether the coupling is stable."""
        plan = self.plan
        run = start_run(plan)
        if plan.before is None:
            start = plan.coupling.start
            self.stability = predict_stability(
                plan.scheme, plan.coupling.scheme, run.coupled, start, plan.coupling.step
            )
        return run

    def _wind(self, run: RunState, progress: Progress | None, save_to: Path | None) -> Status:
        """Wind the trip; a failure of drive or rope in any of their calls ends it."""
        try:
            return self._wind_samples(run, progress, save_to)
        except ParticipantFailed as error:
            coupling = self.plan.coupling
            t = coupling.start + run.steps * coupling.step
            return Status(False, f"t = {t:.6g} s: {error}")

    def _wind_samples(
        self, run: RunState, progress: Progress | None, save_to: Path | None
    ) -> Status:
        """Sample and exchange until the end, a failure, or a stop by ``progress``."""
        plan = self.plan
        sampling = Sampling(plan, run, make_controller(plan, run.holding_torque))
        last = plan.sample_count
        run.drive.sample_within_steps(sampling.command_within_step)
        compiled = CompiledTrip.for_run(plan, run, self._save_interval)
        k = run.first
        while k <= last:
            t = plan.sample_time(k)
            stopped = run.first < k < last and progress is not None and not progress(k / last, t)
            if stopped or (k - run.first) % self._save_interval == 0:
                save_state(run, k)
            if stopped:
                return Status(False, f"t = {t:.6g} s: stopped by the user")
            if compiled is not None and k < last and not plan.payload_changes(k):
                until = k + 1 if progress is not None else self._next_watched(run, k)
                reached = self._wind_in_c(compiled, run, k, min(until, last))
                if not reached.status.valid:
                    return reached.status
                if reached.sample > k:
                    k = reached.sample
                    continue
            status = self._wind_sample(run, sampling, k, save_to)
            if not status.valid:
                return status
            k += 1
        if progress is not None:
            progress(1.0, plan.sample_time(last))
        return SUCCESS

    def _wind_sample(
        self, run: RunState, sampling: Sampling, k: int, save_to: Path | None
    ) -> Status:
        """Record sample k, and exchange until the next; the last one is only recorded."""
        plan = self.plan
        t = plan.sample_time(k)
        with plan.clocks.rope:
            signals = run.readers.signals()
        try:
            run.course = under_safety_circuit(plan, run, t, signals)
        except ValueError as error:
            message = f"t = {t:.6g} s: the stop that the safety circuit asks for: {error}"
            return Status(False, message)
        command = sampling.record_and_command(t, signals)
        if k == run.first and save_to is not None:
            encode(command.state, CONTROLLER, {})  # raise now and not after a long run
        if k == plan.sample_count:
            return SUCCESS
        status = self._exchange(run, k, command)
        if status.valid:
            run.controller = run.commands[-1].state
        return status

    def _wind_in_c(
        self, compiled: CompiledTrip, run: RunState, first: int, last: int
    ) -> SampleReached:
        """Wind samples from ``first`` to before ``last`` in C, and what C leaves of a step."""
        reached = compiled.wind_samples(first, last)
        if not (reached.status.valid and reached.within):
            return reached
        return SampleReached(reached.sample + 1, self._steps(run, reached.sample))

    def _next_watched(self, run: RunState, k: int) -> int:
        """Return the next sample behind k where a state is saved or a payload begins to change."""
        next_save = k + self._save_interval - (k - run.first) % self._save_interval
        return next((j for j in range(k + 1, next_save) if self.plan.payload_changes(j)), next_save)

    def _exchange(self, run: RunState, k: int, command: Command) -> Status:
        """Advance drive and rope from sample k to the next under the command."""
        if not (math.isfinite(command.torque) and math.isfinite(command.brake)):
            t = self.plan.sample_time(k)
            numbers = f"torque = {command.torque:g} N m and brake = {command.brake:g}"
            return Status(
                False,
                f"t = {t:.6g} s: the controller's {numbers} must be finite: check its command()",
            )
        # the rope's forces on conveyances with play are held until the next sample
        side_forces = _NO_FORCES
        if self.plan.hoist.play is not None:
            side_forces = np.nan_to_num(run.readers.side_forces(), nan=0.0)
        run.commands = [command]
        run.drive.command(DriveCommand(command.torque, command.brake), side_forces)
        return self._steps(run, k)

    def _steps(self, run: RunState, k: int) -> Status:
        """Do the communication steps left before sample k + 1."""
        plan = self.plan
        H = plan.coupling.step
        while run.steps < (k + 1) * plan.coupling.per_sample:
            t = plan.coupling.start + run.steps * H
            loaded = plan.loading.hoist_at(run.steps * H)
            if loaded is not None:
                run.drive.plant.reload(loaded)
            try:
                advance = plan.scheme.advance(run.coupled, run.scheme_state, t, H)
            except ParticipantFailed:
                raise
            except Exception as error:  # a mistake in the code, which keeps the record all the same
                kind = type(error).__name__
                _log.exception("t = %.6g s: the step raises %s", t, kind)
                return Status(False, f"t = {t:.6g} s: {kind}: {error}")
            if not advance.status.valid:
                return advance.status
            run.scheme_state = advance.scheme_state
            run.steps += 1
        return SUCCESS

    def _result(self, recording: Recording, steps: int, cause: str, course: Course) -> Result:
        plan = self.plan
        if cause:
            planned = plan.sample_count * plan.coupling.per_sample
            _log.info("co-simulation stopped after %d of %d steps: %s", steps, planned, cause)
        warning = ""
        if self.stability is not None:
            warning = self.stability.warning(plan.coupling.scheme, plan.coupling.step)
        return Result(
            recording=recording,
            completed=not cause,
            cause=cause,
            steps=steps,
            trajectory=course.trajectory,
            winding=course.winding,
            drive_clock=plan.clocks.drive,
            rope_clock=plan.clocks.rope,
            start_clock=plan.clocks.start,
            warning=warning,
        )
