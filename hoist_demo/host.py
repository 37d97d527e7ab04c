"""The co-simulation loop: drive and balance rope, one after the other (Gauss-Seidel).

    controller(t_k) -> drive over [t_k, t_k + H] with the rope's mean force of the last step held
                    -> motion of the ends at t_k + H -> rope over the same step -> record,       t_k = start + k H.

The mean force is fed back because it carries the impulse of the step, which the force at its end does not.
A rope or drive that cannot go on ends the loop; what was recorded stays, and the result names the cause.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from hoist_demo.controller import Command, ControllerState, Gains, Measurement, SpeedController
from hoist_demo.parameters import Coupling, Hoist, Winding, require_trip_fits
from hoist_demo.plant import HoistPlant, PlantInput, PlantOutput, PlantState, energy_residual
from hoist_demo.recording import TIME, Recorder, Recording
from hoist_demo.reference import Reference, ReferencePoint, s_curve
from hoist_demo.rope_plant import REQUIRED_SIGNALS, EndMotion, RopePlant, RopeStatus

_log = logging.getLogger(__name__)

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
    "drive.tension_left": "N",
    "drive.tension_right": "N",
    "drive.tension_ratio": "1",
    "drive.work_motor": "J",
    "drive.work_losses": "J",
    "drive.work_rope_damping": "J",
    "drive.work_from_balance_rope": "J",
    "drive.energy_kinetic": "J",
    "drive.energy_potential": "J",
    "drive.energy_residual": "J",
}


@dataclass
class Stopwatch:
    """Wall and processor time of one of the two partners; a context manager that adds up."""

    wall: float = 0.0  # s
    cpu: float = 0.0  # s

    def __enter__(self) -> Stopwatch:
        self._wall, self._cpu = time.perf_counter(), time.process_time()
        return self

    def __exit__(self, *_: object) -> None:
        self.wall += time.perf_counter() - self._wall
        self.cpu += time.process_time() - self._cpu


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


@dataclass(frozen=True)
class _Point:
    """Both partners and the controller at one communication point."""

    t: float
    plant: PlantState
    controller: ControllerState
    rope: dict[str, float]


class Host:
    """Marries a drive and a rope for one trip."""

    def __init__(
        self,
        rope: RopePlant,
        hoist: Hoist | None = None,
        winding: Winding | None = None,
        coupling: Coupling | None = None,
        gains: Gains | None = None,
    ) -> None:
        self.rope = rope
        self.hoist = Hoist() if hoist is None else hoist
        self.winding = Winding() if winding is None else winding
        self.coupling = Coupling() if coupling is None else coupling
        require_trip_fits(self.hoist, self.winding)
        self._gains = gains
        self.plant = HoistPlant(self.hoist)
        self.reference = s_curve(self.winding)
        self.drive_clock, self.rope_clock, self.start_clock = Stopwatch(), Stopwatch(), Stopwatch()

    @property
    def start_heights(self) -> tuple[float, float]:
        """Heights of left and right conveyance before the trip [m]: the landings, left below when it is to rise."""
        low, high = 0.0, self.hoist.shaft_travel
        return (low, high) if self.winding.travel > 0.0 else (high, low)

    def run(self, progress: Progress | None = None) -> Result:
        """Wind once; `progress` hears of every step and may stop the run."""
        H, start = self.coupling.step, self.coupling.start
        planned = math.ceil((self.reference.duration + self.winding.settle) / H - 1e-9)
        y_left, y_right = self.start_heights
        recorder = Recorder(DRIVE_UNITS | {n: u for n, u in self.rope.units().items() if n not in DRIVE_UNITS})

        # both at rest: the rope's forces first, then the drive that carries them
        with self.start_clock:
            status = self.rope.initialize(start, EndMotion(y=y_left), EndMotion(y=y_right))
            signals = self.rope.signals() if status.valid else {}
        cause = _cause(status, signals, "rope, at the start")
        if cause:
            return self._result(recorder, 0, planned, cause)
        state = self.plant.equilibrium(y_left, y_right, signals["left.fy"], signals["right.fy"])
        held = PlantInput(float(state.x[0]), signals["left.fy"], signals["right.fy"])
        at_rest = self.plant.outputs(state, held)
        controller = SpeedController(self.hoist, at_rest.torque, self._gains)
        point = _Point(start, state, ControllerState(), signals)
        shown = at_rest

        for k in range(planned):
            # sample the controller; the rope's force is that of the last step
            reference = self.reference.at(point.t - start)
            measured = Measurement(shown.y_left - y_left, self.hoist.sheave_radius * shown.rate)
            command = controller.command(reference, measured, point.controller, H)
            held = _held(command, point.rope, first=k == 0)
            recorder.add(self._row(point, reference, command, shown, at_rest))

            # drive, then rope, over the same step
            with self.drive_clock:
                moved = self.plant.step(point.plant, H, held)
                shown = self.plant.outputs(moved.state, held)
            if not moved.valid:
                return self._result(recorder, k, planned, f"t = {point.t:.6g} s: {moved.message}")
            left, right = _ends(shown)
            with self.rope_clock:
                status = self.rope.step(point.t, H, left, right)
                signals = self.rope.signals() if status.valid else {}
            cause = _cause(status, signals, f"rope, step from t = {point.t:.6g} s")
            if cause:
                return self._result(recorder, k, planned, cause)
            point = _Point(start + (k + 1) * H, moved.state, command.state, signals)
            if progress is not None and not progress((k + 1) / planned, point.t):
                return self._result(recorder, k + 1, planned, f"t = {point.t:.6g} s: stopped by the user")

        # the last communication point, with the command that would follow
        reference = self.reference.at(point.t - start)
        measured = Measurement(shown.y_left - y_left, self.hoist.sheave_radius * shown.rate)
        command = controller.command(reference, measured, point.controller, H)
        recorder.add(self._row(point, reference, command, shown, at_rest))
        return self._result(recorder, planned, planned, "")

    def _result(self, recorder: Recorder, steps: int, planned: int, cause: str) -> Result:
        if cause:
            _log.info("co-simulation stopped after %d of %d steps: %s", steps, planned, cause)
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
        )

    def _row(
        self, point: _Point, reference: ReferencePoint, command: Command, shown: PlantOutput, at_rest: PlantOutput
    ) -> dict[str, float]:
        """One line of the recording, in the order of DRIVE_UNITS, then the rope's signals."""
        motor, losses, ropes, left, right = (float(value) for value in point.plant.work)
        values = (
            point.t,
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
            shown.tension_left,
            shown.tension_right,
            shown.tension_ratio,
            motor,
            losses,
            ropes,
            left + right,
            shown.energy_kinetic,
            shown.energy_potential,
            energy_residual(at_rest, shown, point.plant.work),
        )
        drive = dict(zip(DRIVE_UNITS, values, strict=True))
        return drive | {name: value for name, value in point.rope.items() if name not in drive}


def _held(command: Command, rope: dict[str, float], first: bool) -> PlantInput:
    """Input of the drive's next step; before the first step there is no mean force yet."""
    left, right = ("left.fy", "right.fy") if first else ("left.fy_mean", "right.fy_mean")
    return PlantInput(command.torque, rope[left], rope[right])


def _ends(shown: PlantOutput) -> tuple[EndMotion, EndMotion]:
    left = EndMotion(y=shown.y_left, vy=shown.v_left, ay=shown.a_left)
    return left, EndMotion(y=shown.y_right, vy=shown.v_right, ay=shown.a_right)


def _cause(status: RopeStatus, signals: dict[str, float], where: str) -> str:
    """Why the rope's answer cannot be used; "" when it can."""
    if not status.valid:
        return f"{where}: {status.message or 'status.valid is false, without a message'}"
    bad = [name for name in REQUIRED_SIGNALS if not math.isfinite(signals.get(name, math.nan))]
    return f"{where}: {', '.join(bad)} missing or not finite: check the rope plant" if bad else ""
