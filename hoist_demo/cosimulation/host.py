"""The co-simulation: a controller that samples, and drive and rope coupled between two samples.

    controller(t_k) -> record -> scheme over [t_k, t_k + T] in communication steps H -> ... ,
    t_k = start + k T.

T is H unless the controller samples less often; where it samples more often, T is H and the drive
calls it within its step. A rope or drive that cannot go on, or a coupling that cannot be solved,
ends the loop; the record stays, and the result names the cause. A guard of the rope that trips, and
head ropes that go slack, stop the hoist (`Course`) at the next sample. The state is saved every
SAVE_INTERVAL, and where the user stops the run, as a checkpoint, from which `run` goes on.
"""

import logging
import math
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from functools import partial
from pathlib import Path
from subprocess import CalledProcessError
from typing import Any

import numpy as np

from hoist_demo.control.controller import Command, Controller, Gains, Measurement, SpeedController
from hoist_demo.control.trajectory import Course, Trajectory, TrajectoryPoint, s_curve
from hoist_demo.cosimulation.checkpoint import CONTROLLER, Checkpoint
from hoist_demo.cosimulation.compiled_trip import CompiledTrip, SampleReached, TripData
from hoist_demo.cosimulation.drive_signals import DRIVE_UNITS, ROW, drive_row, with_drive_signals
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.participants.hoist_partner import (
    DriveCommand,
    HoistPartner,
    NextCommand,
)
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope
from hoist_demo.cosimulation.participants.plain_data import encode
from hoist_demo.cosimulation.run_state import (
    Result,
    RopeReaders,
    RunState,
    SavedState,
    TripEnd,
)
from hoist_demo.cosimulation.schemes import interface
from hoist_demo.cosimulation.schemes.catalogue import find_scheme
from hoist_demo.cosimulation.schemes.explicit import GaussSeidel
from hoist_demo.cosimulation.schemes.interface import (
    SUCCESS,
    CoupledSystem,
    RopePlant,
    Stopwatch,
    Vector,
)
from hoist_demo.cosimulation.schemes.stability import StabilityEstimate, predict_stability
from hoist_demo.drive.equations import FORCES, INPUT_NAMES
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.drive.plant import SIDE_FORCES, HoistPlant
from hoist_demo.parameters import Coupling, Hoist, Winding, require_trip_fits, start_heights
from hoist_demo.recording.time_series import Array, Recorder, Recording
from rope_model import EndMotion, Status
from rope_model.compiler import last_words

_log = logging.getLogger(__name__)
#: Called after every step with the fraction done and the time [s]; False stops the run.
Progress = Callable[[float, float], bool]
ControllerFactory = Callable[[Hoist, float], Controller]
SAVE_INTERVAL = 5.0  #: Simulated time from one saved state to the next [s].
#: Parts of a dwell between which the payload changes to that of the next trip [assumed].
LOADING_PARTS = (0.25, 0.75)
_ROUNDING = 1e-9  #: Part of a sample by which rounding alone may exceed a whole number of them.
_GUARD_TRIPPED = "guard.tripped"
_GUARD_TIME = "guard.time"
_Y_LEFT = OUTPUT_INDEX["y_left"]
_RATE = OUTPUT_INDEX["rate"]
_PULLS = [OUTPUT_INDEX["pull_left"], OUTPUT_INDEX["pull_right"]]
_NO_FORCES = np.zeros(len(SIDE_FORCES))


class StartFailed(Exception):
    """The rope does not hang at the start of a run."""


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
        scheme: interface.Scheme | None = None,
        after: TripEnd | None = None,
        next_hoist: Hoist | None = None,
    ) -> None:
        """Prepare a trip; None stands for the defaults.

        `controller` makes a controller of the hoist and the motor's torque at rest [N m]; default:
        SpeedController. `trajectory` replaces the winding's S-curve, `scheme` the one that
        `coupling` names. `after` is the end of the trip before with the same rope, which goes on
        from there; else all begins at rest. `next_hoist` has the payloads of the trip that follows:
        in the middle of this one's dwell they change evenly.
        """
        self.rope = rope
        self.name = ""  # name or file of the hoist, which a checkpoint states
        self.hoist = hoist or Hoist()
        self.winding = winding or Winding()
        self.coupling = coupling or Coupling()
        self._after: TripEnd | None = None
        if after is not None:
            self.coupling = replace(self.coupling, start=after.t)
            self._after = after.with_zeroed_totals()
        self._save_interval = max(1, round(SAVE_INTERVAL / self.coupling.period))  # samples
        self.scheme = scheme or find_scheme(self.coupling.scheme)
        self._next_hoist = next_hoist
        require_trip_fits(self.hoist, self.winding)
        self._gains = gains
        self._has_custom_controller = controller is not None
        if controller is None:
            controller = partial(SpeedController, gains=gains)
        self._controller = controller
        self.trajectory = trajectory or s_curve(self.winding)
        self.drive_clock = Stopwatch()
        self.rope_clock = Stopwatch()
        self.start_clock = Stopwatch()
        self.stability: StabilityEstimate | None = None
        self._start_height, _ = self.start_heights

    @property
    def start_heights(self) -> tuple[float, float]:
        """Heights of left and right conveyance before the trip [m].

        They are the landings, or where the trip before has ended.
        """
        if self._after is None:
            return start_heights(self.hoist, self.winding)
        return self._after.landing, self.hoist.shaft_travel - self._after.landing

    @property
    def samples(self) -> int:
        """Number of the controller's samples in the whole run, the first not counted."""
        duration = self.trajectory.duration + self.winding.settle
        return math.ceil(duration / self.coupling.period - _ROUNDING)

    @property
    def data(self) -> str:
        """Data that a checkpoint and the run that continues it share.

        Scheme and step may change.
        """
        coupling = self.coupling
        factory = self._controller
        if isinstance(factory, partial):
            factory = factory.func
        controller = getattr(factory, "__qualname__", "")
        data = (self.hoist, self.winding, self._gains, coupling.start, coupling.sample_time)
        recorded = ""
        if coupling.per_step > 1:
            recorded = f", period={coupling.period}"
        return f"{repr(data)[:-1]}{recorded}, controller={controller})"

    def run(
        self,
        progress: Progress | None = None,
        save_to: Path | None = None,
        resume: Checkpoint | None = None,
    ) -> Result:
        """Wind once; `progress` is called at every sample and may stop the run.

        When the run stops before its end, its last good state is in the result and is written to
        `save_to`; ValueError at the first sample for a controller whose state cannot be written.
        With `resume` the run goes on from such a state, with the same bits as if it had never
        stopped.
        """
        if resume is not None:
            resume.require_fits(self.data)
        try:
            run = self._start()
        except StartFailed as failure:
            return self._result(Recording({}, {}), steps=0, cause=str(failure), course=self._course)
        if resume is not None:
            self._go_to(run, resume)
        cause = self._wind(run, progress, save_to).message
        checkpoint = saved = end = None
        if cause:
            checkpoint = self._checkpoint(run, cause)
        if checkpoint is not None and save_to is not None:
            try:
                checkpoint.write(save_to)
                saved = save_to
            except (ValueError, OSError) as error:  # keep the record of the run all the same
                cause += f"; {save_to} is not written: {error}"
        if not cause and run.course == self._course:
            end = self._trip_end(run)
        recording = with_drive_signals(run.recorder.recording(), self.hoist)
        result = self._result(recording, run.steps, cause, run.course)
        return replace(result, checkpoint=checkpoint, saved=saved, end=end)

    def _start(self) -> RunState:
        """Return the run at rest, or behind another trip; StartFailed if the rope does not hang."""
        start = self.coupling.start
        heights = self.start_heights
        after = self._after
        read = self.rope.reader(interface.ROPE_FORCES)
        forces = self._hanging_forces(read) if after is None else read()
        plant = HoistPlant(self.hoist)
        rest = plant.equilibrium(*heights, *forces[:2].tolist())
        state = rest
        applied_input = np.zeros(len(INPUT_NAMES))
        applied_input[0] = rest.x[0]
        applied_input[list(FORCES)] = forces[:2]
        if after is not None:
            state = after.plant
            applied_input = after.input
        drive = HoistPartner(plant, state, applied_input, self.drive_clock)
        coupled = CoupledSystem(drive, self.rope, self.rope_clock)
        if after is not None:
            scheme_state = after.scheme_state
        else:
            scheme_state = coupled.start(start)
            self.stability = predict_stability(
                self.scheme, self.coupling.scheme, coupled, start, self.coupling.step
            )
        recorder, readers = self._record()
        return RunState(
            drive=drive,
            coupled=coupled,
            scheme_state=scheme_state,
            holding_torque=rest.x.item(0),
            recorder=recorder,
            readers=readers,
            course=self._course,
        )

    def _hanging_forces(self, read: interface.Reader) -> Vector:
        """Let the rope hang at rest; return its ROPE_FORCES, or raise StartFailed."""
        left, right = (EndMotion(y=height) for height in self.start_heights)
        with self.start_clock:
            status = self.rope.initialize(self.coupling.start, left, right)
            response = interface.read_response(status, read)
        if response.forces is None:
            raise StartFailed(f"rope, at the start: {response.status.message}")
        return response.forces

    def _go_to(self, run: RunState, checkpoint: Checkpoint) -> None:
        """Put the run into the state of a checkpoint."""
        drive_state = (checkpoint.plant, checkpoint.input)
        run.coupled.restore((drive_state, self.rope.from_bytes(checkpoint.rope)))
        run.recorder.resume(checkpoint.recording, checkpoint.sample)
        run.controller = deepcopy(checkpoint.controller)
        run.scheme_state = checkpoint.scheme_state
        if checkpoint.emergency_at is not None:
            # what opened the safety circuit may be over
            run.course = run.course.with_emergency_stop(checkpoint.emergency_at)
        run.first = checkpoint.sample
        run.steps = checkpoint.sample * self.coupling.per_sample

    def _trip_end(self, run: RunState) -> TripEnd:
        """Return the end of a completed trip."""
        return TripEnd(
            t=self.coupling.start + self.samples * self.coupling.period,
            landing=self._start_height + self.trajectory.points[-1].position,
            plant=run.drive.state,
            input=run.drive.input,
            scheme_state=run.scheme_state,
        )

    def _checkpoint(self, run: RunState, cause: str) -> Checkpoint | None:
        """Return the saved state with the cause of the stop; None if no state was saved."""
        saved = run.saved
        if saved is None:
            return None
        (plant, drive_input), snapshot = saved.partners
        rope = b""
        if snapshot is not None:
            try:
                rope = self.rope.to_bytes(snapshot)
            except RuntimeError as error:
                _log.warning("the rope's last good state is lost: %s", error)
        return Checkpoint(
            sample=saved.sample,
            t=self.coupling.start + saved.sample * self.coupling.period,
            plant=plant,
            controller=saved.controller,
            input=drive_input,
            scheme_state=saved.scheme_state,
            rope=rope,
            recording=run.recorder.recording(),
            data=self.data,
            cause=cause,
            hoist=self.name,
            emergency_at=saved.emergency_at,
        )

    def _record(self) -> tuple[Recorder, RopeReaders]:
        """Return a recorder of all signals, and readers of the rope's signals in it.

        A signal of the rope that the drive has, too, is recorded once, from the drive.
        """
        units = self.rope.units()
        names = [name for name in units if name not in DRIVE_UNITS]
        readers = RopeReaders(
            signals=self.rope.reader(names),
            side_forces=self.rope.reader(SIDE_FORCES),
            guard_tripped=names.index(_GUARD_TRIPPED) if _GUARD_TRIPPED in names else None,
            guard_time=names.index(_GUARD_TIME) if _GUARD_TIME in names else None,
        )
        return Recorder([*ROW, *names], units | DRIVE_UNITS, self.samples + 1), readers

    def _wind(self, run: RunState, progress: Progress | None, save_to: Path | None) -> Status:
        """Sample and exchange until the end, or until a step fails or `progress` stops the run."""
        controller = _make_controller(self._controller, self.hoist, run.holding_torque)
        last = self.samples
        if self.coupling.per_step > 1:
            run.drive.per_step = self.coupling.per_step
            run.drive.next_command = self._sampler(run, controller)
        compiled = self._compiled(run)
        k = run.first
        while k <= last:
            t = self._sample_time(k)
            stopped = run.first < k < last and progress is not None and not progress(k / last, t)
            if stopped or (k - run.first) % self._save_interval == 0:
                self._save(run, k)
            if stopped:
                return Status(False, f"t = {t:.6g} s: stopped by the user")
            if compiled is not None and k < last and not self._payload_changes(k):
                until = k + 1 if progress is not None else self._next_watched(run, k)
                reached = self._samples_in_c(compiled, run, k, min(until, last))
                if not reached.status.valid:
                    return reached.status
                if reached.sample > k:
                    k = reached.sample
                    continue
            with self.rope_clock:
                signals = run.readers.signals()
            try:
                run.course = self._under_safety_circuit(run, t, signals)
            except ValueError as error:
                message = f"t = {t:.6g} s: the stop that the safety circuit asks for: {error}"
                return Status(False, message)
            command = self._sample(run, controller, t, signals)
            if k == run.first and save_to is not None:
                encode(command.state, CONTROLLER, {})  # raise now and not after a long run
            if k < last:
                status = self._exchange(run, k, command)
                if not status.valid:
                    return status
                run.controller = run.commands[-1].state
            k += 1
        if progress is not None:
            progress(1.0, self._sample_time(last))
        return SUCCESS

    def _sample_time(self, k: int) -> float:
        """Return the time of the recorded sample k [s]."""
        return self.coupling.start + k * self.coupling.period

    def _save(self, run: RunState, k: int) -> None:
        """Save the state at sample k."""
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

    def _samples_in_c(
        self, compiled: CompiledTrip, run: RunState, first: int, last: int
    ) -> SampleReached:
        """Wind samples from `first` to before `last` in C, and the rest of a step that C leaves."""
        reached = compiled.samples(first, last)
        if not (reached.status.valid and reached.within):
            return reached
        return SampleReached(reached.sample + 1, self._steps(run, reached.sample))

    def _next_watched(self, run: RunState, k: int) -> int:
        """Return the next sample behind k where a state is saved or a payload begins to change."""
        next_save = k + self._save_interval - (k - run.first) % self._save_interval
        return next((j for j in range(k + 1, next_save) if self._payload_changes(j)), next_save)

    def _compiled(self, run: RunState) -> CompiledTrip | None:
        """Return the trip in C; None for a run that only this host winds."""
        rope = self.rope
        # a rope of another class may do more in its steps than its library
        if type(rope) is FmuRope or type(rope) is InProcessRope:
            library = rope.library()
        else:
            library = None
        if library is None or not self._can_be_compiled(run):
            return None
        data = TripData(
            hoist=self.hoist,
            gains=self._gains or Gains(),
            coupling=self.coupling,
            start_height=self._start_height,
            drive_clock=self.drive_clock,
            rope_clock=self.rope_clock,
            max_samples=self._save_interval,
        )
        try:
            return CompiledTrip(run, library, data)
        except (OSError, RuntimeError, CalledProcessError) as error:
            _log.warning("the trip is wound in Python, four times as long: %s", last_words(error))
            return None

    def _can_be_compiled(self, run: RunState) -> bool:
        """Return True if trip.c has scheme, controller and hoist of this run."""
        scheme = self.scheme
        return (
            type(scheme) is GaussSeidel
            and scheme.order == 1
            and not self._has_custom_controller
            and run.drive.plant.stick_integrator.kernels.library is not None
            and self.hoist.lining is None
        )

    def _under_safety_circuit(self, run: RunState, t: float, signals: Array) -> Course:
        """Return the course at t [s], with an emergency stop if the safety circuit opens."""
        course = run.course
        start = self.coupling.start
        period = self.coupling.period
        slack_tension = self.hoist.slack_tension
        if slack_tension is not None and min(run.drive.outputs[_PULLS]) < slack_tension:
            course = course.with_emergency_stop(t - start)
        tripped, time = run.readers.guard_tripped, run.readers.guard_time
        if tripped is None or time is None or not signals.item(tripped) > 0.0:
            return course
        samples = max(0, math.ceil((signals.item(time) - start) / period - _ROUNDING))
        return course.with_emergency_stop(start + period * samples - start)

    @property
    def _course(self) -> Course:
        return Course(self.trajectory, self.winding)

    def _sample(self, run: RunState, controller: Controller, t: float, signals: Array) -> Command:
        """Record all signals at t [s] and return the controller's command."""
        point = run.course.trajectory.at(t - self.coupling.start)
        command = self._command(controller, point, run.drive.outputs, run.controller)
        run.recorder.add(*drive_row(t, point, command, run.drive, run.scheme_state), signals)
        return command

    def _command(
        self, controller: Controller, point: TrajectoryPoint, outputs: Vector, state: Any
    ) -> Command:
        """Return the controller's command, by the reference and the OUTPUTS of the drive."""
        travel = outputs.item(_Y_LEFT) - self._start_height
        speed = self.hoist.sheave_radius * outputs.item(_RATE)
        measured = Measurement(travel, speed)
        command = controller.command(point, measured, state, self.coupling.sample_time)
        if not isinstance(command, Command):
            kind = type(command).__name__
            raise ValueError(f"command() must return Command(torque, limited, state), not {kind}")
        return command

    def _sampler(self, run: RunState, controller: Controller) -> NextCommand:
        """Return the sampler of the controller within a communication step."""

        def next_command(k: int, t: float, outputs: Vector) -> DriveCommand:
            point = run.course.trajectory.at(t - self.coupling.start)
            # the step may be repeated, from the command before
            state = deepcopy(run.commands[k - 1].state)
            command = self._command(controller, point, outputs, state)
            run.commands[k:] = [command]
            return DriveCommand(command.torque, command.brake)

        return next_command

    def _exchange(self, run: RunState, k: int, command: Command) -> Status:
        """Advance drive and rope from sample k to the next under the command."""
        if not (math.isfinite(command.torque) and math.isfinite(command.brake)):
            t = self._sample_time(k)
            numbers = f"torque = {command.torque:g} N m and brake = {command.brake:g}"
            return Status(
                False,
                f"t = {t:.6g} s: the controller's {numbers} must be finite: check its command()",
            )
        # the rope's forces on conveyances with play are held until the next sample
        side_forces = _NO_FORCES
        if self.hoist.play is not None:
            side_forces = np.nan_to_num(run.readers.side_forces(), nan=0.0)
        run.commands = [command]
        run.drive.command(DriveCommand(command.torque, command.brake), side_forces)
        return self._steps(run, k)

    def _steps(self, run: RunState, k: int) -> Status:
        """Do the communication steps left before sample k + 1."""
        H = self.coupling.step
        while run.steps < (k + 1) * self.coupling.per_sample:
            t = self.coupling.start + run.steps * H
            self._set_payloads(run.drive.plant, run.steps * H)
            try:
                advance = self.scheme.advance(run.coupled, run.scheme_state, t, H)
            except (ValueError, RuntimeError) as error:
                return Status(False, f"t = {t:.6g} s: {error}")
            if not advance.status.valid:
                return advance.status
            run.scheme_state = advance.scheme_state
            run.steps += 1
        return SUCCESS

    def _payload_changes(self, k: int) -> bool:
        """Return True if a payload changes in a step between sample k and the next."""
        if self._next_hoist is None:
            return False
        period = self.coupling.period
        first, last = (
            self.trajectory.duration + part * self.winding.settle for part in LOADING_PARTS
        )
        return first < (k + 1) * period < last + 2 * period

    def _set_payloads(self, plant: HoistPlant, t: float) -> None:
        """Change the payloads before a step that begins t [s] after the start, as the hoist dwells.

        Rarer changes would be stairs in the acceleration, which the rope takes for a table that is
        too coarse.
        """
        dwelt = t - self.trajectory.duration
        first, last = (part * self.winding.settle for part in LOADING_PARTS)
        if self._next_hoist is None or dwelt <= first:
            return
        part = min((dwelt - first) / (last - first), 1.0)
        now = self.hoist
        next_hoist = self._next_hoist
        left = now.payload_left + part * (next_hoist.payload_left - now.payload_left)
        right = now.payload_right + part * (next_hoist.payload_right - now.payload_right)
        plant.reload(replace(now, payload_left=left, payload_right=right))

    def _result(self, recording: Recording, steps: int, cause: str, course: Course) -> Result:
        if cause:
            planned = self.samples * self.coupling.per_sample
            _log.info("co-simulation stopped after %d of %d steps: %s", steps, planned, cause)
        warning = ""
        if self.stability is not None:
            warning = self.stability.warning(self.coupling.scheme, self.coupling.step)
        return Result(
            recording=recording,
            completed=not cause,
            cause=cause,
            steps=steps,
            trajectory=course.trajectory,
            winding=course.winding,
            drive_clock=self.drive_clock,
            rope_clock=self.rope_clock,
            start_clock=self.start_clock,
            warning=warning,
        )


def _make_controller(make: ControllerFactory, hoist: Hoist, holding_torque: float) -> Controller:
    """Make the controller of a run.

    Raises ValueError if `make` is no class or function, or makes an object that gives no commands.
    """
    if not callable(make):
        kind = type(make).__name__
        raise ValueError(
            "controller must be a class, or a function of hoist and holding torque, "
            f"not a {kind} made already: give the class, or lambda hoist, torque: {kind}(...)"
        )
    controller = make(hoist, holding_torque)
    if not callable(getattr(controller, "command", None)):
        raise ValueError(
            "a controller needs the method command(reference, measured, state, h), "
            f"and {type(controller).__name__} has none: "
            "see hoist_demo.control.controller.Controller"
        )
    return controller
