"""The controller's samples, and the safety circuit that looks at them."""

import math
from copy import deepcopy
from functools import partial
from typing import Any

from hoist_demo.control.controller import Command, Controller, Measurement, SpeedController
from hoist_demo.control.trajectory import Course, TrajectoryPoint
from hoist_demo.cosimulation.drive_signals import numbers_of_exchange
from hoist_demo.cosimulation.participants.hoist_partner import DriveCommand
from hoist_demo.cosimulation.run_state import RunState
from hoist_demo.cosimulation.schemes.interface import Vector
from hoist_demo.cosimulation.trip_plan import SAMPLE_ROUNDING, TripPlan
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.recording.time_series import Array

_Y_LEFT = OUTPUT_INDEX["y_left"]
_RATE = OUTPUT_INDEX["rate"]
_PULLS = [OUTPUT_INDEX["pull_left"], OUTPUT_INDEX["pull_right"]]


class Sampling:
    """Samples of a controller in a run."""

    def __init__(self, plan: TripPlan, run: RunState, controller: Controller) -> None:
        self._plan = plan
        self._run = run
        self._controller = controller
        self._start_height, _ = plan.start_heights

    def record_and_command(self, t: float, signals: Array) -> Command:
        """Record all signals at t [s] and return the controller's command."""
        run = self._run
        point = self._reference(t)
        command = self._command(point, run.drive.outputs, run.controller)
        numbers = numbers_of_exchange(t, point, command, run.drive, run.scheme_state)
        run.recorder.add(numbers, run.drive.outputs, run.drive.state.work_totals, signals)
        return command

    def command_within_step(self, k: int, t: float, outputs: Vector) -> DriveCommand:
        """Return the k-th command within a communication step, see ``NextCommand``."""
        run = self._run
        # the step may be repeated, from the command before
        state = deepcopy(run.commands[k - 1].state)
        command = self._command(self._reference(t), outputs, state)
        run.commands[k:] = [command]
        return DriveCommand(command.torque, command.brake)

    def _reference(self, t: float) -> TrajectoryPoint:
        return self._run.course.trajectory.at(t - self._plan.coupling.start)

    def _command(self, point: TrajectoryPoint, outputs: Vector, state: Any) -> Command:
        """Return the controller's command, by the reference and the OUTPUTS of the drive."""
        travel = outputs.item(_Y_LEFT) - self._start_height
        speed = self._plan.hoist.sheave_radius * outputs.item(_RATE)
        measured = Measurement(travel, speed)
        command = self._controller.command(point, measured, state, self._plan.coupling.sample_time)
        if not isinstance(command, Command):
            kind = type(command).__name__
            raise ValueError(f"command() must return Command(torque, limited, state), not {kind}")
        return command


def under_safety_circuit(plan: TripPlan, run: RunState, t: float, signals: Array) -> Course:
    """Return the course at t [s], with an emergency stop if the safety circuit opens."""
    course = run.course
    start = plan.coupling.start
    period = plan.coupling.period
    slack_tension = plan.hoist.slack_tension
    if slack_tension is not None and min(run.drive.outputs[_PULLS]) < slack_tension:
        course = course.with_emergency_stop(t - start)
    tripped = run.readers.guard_tripped
    time = run.readers.guard_time
    if tripped is None or time is None or not signals.item(tripped) > 0.0:
        return course
    samples = max(0, math.ceil((signals.item(time) - start) / period - SAMPLE_ROUNDING))
    return course.with_emergency_stop(start + period * samples - start)


def make_controller(plan: TripPlan, holding_torque: float) -> Controller:
    """Make the controller of a run.

    Raises ValueError if the plan's is no class or function, or makes an object that gives no commands.
    """
    make = plan.controller
    if make is None:
        make = partial(SpeedController, gains=plan.gains)
    if not callable(make):
        kind = type(make).__name__
        raise ValueError(
            "controller must be a class, or a function of hoist and holding torque, "
            f"not a {kind} made already: give the class, or lambda hoist, torque: {kind}(...)"
        )
    controller = make(plan.hoist, holding_torque)
    if not callable(getattr(controller, "command", None)):
        raise ValueError(
            "a controller needs the method command(reference, measured, state, h), "
            f"and {type(controller).__name__} has none: "
            "see hoist_demo.control.controller.Controller"
        )
    return controller
