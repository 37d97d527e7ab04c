"""The co-simulation: a controller that samples, and between two samples drive and rope coupled by a scheme.

    controller(t_k) -> record -> scheme over [t_k, t_k + T] in communication steps H -> ... ,      t_k = start + k T.

T is H unless the controller samples less often. A rope or drive that cannot go on, or a coupling that cannot be
solved, ends the loop; what was recorded stays, the result names the cause, and the state at the last sample is kept as
a checkpoint, from which `run` goes on.
"""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from hoist_demo.control.controller import Command, Controller, Gains, Measurement, SpeedController
from hoist_demo.control.reference import Reference, ReferencePoint, s_curve
from hoist_demo.cosimulation.checkpoint import CONTROLLER, Checkpoint
from hoist_demo.cosimulation.participants.partners import HangingPartner, HoistPartner, Stopwatch, input_of
from hoist_demo.cosimulation.participants.rope_plant import EndMotion, RopePlant
from hoist_demo.cosimulation.plain_data import encoded
from hoist_demo.cosimulation.schemes.catalogue import scheme_named
from hoist_demo.cosimulation.schemes.interface import Advance, Load, Memory, Pair
from hoist_demo.cosimulation.schemes.stability import Outlook, measured_answer, outlook
from hoist_demo.drive.plant import (
    SIDE_FORCES,
    HoistPlant,
    PlantInput,
    PlantOutput,
    PlantState,
    energy_residual,
    side_forces,
)
from hoist_demo.parameters import Coupling, Hoist, Winding, require_trip_fits
from hoist_demo.recording.time_series import TIME, Recorder, Recording

_log = logging.getLogger(__name__)

_FIELD = re.compile(r"(\w+)=([^(),]+)[,)]")
"""A single value in the text of a dataclass."""

Progress = Callable[[float, float], bool]
"""Called after every step with the fraction done and the time [s]; False stops the run."""

DRIVE_UNITS = {
    TIME: "s",
    "reference.position": "m",
    "reference.speed": "m/s",
    "reference.acceleration": "m/s2",
    "reference.jerk": "m/s3",
    "conveyance.left.y": "m",
    "conveyance.left.vy": "m/s",
    "conveyance.left.ay": "m/s2",
    "conveyance.right.y": "m",
    "conveyance.right.vy": "m/s",
    "conveyance.right.ay": "m/s2",
    "drive.angle": "rad",
    "drive.rate": "rad/s",
    "drive.torque_command": "N.m",
    "drive.torque": "N.m",
    "drive.torque_limited": "1",
    "drive.motor_power": "W",
    "drive.brake_torque": "N.m",
    "drive.tension_left": "N",
    "drive.tension_right": "N",
    "drive.tension_ratio": "1",
    "drive.slip_safety": "1",
    "drive.work_motor": "J",
    "drive.work_losses": "J",
    "drive.work_rope_damping": "J",
    "drive.work_from_balance_rope": "J",
    "drive.energy_kinetic": "J",
    "drive.energy_potential": "J",
    "drive.energy_residual": "J",
    "coupling.energy": "J",
    "coupling.exchanges": "1",
}


@dataclass(frozen=True)
class Result:
    """What a run leaves behind."""

    recording: Recording
    completed: bool
    cause: str  # "" when completed
    steps: int  # communication steps done
    planned_steps: int
    reference: Reference
    drive_clock: Stopwatch  # of the drive's steps
    rope_clock: Stopwatch  # of the rope's steps, reading its outputs included
    start_clock: Stopwatch  # of the rope's initialization
    warning: str = ""  # of the coupling, before the start
    checkpoint: Checkpoint | None = None  # the last good state, when the run stopped after its first sample
    saved: Path | None = None  # where it was written


@dataclass
class _Run:
    """What changes during a run, at the latest communication point."""

    drive: HoistPartner
    rope: HangingPartner
    controller: Any  # the controller's state
    memory: Memory
    at_rest: PlantOutput  # of the drive, at the start
    recorder: Recorder
    first: int = 0  # sample from which it goes on

    @property
    def pair(self) -> Pair:
        """For the scheme."""
        return Pair(self.drive, self.rope)


@dataclass(frozen=True)
class _Kept:
    """A run's state at one sample; that of the rope as a snapshot in memory."""

    k: int
    drive: tuple[PlantState, PlantInput]
    controller: Any
    memory: Memory
    rope: Any


class Host:
    """Marries a drive and a rope for one trip."""

    def __init__(
        self,
        rope: RopePlant,
        hoist: Hoist | None = None,
        winding: Winding | None = None,
        coupling: Coupling | None = None,
        gains: Gains | None = None,
        controller: Callable[[Hoist, float], Controller] | None = None,
    ) -> None:
        """`controller` makes one's own from the hoist and the motor's torque at rest [N m]; else a speed controller."""
        self.rope = rope
        self.hoist = Hoist() if hoist is None else hoist
        self.winding = Winding() if winding is None else winding
        self.coupling = Coupling() if coupling is None else coupling
        self.scheme = scheme_named(self.coupling.scheme)
        require_trip_fits(self.hoist, self.winding)
        self._gains = gains
        self._controller = partial(SpeedController, gains=gains) if controller is None else controller
        self.plant = HoistPlant(self.hoist)
        self.reference = s_curve(self.winding)
        self.drive_clock, self.rope_clock, self.start_clock = Stopwatch(), Stopwatch(), Stopwatch()
        self.outlook: Outlook | None = None

    @property
    def start_heights(self) -> tuple[float, float]:
        """Heights of left and right conveyance before the trip [m]: the landings, left below when it is to rise."""
        low, high = 0.0, self.hoist.shaft_travel
        return (low, high) if self.winding.travel > 0.0 else (high, low)

    @property
    def data(self) -> str:
        """What must be the same for a run to go on from a checkpoint; scheme and step may change."""
        coupling, made = self.coupling, self._controller
        controller = getattr(made.func if isinstance(made, partial) else made, "__qualname__", "")
        data = (self.hoist, self.winding, self._gains, coupling.start, coupling.sample_time)
        return f"{repr(data)[:-1]}, controller={controller})"

    def run(
        self, progress: Progress | None = None, save_to: Path | None = None, resume: Checkpoint | None = None
    ) -> Result:
        """Wind once; `progress` hears of every sample and may stop the run.

        When the run stops before its end, its last good state is in the result and is written to `save_to`;
        ValueError at the first sample for a controller whose state cannot be written. With `resume` the run goes on
        from such a state, with the same bits as if it had never stopped.
        """
        H, T, start = self.coupling.step, self.coupling.sample_time, self.coupling.start
        samples = math.ceil((self.reference.duration + self.winding.settle) / T - 1e-9)
        run = self._started(resume)
        if isinstance(run, str):
            return self._result(Recorder({}), 0, samples, run)
        controller = self._controller(self.hoist, run.at_rest.torque)
        steps, per_sample = run.first * self.coupling.per_sample, self.coupling.per_sample
        kept: _Kept | None = None
        cause = ""

        for k in range(run.first, samples + 1):
            t = start + k * T
            if k > run.first and k < samples and progress is not None and not progress(k / samples, t):
                cause = f"t = {t:.6g} s: stopped by the user"
            self.rope.free(kept.rope if kept is not None else None)
            kept = _Kept(k, run.drive.save(), run.controller, run.memory, run.rope.save())
            if cause:
                break

            # sample and record
            reference, shown = self.reference.at(t - start), run.drive.output()
            measured = Measurement(shown.y_left - self.start_heights[0], self.hoist.sheave_radius * shown.rate)
            command = controller.command(reference, measured, deepcopy(run.controller), T)
            if k == run.first and save_to is not None:
                encoded(command.state, CONTROLLER)  # told now and not after a long run
            run.recorder.add(self._row(run, t, reference, command, shown))
            if k == samples:
                break
            run.drive.held = replace(
                run.drive.held, torque_command=command.torque, brake=command.brake, **self._side_forces()
            )

            # drive and rope over the same interval
            for j in range(per_sample):
                advance = self._advanced(run, start + (k * per_sample + j) * H, H)
                if cause := advance.cause:
                    break
                run.memory = advance.memory
                steps += 1
            if cause:
                break
            run.controller = command.state

        if not cause and progress is not None:
            progress(1.0, start + samples * T)
        checkpoint = self._checkpoint(run, kept, cause) if cause and kept is not None else None
        self.rope.free(kept.rope if kept is not None else None)
        saved = None
        if checkpoint is not None and save_to is not None:
            try:
                checkpoint.write(save_to)
                saved = save_to
            except ValueError as error:  # the record of the run is worth more
                cause += f"; {save_to} is not written: {error}"
        return replace(self._result(run.recorder, steps, samples, cause), checkpoint=checkpoint, saved=saved)

    def _started(self, resume: Checkpoint | None) -> _Run | str:
        """A run at rest, or as it was when it stopped; the cause when the rope does not hang."""
        start, (y_left, y_right) = self.coupling.start, self.start_heights
        if resume is not None:
            self._require_resumable(resume)
        rope = HangingPartner(self.rope, self.rope_clock)
        if cause := rope.start(start, EndMotion(y=y_left), EndMotion(y=y_right), self.start_clock):
            return cause
        recorder = Recorder(DRIVE_UNITS | {n: u for n, u in self.rope.units().items() if n not in DRIVE_UNITS})
        forces, _ = rope.forces()
        state = self.plant.equilibrium(y_left, y_right, float(forces[0]), float(forces[1]))
        held = input_of(PlantInput(float(state.x[0]), 0.0, 0.0), forces)
        drive = HoistPartner(self.plant, state, held, self.drive_clock)
        if self.hoist.play is not None:
            rope.beside = drive.ends
        run = _Run(drive, rope, None, Pair(drive, rope).start(start), drive.output(), recorder)
        self.outlook = self._outlook(run)
        if resume is not None:
            drive.restore((resume.plant, resume.input))
            snapshot = self.rope.from_bytes(resume.rope)
            rope.restore(snapshot)
            rope.free(snapshot)
            recorder.resume(resume.recording, resume.sample)
            drive.held = resume.input
            run.controller, run.memory, run.at_rest = resume.controller, resume.memory, resume.at_rest
            run.first = resume.sample
        return run

    def _outlook(self, run: _Run) -> Outlook | None:
        """Whether the scheme will be stable, from a trial at rest that is taken back; None where nobody can tell."""
        H, name = self.coupling.step, self.coupling.scheme
        if self.scheme.needs_added_mass and run.rope.added_mass() is None:
            raise ValueError(
                f"scheme = '{name}' needs the rope's added mass, outputs left.added_mass and right.added_mass, "
                "which this rope has not got: take gauss-seidel-1 or iterative-secant"
            )
        if (snapshot := run.rope.save()) is None:
            if self.scheme.needs_rollback:
                raise ValueError(
                    f"scheme = '{name}' takes steps back, but this rope cannot save its state: take semi-implicit-1 "
                    "or gauss-seidel-1, or an FMU with canGetAndSetFMUstate"
                )
            return None
        run.rope.free(snapshot)
        here = run.drive.motion(Load.constant(run.memory.last.force), 1.0)
        answer, cause = measured_answer(run.pair, self.coupling.start, H, here)
        if cause:
            _log.info("the coupling's stability is not known: %s", cause)
            return None
        seen = outlook(self.scheme, answer, run.drive.mobility())
        if warning := seen.warning(name, H):
            _log.warning("%s", warning)
        return seen

    def _side_forces(self) -> dict[str, float]:
        """What the rope does to conveyances that have play, held until the next sample."""
        return side_forces(self.rope.read(SIDE_FORCES)) if self.hoist.play is not None else {}

    def _advanced(self, run: _Run, t: float, h: float) -> Advance:
        """One communication step of the scheme; what it raises is the cause for which the run stops."""
        try:
            return self.scheme.advance(run.pair, run.memory, t, h)
        except (ValueError, RuntimeError) as error:
            return Advance(run.memory, f"t = {t:.6g} s: {error}")

    def _checkpoint(self, run: _Run, kept: _Kept, cause: str) -> Checkpoint:
        rope = b""
        if kept.rope is not None:
            try:
                rope = self.rope.to_bytes(kept.rope)
            except RuntimeError as error:
                _log.warning("the rope's last good state is lost: %s", error)
        return Checkpoint(
            sample=kept.k,
            t=self.coupling.start + kept.k * self.coupling.sample_time,
            plant=kept.drive[0],
            controller=kept.controller,
            input=kept.drive[1],
            at_rest=run.at_rest,
            memory=kept.memory,
            rope=rope,
            recording=run.recorder.recording(),
            data=self.data,
            cause=cause,
        )

    def _require_resumable(self, resume: Checkpoint) -> None:
        if resume.data != self.data:
            raise ValueError(
                f"the checkpoint at t = {resume.t:g} s must be of the same hoist, winding, controller, gains and "
                f"sample time, but {_differences(resume.data, self.data)}: give the scene and the options of that run"
            )
        if not resume.rope:
            raise ValueError(
                f"the checkpoint at t = {resume.t:g} s must hold the rope's state, which its rope could not save: "
                "start anew, or take an FMU with canGetAndSetFMUstate"
            )

    def _result(self, recorder: Recorder, steps: int, samples: int, cause: str) -> Result:
        planned = samples * self.coupling.per_sample
        if cause:
            _log.info("co-simulation stopped after %d of %d steps: %s", steps, planned, cause)
        seen = self.outlook
        return Result(
            recording=recorder.recording(),
            completed=not cause,
            cause=cause,
            steps=steps,
            planned_steps=planned,
            reference=self.reference,
            drive_clock=self.drive_clock,
            rope_clock=self.rope_clock,
            start_clock=self.start_clock,
            warning=seen.warning(self.coupling.scheme, self.coupling.step) if seen is not None else "",
        )

    def _row(
        self, run: _Run, t: float, reference: ReferencePoint, command: Command, shown: PlantOutput
    ) -> dict[str, float]:
        """One line of the recording, in the order of DRIVE_UNITS, then the rope's signals."""
        work = run.drive.state.work
        motor, losses, ropes, left, right = (float(value) for value in work)
        values = (
            t,
            reference.position,
            reference.speed,
            reference.acceleration,
            reference.jerk,
            shown.y_left,
            shown.v_left,
            shown.a_left,
            shown.y_right,
            shown.v_right,
            shown.a_right,
            shown.angle,
            shown.rate,
            command.torque,
            shown.torque,
            float(command.limited),
            shown.power,
            shown.brake_torque,
            shown.tension_left,
            shown.tension_right,
            shown.tension_ratio,
            self.hoist.slip_safety(shown.tension_ratio),
            motor,
            losses,
            ropes,
            left + right,
            shown.energy_kinetic,
            shown.energy_potential,
            energy_residual(run.at_rest, shown, work),
            run.memory.residual,
            float(run.memory.exchanges),
        )
        with self.rope_clock.running():
            signals = self.rope.signals()
        drive = dict(zip(DRIVE_UNITS, values, strict=True))
        return drive | {name: value for name, value in signals.items() if name not in drive}


def _differences(there: str, here: str, most: int = 6) -> str:
    """Which numbers and words differ between the `Host.data` of a checkpoint and of this run."""
    old, new = (_FIELD.findall(data) for data in (there, here))
    changed = [f"{name} is {value} there" for name, value in old if (name, value) not in new]
    changed += [f"{name} is {value} here" for name, value in new if (name, value) not in old]
    changed.sort()
    more = f" and {len(changed) - most} more" if len(changed) > most else ""
    return (", ".join(changed[:most]) or "they differ") + more
