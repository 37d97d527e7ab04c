"""The co-simulation: a controller that samples, and between two samples drive and rope coupled by a scheme.

    controller(t_k) -> record -> scheme over [t_k, t_k + T] in communication steps H -> ... ,      t_k = start + k T.

T is H unless the controller samples less often; where it samples more often, T is H and the drive asks it within its
step. A rope or drive that cannot go on, or a coupling that cannot be solved, ends the loop; what was recorded stays,
and the result names the cause. A guard of the rope that trips, and head ropes that go slack, stop the hoist
(`Course`) at the first sample that sees it. The state is kept every SAVE_INTERVAL, and where the user stops the run,
as a checkpoint, from which `run` goes on.
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
from hoist_demo.cosimulation.compiled_trip import CompiledTrip
from hoist_demo.cosimulation.drive_signals import DRIVE_UNITS, ROW, drive_row, with_drive_signals
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.participants.hoist_partner import HoistPartner, NextCommand
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope
from hoist_demo.cosimulation.plain_data import encode
from hoist_demo.cosimulation.run_state import Result, RunState, TripEnd
from hoist_demo.cosimulation.schemes import interface
from hoist_demo.cosimulation.schemes.catalogue import find_scheme
from hoist_demo.cosimulation.schemes.explicit import GaussSeidel
from hoist_demo.cosimulation.schemes.interface import CoupledSystem, RopePlant, Stopwatch, Vector
from hoist_demo.cosimulation.schemes.stability import StabilityEstimate, predict_stability
from hoist_demo.drive.equations import FORCES, INPUT_NAMES
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.drive.plant import SIDE_FORCES, HoistPlant
from hoist_demo.parameters import Coupling, Hoist, Winding, require_trip_fits, start_heights
from hoist_demo.recording.time_series import Array, Recorder, Recording
from rope_model import EndMotion
from rope_model.compiler import last_words

_log = logging.getLogger(__name__)
#: Called after every step with the fraction done and the time [s]; False stops the run.
Progress = Callable[[float, float], bool]
SAVE_INTERVAL = 5.0  #: Simulated time from one state that is kept to the next [s].
LOADING_PARTS = (
    0.25,
    0.75,
)  #: Parts of a dwell between which the payload changes to that of the next trip [assumed].
_GUARD = ("guard.tripped", "guard.time")
_Y_LEFT, _RATE = OUTPUT_INDEX["y_left"], OUTPUT_INDEX["rate"]
_PULLS = [OUTPUT_INDEX["pull_left"], OUTPUT_INDEX["pull_right"]]
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
        controller: Callable[[Hoist, float], Controller] | None = None,
        *,
        trajectory: Trajectory | None = None,
        scheme: interface.Scheme | None = None,
        after: TripEnd | None = None,
        next_hoist: Hoist | None = None,
    ) -> None:
        """Prepare a trip; None stands for the defaults.

        `controller` makes a controller of the hoist and the motor's torque at rest [N m]; default: SpeedController.
        `trajectory` replaces the winding's S-curve, `scheme` the one that `coupling` names. `after` is the end of the
        trip before with the same rope, which goes on from there; else all begins at rest. `next_hoist` has the payloads
        of the trip that follows: in the middle of this one's dwell they change evenly.
        """
        self.rope = rope
        self.name = ""  # name or file of the hoist, which a checkpoint states
        self.hoist = Hoist() if hoist is None else hoist
        self.winding = Winding() if winding is None else winding
        self.coupling = Coupling() if coupling is None else coupling
        if after is not None:
            self.coupling = replace(self.coupling, start=after.t)
        self._save_interval = max(1, round(SAVE_INTERVAL / self.coupling.period))  # samples
        self.scheme = find_scheme(self.coupling.scheme) if scheme is None else scheme
        self._after = None if after is None else after.with_zeroed_totals()
        self._next_hoist = next_hoist
        require_trip_fits(self.hoist, self.winding)
        self._gains = gains
        self._own = controller is not None
        self._controller = (
            partial(SpeedController, gains=gains) if controller is None else controller
        )
        self.trajectory = s_curve(self.winding) if trajectory is None else trajectory
        self.drive_clock, self.rope_clock, self.start_clock = Stopwatch(), Stopwatch(), Stopwatch()
        self.stability: StabilityEstimate | None = None
        self._start_height, _ = self.start_heights

    @property
    def start_heights(self) -> tuple[float, float]:
        """Heights of left and right conveyance before the trip [m]: where the one before has ended, or the landings."""
        if self._after is None:
            return start_heights(self.hoist, self.winding)
        return self._after.landing, self.hoist.shaft_travel - self._after.landing

    @property
    def samples(self) -> int:
        """Number of the controller's samples in the whole run, the first not counted."""
        return math.ceil(
            (self.trajectory.duration + self.winding.settle) / self.coupling.period - 1e-9
        )

    @property
    def data(self) -> str:
        """Data that a checkpoint and the run that continues it must share; scheme and step may change."""
        coupling = self.coupling
        made = self._controller
        controller = getattr(made.func if isinstance(made, partial) else made, "__qualname__", "")
        data = (self.hoist, self.winding, self._gains, coupling.start, coupling.sample_time)
        recorded = f", period={coupling.period}" if coupling.per_step > 1 else ""
        return f"{repr(data)[:-1]}{recorded}, controller={controller})"

    def run(
        self,
        progress: Progress | None = None,
        save_to: Path | None = None,
        resume: Checkpoint | None = None,
    ) -> Result:
        """Wind once; `progress` hears of every sample and may stop the run.

        When the run stops before its end, its last good state is in the result and is written to `save_to`;
        ValueError at the first sample for a controller whose state cannot be written. With `resume` the run goes on
        from such a state, with the same bits as if it had never stopped.
        """
        if resume is not None:
            resume.require_fits(self.data)
        run = self._start()
        if isinstance(run, str):
            return self._result(Recording({}, {}), 0, run, self._course)
        if resume is not None:
            run.coupled.restore(((resume.plant, resume.input), self.rope.from_bytes(resume.rope)))
            run.recorder.resume(resume.recording, resume.sample)
            run.controller, run.scheme_state = deepcopy(resume.controller), resume.scheme_state
            run.first = resume.sample
            run.steps = resume.sample * self.coupling.per_sample
        cause = self._wind(run, progress, save_to)
        checkpoint = self._checkpoint(run, cause) if cause else None
        saved = end = None
        if checkpoint is not None and save_to is not None:
            try:
                checkpoint.write(save_to)
                saved = save_to
            except (ValueError, OSError) as error:  # keep the record of the run all the same
                cause += f"; {save_to} is not written: {error}"
        if not cause and run.course == self._course:
            t = self.coupling.start + self.samples * self.coupling.period
            landing = self._start_height + self.trajectory.points[-1].position
            end = TripEnd(t, landing, run.drive.state, run.drive.input, run.scheme_state)
        result = self._result(
            with_drive_signals(run.recorder.recording(), self.hoist), run.steps, cause, run.course
        )
        return replace(result, checkpoint=checkpoint, saved=saved, end=end)

    def _start(self) -> RunState | str:
        """Return the run at rest, or behind another trip; a cause if the rope does not hang."""
        start, heights, after = self.coupling.start, self.start_heights, self._after
        read = self.rope.reader(interface.ROPE_FORCES)
        if after is None:
            with self.start_clock:
                status = self.rope.initialize(start, *(EndMotion(y=y) for y in heights))
                forces = interface.forces_or_error(status, read)
            if isinstance(forces, str):
                return f"rope, at the start: {forces}"
        else:
            forces = read()
        plant = HoistPlant(self.hoist)
        rest = plant.equilibrium(*heights, *forces[:2].tolist())
        state = rest
        applied_input = np.zeros(len(INPUT_NAMES))
        applied_input[0], applied_input[list(FORCES)] = rest.x[0], forces[:2]
        if after is not None:
            state, applied_input = after.plant, after.input
        drive = HoistPartner(plant, state, applied_input, self.drive_clock)
        coupled = CoupledSystem(drive, self.rope, self.rope_clock)
        scheme_state = coupled.start(start) if after is None else after.scheme_state
        if after is None:
            self.stability = predict_stability(
                self.scheme, self.coupling.scheme, coupled, start, self.coupling.step
            )
        return RunState(
            drive, coupled, scheme_state, rest.x.item(0), self._recorder(), self._course
        )

    def _checkpoint(self, run: RunState, cause: str) -> Checkpoint | None:
        """Return the saved state with the cause of the stop; None if no state was saved."""
        if run.saved is None:
            return None
        k, ((plant, drive_input), snapshot), controller, scheme_state = run.saved
        rope = b""
        t = self.coupling.start + k * self.coupling.period
        if snapshot is not None:
            try:
                rope = self.rope.to_bytes(snapshot)
            except RuntimeError as error:
                _log.warning("the rope's last good state is lost: %s", error)
        record = run.recorder.recording()
        return Checkpoint(
            k,
            t,
            plant,
            controller,
            drive_input,
            scheme_state,
            rope,
            record,
            self.data,
            cause,
            self.name,
        )

    def _recorder(self) -> Recorder:
        """Return a recorder of all signals, without those of the rope that the drive has too."""
        units = self.rope.units()
        names = [name for name in units if name not in DRIVE_UNITS]
        self._read_signals, self._read_sides = (
            self.rope.reader(names),
            self.rope.reader(SIDE_FORCES),
        )
        self._guard = tuple(names.index(name) for name in _GUARD if name in names)
        return Recorder([*ROW, *names], units | DRIVE_UNITS, self.samples + 1)

    def _wind(self, run: RunState, progress: Progress | None, save_to: Path | None) -> str:
        """Sample and exchange until the end; the cause when that is not reached."""
        controller = _made(self._controller, self.hoist, run.holding_torque)
        start, T, last = self.coupling.start, self.coupling.period, self.samples
        if self.coupling.per_step > 1:
            run.drive.per_step, run.drive.next_command = (
                self.coupling.per_step,
                self._sampler(run, controller),
            )
        compiled = self._compiled(run)
        k = run.first
        while k <= last:
            t = start + k * T
            stopped = run.first < k < last and progress is not None and not progress(k / last, t)
            if stopped or (k - run.first) % self._save_interval == 0:
                run.saved = None  # frees the memory of the state before
                # the controller may change what it is handed
                run.saved = k, run.coupled.save(), deepcopy(run.controller), run.scheme_state
            if stopped:
                return f"t = {t:.6g} s: stopped by the user"
            if compiled is not None and k < last and not self._payload_changes(k):
                until = k + 1 if progress is not None else self._next_watched(run, k)
                reached, cause, within = compiled.samples(k, min(until, last))
                cause = cause or (self._steps(run, reached) if within else "")
                if cause:
                    return cause
                following = reached + 1 if within else reached
                if following > k:
                    k = following
                    continue
            with self.rope_clock:
                signals = self._read_signals()
            try:
                run.course = self._under_safety_circuit(run, t, signals)
            except ValueError as error:
                return f"t = {t:.6g} s: the stop that the safety circuit asks for: {error}"
            command = self._sample(run, controller, t, signals)
            if k == run.first and save_to is not None:
                encode(command.state, CONTROLLER, {})  # raise now and not after a long run
            if k < last:
                if cause := self._exchange(run, k, command):
                    return cause
                run.controller = run.commands[-1].state
            k += 1
        if progress is not None:
            progress(1.0, start + last * T)
        return ""

    def _next_watched(self, run: RunState, k: int) -> int:
        """Return the next sample behind k at which a state is saved or a payload begins to change."""
        next_save = k + self._save_interval - (k - run.first) % self._save_interval
        return next((j for j in range(k + 1, next_save) if self._payload_changes(j)), next_save)

    def _compiled(self, run: RunState) -> CompiledTrip | None:
        """Return the trip in C; None for a run that only this host winds."""
        rope, scheme = self.rope, self.scheme
        # a rope of another class may do more in its steps than its library
        library = rope.library() if type(rope) is FmuRope or type(rope) is InProcessRope else None
        plain = type(scheme) is GaussSeidel and scheme.order == 1 and not self._own
        compiled = run.drive.plant.stick_integrator.kernels.library is not None
        if library is None or not (plain and compiled) or self.hoist.lining is not None:
            return None
        gains, clocks, most = (
            self._gains or Gains(),
            (self.drive_clock, self.rope_clock),
            self._save_interval,
        )
        try:
            return CompiledTrip(
                run, library, self.hoist, gains, self.coupling, self._start_height, clocks, most
            )
        except (OSError, RuntimeError, CalledProcessError) as error:
            _log.warning("the trip is wound in Python, four times as long: %s", last_words(error))
            return None

    def _under_safety_circuit(self, run: RunState, t: float, signals: Array) -> Course:
        """Return the course at t [s], with an emergency stop if the safety circuit opens."""
        course, start, T, least = (
            run.course,
            self.coupling.start,
            self.coupling.period,
            self.hoist.slack_tension,
        )
        if least is not None and min(run.drive.outputs[_PULLS]) < least:
            course = course.with_emergency_stop(t - start)
        if not self._guard or not signals.item(self._guard[0]) > 0.0:
            return course
        time = signals.item(self._guard[1])
        return course.with_emergency_stop(
            start + T * max(0, math.ceil((time - start) / T - 1e-9)) - start
        )

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
        """Ask the controller for its command, by the reference and the OUTPUTS of the drive."""
        travel = outputs.item(_Y_LEFT) - self._start_height
        speed = self.hoist.sheave_radius * outputs.item(_RATE)
        command = controller.command(
            point, Measurement(travel, speed), state, self.coupling.sample_time
        )
        if not isinstance(command, Command):
            raise ValueError(
                f"command() must return Command(torque, limited, state), not {type(command).__name__}"
            )
        return command

    def _sampler(self, run: RunState, controller: Controller) -> NextCommand:
        """Return the sampler of the controller within a communication step."""

        def next_command(k: int, t: float, outputs: Vector) -> tuple[float, float]:
            point = run.course.trajectory.at(t - self.coupling.start)
            # the step may be repeated, from the command before
            command = self._command(controller, point, outputs, deepcopy(run.commands[k - 1].state))
            run.commands[k:] = [command]
            return command.torque, command.brake

        return next_command

    def _exchange(self, run: RunState, k: int, command: Command) -> str:
        """Advance drive and rope from sample k to the next under the command; "" or the cause of a failure."""
        if not (math.isfinite(command.torque) and math.isfinite(command.brake)):
            t = self.coupling.start + k * self.coupling.period
            numbers = f"torque = {command.torque:g} N m and brake = {command.brake:g}"
            return f"t = {t:.6g} s: the controller's {numbers} must be finite: check its command()"
        # the rope's forces on conveyances with play are held until the next sample
        sides = (
            np.nan_to_num(self._read_sides(), nan=0.0)
            if self.hoist.play is not None
            else _NO_FORCES
        )
        run.commands = [command]
        run.drive.command(command.torque, command.brake, sides)
        return self._steps(run, k)

    def _steps(self, run: RunState, k: int) -> str:
        """Do the communication steps left before sample k + 1; return the cause of a failure, else ""."""
        start, H, per_sample = self.coupling.start, self.coupling.step, self.coupling.per_sample
        while run.steps < (k + 1) * per_sample:
            t = start + run.steps * H
            self._set_payloads(run.drive.plant, run.steps * H)
            try:
                scheme_state, cause = self.scheme.advance(run.coupled, run.scheme_state, t, H)
            except (ValueError, RuntimeError) as error:
                return f"t = {t:.6g} s: {error}"
            if cause:
                return cause
            run.scheme_state = scheme_state
            run.steps += 1
        return ""

    def _payload_changes(self, k: int) -> bool:
        """Return True if a payload changes in a step between sample k and the next."""
        first, last = (
            self.trajectory.duration + part * self.winding.settle for part in LOADING_PARTS
        )
        return (
            self._next_hoist is not None
            and first < (k + 1) * self.coupling.period < last + 2 * self.coupling.period
        )

    def _set_payloads(self, plant: HoistPlant, t: float) -> None:
        """Change the payloads before a step that begins t [s] after the start, in the middle of the dwell.

        Rarer changes would be stairs in the acceleration, which the rope takes for a table that is too coarse.
        """
        dwelt = t - self.trajectory.duration
        if self._next_hoist is not None and dwelt > LOADING_PARTS[0] * self.winding.settle:
            first, last = (part * self.winding.settle for part in LOADING_PARTS)
            part, now, then = (
                min((dwelt - first) / (last - first), 1.0),
                self.hoist,
                self._next_hoist,
            )
            left = now.payload_left + part * (then.payload_left - now.payload_left)
            right = now.payload_right + part * (then.payload_right - now.payload_right)
            plant.reload(replace(now, payload_left=left, payload_right=right))

    def _result(self, recording: Recording, steps: int, cause: str, course: Course) -> Result:
        if cause:
            planned = self.samples * self.coupling.per_sample
            _log.info("co-simulation stopped after %d of %d steps: %s", steps, planned, cause)
        seen = self.stability
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
            warning=seen.warning(self.coupling.scheme, self.coupling.step)
            if seen is not None
            else "",
        )


def _made(
    make: Callable[[Hoist, float], Controller], hoist: Hoist, holding_torque: float
) -> Controller:
    """Make the controller of a run; ValueError if ``make`` is no class or function, or it gives no commands."""
    if not callable(make):
        raise ValueError(
            f"controller must be a class, or a function of hoist and holding torque, not a {type(make).__name__} made "
            f"already: give the class, or lambda hoist, torque: {type(make).__name__}(...)"
        )
    controller = make(hoist, holding_torque)
    if not callable(getattr(controller, "command", None)):
        raise ValueError(
            f"a controller needs the method command(reference, measured, state, h), and {type(controller).__name__} "
            "has none: see hoist_demo.control.controller.Controller"
        )
    return controller
