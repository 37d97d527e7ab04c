"""Advance of a trip in C, by trip.c, up to the next sample that the host in Python must process.

It takes what most trips have: the scheme gauss-seidel-1, the speed controller, head ropes that hold
on the sheave, a rope in a library, and a C compiler. All else goes on in ``host.Host``, with the
same bits.
"""

import logging
import math
from ctypes import CDLL, addressof, byref, c_int, c_void_p, cast
from dataclasses import astuple
from subprocess import CalledProcessError
from typing import Any, NamedTuple, Self

import numpy as np

from hoist_demo.control.controller import Command, ControllerState, Gains
from hoist_demo.control.kernel import ARGUMENTS
from hoist_demo.control.trajectory import Trajectory
from hoist_demo.cosimulation.drive_signals import ROW
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.participants.hoist_partner import DriveCommand
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope
from hoist_demo.cosimulation.participants.library_calls import (
    LOG_WARNINGS,
    Access,
    OutputTable,
    RopeLibrary,
)
from hoist_demo.cosimulation.run_state import RunState
from hoist_demo.cosimulation.schemes.explicit import GaussSeidel
from hoist_demo.cosimulation.schemes.interface import (
    HISTORY,
    ROPE_FORCES,
    SUCCESS,
    RopePlant,
    Sample,
)
from hoist_demo.cosimulation.trip_library import SIDE_INPUTS, STOPS, Trip, TripSample, trip_library
from hoist_demo.cosimulation.trip_plan import TripPlan
from hoist_demo.drive.plant import SIDE_FORCES
from rope_model import Status
from rope_model.compiler import last_words

_log = logging.getLogger(__name__)


class SampleReached(NamedTuple):
    """Sample at which the compiled trip has ended."""

    sample: int  # that is to be recorded next
    status: Status = SUCCESS
    within: bool = False  # True if steps before that sample are still to be done


class CompiledTrip:
    """The trip of a run in C; the rows of its samples and its state are the run's."""

    def __init__(self, plan: TripPlan, run: RunState, rope: RopeLibrary, max_samples: int) -> None:
        """``max_samples`` are those of one call."""
        hoist = plan.hoist
        coupling = plan.coupling
        start_height, _ = plan.start_heights
        drive = run.drive.plant.stick_integrator
        self._run = run
        self._rope = rope
        self._plan = plan
        self._drive = drive
        self._library = trip_library(hoist.equation_structure, drive.kernels)
        self._advance = CDLL(str(drive.kernels.library)).advance
        self._law_arguments = _law_arguments(plan, run)
        names = run.recorder.names[len(ROW) :]
        side_forces = () if hoist.play is None else SIDE_FORCES
        guard = [name for name in names if name == "guard.tripped"]
        self._table = rope.table(names, max_samples)
        self._forces = rope.table(ROPE_FORCES, 1)
        self._sides = rope.table(side_forces, 1)
        self._guard = rope.table(guard, 1)
        self._recorded = (Access * len(self._table.accesses))(*self._table.accesses)
        self._samples = (TripSample * HISTORY)()
        self._log_warnings = LOG_WARNINGS(rope.log_warnings)
        self._trajectory: Trajectory | None = None
        slack_tension = -math.inf
        if hoist.slack_tension is not None:
            slack_tension = hoist.slack_tension
        self._trip = Trip(
            drive=cast(self._advance, c_void_p),
            z=drive.z.ctypes.data,
            y=drive.y.ctypes.data,
            law_arguments=self._law_arguments.ctypes.data,
            step=rope.step,
            motions=rope.motions,
            valid=rope.valid or Access(),
            forces=_only_access(self._forces),
            sides=_only_access(self._sides),
            guard=_only_access(self._guard),
            recorded=addressof(self._recorded),
            records=len(self._recorded),
            warning=cast(rope.warning, c_void_p),
            warned=cast(rope.warned, c_void_p),
            text=cast(rope.text, c_void_p),
            log_warnings=cast(self._log_warnings, c_void_p),
            warnings=len(rope.warned or ()),
            start=coupling.start,
            period=coupling.period,
            per_sample=coupling.per_sample,
            per_step=coupling.per_step,
            H=coupling.step,
            radius=hoist.sheave_radius,
            start_height=start_height,
            ropes=hoist.tail_rope_number,
            slack_tension=slack_tension,
            samples=addressof(self._samples),
            columns=len(run.recorder.names),
        )

    @classmethod
    def for_run(cls, plan: TripPlan, run: RunState, max_samples: int) -> Self | None:
        """Return the trip in C; None for a run that only the host in Python winds."""
        library = _rope_library(plan.rope)
        if library is None or not _has_parts_of(plan, run):
            return None
        try:
            return cls(plan, run, library, max_samples)
        except (OSError, RuntimeError, CalledProcessError) as error:
            _log.warning("the trip is wound in Python, which takes longer: %s", last_words(error))
            return None

    def wind_samples(self, first: int, last: int) -> SampleReached:
        """Wind the samples from ``first`` to before ``last``, and the steps behind each."""
        run = self._run
        trip = self._trip
        if self._brake_stops():
            return SampleReached(first)
        begun = run.course.winding.emergency_at
        trip.watched = begun is None or begun > first * self._plan.coupling.period
        self._set_reference(run.course.trajectory)
        self._copy_to_c()
        rows = run.recorder.following
        reached = c_int(first)
        trip.row = rows.ctypes.data
        stop = STOPS[self._library.trip_samples(byref(trip), byref(reached), last)]
        self._rope.log_warnings()
        done = reached.value - first
        if stop not in ("WELL", "LOOK"):
            done += 1  # the sample whose step failed is recorded
        rows[:done, len(ROW) :] = self._table.read(done)
        run.recorder.count += done
        if not done:
            return SampleReached(first)
        self._copy_from_c()
        status = run.coupled.read_rope(self._step_start(stop), self._rope.status(stop, trip.status))
        return SampleReached(reached.value, status, within=stop == "DRIVE")

    def _brake_stops(self) -> bool:
        """Return True in an emergency stop with the brake, which only the host in Python winds."""
        run = self._run
        regulated = run.controller is not None and run.controller.brake is not None
        return run.course.trajectory.trip is not None or regulated

    def _step_start(self, stop: str) -> float:
        """Return the time at which the rope's latest step began [s]."""
        coupling = self._plan.coupling
        steps = self._run.steps
        if stop == "WELL":
            steps -= 1
        return coupling.start + steps * coupling.step

    def _set_reference(self, trajectory: Trajectory) -> None:
        """Put the reference at all samples where C finds it."""
        if trajectory is self._trajectory:
            return
        self._trajectory = trajectory
        coupling = self._plan.coupling
        samples, within = np.ogrid[: self._run.recorder.size, : coupling.per_step]
        t = coupling.start + samples * coupling.period + within * coupling.step / coupling.per_step
        self._reference = trajectory.sample((t - coupling.start).ravel())
        self._trip.reference = self._reference.ctypes.data

    def _copy_to_c(self) -> None:
        """Copy the run's state to the structures of C."""
        run = self._run
        trip = self._trip
        drive = run.drive
        state = drive.state
        scheme_state = run.scheme_state
        parts = {
            "x": state.x,
            "work_totals": state.work_totals,
            "applied_input": drive.input,
            "outputs": drive.outputs,
        }
        self._drive.set_arguments(
            l0=state.free_lengths, H=self._plan.coupling.step, path=0.0, added_mass=0.0
        )
        for name, values in parts.items():
            self._drive.y[self._drive.result[name]] = values
        for kept, sample in zip(self._samples, scheme_state.samples, strict=False):
            kept.t = sample.t
            kept.force[:] = sample.force
            kept.mean[:] = sample.mean
            kept.acceleration[:] = sample.acceleration
        trip.kept_samples = len(scheme_state.samples)
        trip.step_next = state.step_next
        trip.steps = run.steps
        if run.controller is None:
            trip.integral = 0.0
        else:
            trip.integral = run.controller.integral
        trip.residual = scheme_state.residual
        trip.exchanges = scheme_state.exchanges
        trip.evaluations = 0
        trip.drive_time = 0.0
        trip.rope_time = 0.0

    def _copy_from_c(self) -> None:
        """Copy the state from the structures of C to the run."""
        run = self._run
        trip = self._trip
        last = {name: self._drive.y[place].copy() for name, place in self._drive.result.items()}
        state = run.drive.state._replace(
            x=last["x"], work_totals=last["work_totals"], step_next=trip.step_next
        )
        run.drive.set_state(state, last["applied_input"], last["outputs"])
        run.scheme_state = run.scheme_state._replace(
            samples=tuple(map(_sample_of, self._samples[: trip.kept_samples])),
            exchanges=int(trip.exchanges),
            residual=trip.residual,
        )
        run.controller = ControllerState(trip.integral)
        run.steps = trip.steps
        run.commands = [Command(trip.torque, limited=False, state=run.controller)]
        side_forces = self._drive.arguments["path"][SIDE_INPUTS]
        run.drive.command(DriveCommand(trip.torque, brake=0.0), side_forces)
        self._drive.evaluations += trip.evaluations
        self._plan.clocks.drive.wall += trip.drive_time
        self._plan.clocks.rope.wall += trip.rope_time


def _rope_library(rope: RopePlant) -> RopeLibrary | None:
    """Return the functions of a rope for trip.c; None without such."""
    # a rope of another class may do more in its steps than its library
    if type(rope) is FmuRope or type(rope) is InProcessRope:
        return rope.library()
    return None


def _has_parts_of(plan: TripPlan, run: RunState) -> bool:
    """Return True if trip.c has scheme, controller and hoist of this run."""
    scheme = plan.scheme
    return (
        type(scheme) is GaussSeidel
        and scheme.order == 1
        and plan.controller is None
        and run.drive.plant.stick_integrator.kernels.library is not None
        and plan.hoist.lining is None
    )


def _law_arguments(plan: TripPlan, run: RunState) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the argument of the control law's kernel, with what the trip does not change."""
    constants = {"holding_torque": run.holding_torque, "h": plan.coupling.sample_time}
    arguments = (constants.get(name, 0.0) for name in ARGUMENTS)
    gains = plan.gains or Gains()
    return np.array([*arguments, *astuple(gains), *plan.hoist.numbers])


def _only_access(table: OutputTable) -> Access:
    """Return the access of a table that needs one at most.

    One without a function if it needs none.
    """
    return next(iter(table.accesses), Access())


def _sample_of(kept: TripSample) -> Sample:
    """Return the sample that C keeps."""
    return Sample(
        t=kept.t,
        force=np.array(kept.force),
        mean=np.array(kept.mean),
        acceleration=np.array(kept.acceleration),
    )
