"""Advance of a trip in C, by trip.c, up to the next sample that the host in Python must process.

It takes what most trips have: the scheme gauss-seidel-1, the speed controller, head ropes that hold
on the sheave, a rope in a library, and a C compiler. All else goes on in `host.Host`, with the same
bits.
"""

import logging
import math
from ctypes import CDLL, addressof, byref, c_int, c_void_p, cast
from dataclasses import astuple, fields
from functools import cache
from importlib.resources import files
from itertools import product
from subprocess import CalledProcessError
from typing import Any, NamedTuple, Self

import numpy as np

from hoist_demo.control.controller import Command, ControllerState, Gains
from hoist_demo.control.kernel import ARGUMENTS, RESULTS, law_kernel
from hoist_demo.control.trajectory import Trajectory, TrajectoryPoint
from hoist_demo.cosimulation.drive_signals import OUTPUT_COLUMNS, ROW, WORK_COLUMNS
from hoist_demo.cosimulation.participants.c_structures import (
    CMember,
    SharedStructure,
    definition,
    fields_of,
)
from hoist_demo.cosimulation.participants.fmi_versions import DISCARD, WARNING
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.participants.hoist_partner import DriveCommand
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope
from hoist_demo.cosimulation.participants.library_calls import (
    CALLS,
    FUNCTIONS,
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
from hoist_demo.cosimulation.trip_plan import TripPlan
from hoist_demo.drive import integrator, plant
from hoist_demo.drive.coordinates import FORCES, INPUT_NAMES, STATE_NAMES, WORK_NAMES
from hoist_demo.drive.kernels import generate_c
from hoist_demo.drive.outputs import OUTPUT_INDEX, OUTPUTS
from hoist_demo.drive.plant import SIDE_FORCES
from hoist_demo.parameters import Hoist
from hoist_demo.recording.time_series import TIME
from rope_model import SIDES, EndMotion, Status
from rope_model.codegen.build import sources as rope_sources
from rope_model.compiler import cache_folder, compile_library, find_compiler, last_words

_log = logging.getLogger(__name__)
#: Headers of the rope that trip.c includes, with those that they include.
_ROPE_HEADERS = ("rope.h", "parameters.h", "interface_structures.h")
#: Ends of a call: well, before a sample that the host must process, or the part that has failed.
_STOPS = ("WELL", "LOOK", "DRIVE", *CALLS)
_MOTIONS = tuple(field.name for field in fields(EndMotion))
#: Names of an end's motion in OUTPUTS, where they are others.
_OUTPUT_NAMES = {"vy": "v", "ay": "a"}
_NO_OUTPUT = -1  #: Place of a motion that the hoist does not have, as one that leans.
#: Places in OUTPUTS of the motions of both ends.
_ENDS = [
    OUTPUT_INDEX.get(f"{_OUTPUT_NAMES.get(name, name)}_{side}", _NO_OUTPUT)
    for side, name in product(SIDES, _MOTIONS)
]
_MEMORY = ("arg", "res", "iw", "w")  #: Memory of a function of CasADi.
_SIDES = slice(INPUT_NAMES.index("fx_left"), len(INPUT_NAMES))
#: Signals at which blocks or single numbers of a row of the record begin, by names in trip.c.
_COLUMNS = {
    "TIME": TIME,
    "REFERENCE": "reference.position",
    "TORQUE_COMMAND": "drive.torque_command",
    "TORQUE_LIMITED": "drive.torque_limited",
    "SLIP": "drive.slip",
    "SLIP_SPEED": "drive.slip_speed",
    "COUPLING_ENERGY": "coupling.energy",
    "EXCHANGES": "coupling.exchanges",
    "OUTPUTS": OUTPUT_COLUMNS[0],
    "WORK_TOTALS": WORK_COLUMNS[0],
}
_INTEGRATOR_CONSTANTS = (
    "MIN_STEP",
    "SAFETY",
    "MIN_FACTOR",
    "MAX_FACTOR",
    "MIN_ERROR",
    "ORDER",
    "STEP_ROUNDING",
)
#: Numbers of trip.c that are those of all hoists, by name.
_NUMBERS: dict[str, float] = {
    **{name: getattr(integrator, name) for name in _INTEGRATOR_CONSTANTS},
    "MIN_ROPE": plant.MIN_ROPE,
    "HISTORY": HISTORY,
    "WARNING": WARNING,
    "DISCARD": DISCARD,
    "INPUTS": len(INPUT_NAMES),
    "TORQUE": INPUT_NAMES.index("torque_command"),
    "FORCE": FORCES[0],
    "SIDES": _SIDES.start,
    "PHI": STATE_NAMES.index("phi"),
    "WORK_COUNT": integrator.WORK_COUNT,
    "JERK": TrajectoryPoint._fields.index("jerk"),
    "OUTPUTS": len(OUTPUTS),
    "LAW_RESULTS": len(RESULTS),
    **{f"LAW_{name.upper()}": k for k, name in enumerate(RESULTS)},
    **{f"{name.upper()}_WORK": WORK_NAMES.index(name) for name in SIDES},
    **{name.upper(): OUTPUT_INDEX[name] for name in ("y_left", "a_left", "pull_left", "rate")},
    **{name.upper(): ARGUMENTS.index(name) for name in ("travel", "speed", "integral")},
    **{f"AS_{name}": k for k, name in enumerate(FUNCTIONS)},
    **{f"COLUMN_{name}": ROW.index(signal) for name, signal in _COLUMNS.items()},
}


class TripSample(SharedStructure):
    """Forces and motions of the interface at one communication point."""

    members = (
        CMember("t", "double"),
        CMember("force", "double", length=2),
        CMember("mean", "double", length=2),
        CMember("acceleration", "double", length=2),
    )
    _fields_ = fields_of(members)


class Trip(SharedStructure):
    """Arguments and state of a trip in C."""

    members = (
        # the drive
        CMember("drive", "Kernel *", "one substep of the drive"),
        CMember("z", "double *", "its arguments"),
        CMember("y", "double *", "its results"),
        CMember("law_arguments", "double *"),
        # the rope; accesses without a function where it lacks one
        CMember("step", "Access"),
        CMember("motions", "Access"),
        CMember("valid", "Access"),
        CMember("forces", "Access"),
        CMember("sides", "Access"),
        CMember("guard", "Access"),
        CMember("recorded", "const Access *"),
        CMember("warning", "RopeWarning *"),
        CMember("warned", "char *", "1 for each warning that was logged"),
        CMember("text", "char *", "of a warning"),
        CMember("log_warnings", "LogWarnings *"),
        CMember("records", "int", "number of recorded accesses"),
        CMember("warnings", "int", "number of warnings"),
        CMember("watched", "int", "not 0 while the safety circuit is watched"),
        # the trip
        CMember("per_sample", "int", "steps"),
        CMember("per_step", "int", "commands"),
        CMember("start", "double", "s"),
        CMember("H", "double", "s, communication step"),
        CMember("period", "double", "s, of samples"),
        CMember("radius", "double", "m, of the sheave"),
        CMember("start_height", "double", "m, of the left conveyance"),
        CMember("ropes", "double", "number of tail ropes"),
        CMember("slack_tension", "double", "N"),
        CMember("reference", "const Reference *", "of all commands of the trip"),
        # its state
        CMember("samples", "TripSample *", "the last ones, oldest first"),
        CMember("row", "double *", "of the record, where the first sample goes"),
        CMember("columns", "size_t", "of a row"),
        CMember("step_next", "double", "s, of the drive"),
        CMember("torque", "double", "N m, commanded"),
        CMember("integral", "double", "of the controller"),
        CMember("residual", "double", "J, energy that the coupling adds"),
        CMember("exchanges", "double"),
        CMember("drive_time", "double", "s, wall time"),
        CMember("rope_time", "double", "s, wall time"),
        CMember("kept_samples", "int"),
        CMember("steps", "int"),
        CMember("evaluations", "int", "of the drive"),
        CMember("status", "int", "of the rope's latest call"),
    )
    _fields_ = fields_of(members, (Access,))


class SampleReached(NamedTuple):
    """Sample at which the compiled trip has ended."""

    sample: int  # that is to be recorded next
    status: Status = SUCCESS
    within: bool = False  # True if steps before that sample are still to be done


class CompiledTrip:
    """The trip of a run in C; the rows of its samples and its state are the run's."""

    def __init__(self, plan: TripPlan, run: RunState, rope: RopeLibrary, max_samples: int) -> None:
        """`max_samples` are those of one call."""
        hoist = plan.hoist
        coupling = plan.coupling
        start_height, _ = plan.start_heights
        drive = run.drive.plant.stick_integrator
        self._run = run
        self._rope = rope
        self._plan = plan
        self._drive = drive
        self._library = _library(hoist.equation_structure, drive.kernels)
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
        """Wind the samples from `first` to before `last`, and the steps behind each."""
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
        stop = _STOPS[self._library.trip_samples(byref(trip), byref(reached), last)]
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
        side_forces = self._drive.arguments["path"][_SIDES]
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


@cache
def _library(structure: Hoist, kernels: integrator.DriveKernels) -> CDLL:
    """Compile and load trip.c for hoists with these parts; RuntimeError without a C compiler."""
    compiler = find_compiler()
    if compiler is None:
        raise RuntimeError("no C compiler found")
    law = law_kernel(structure)
    sources = {
        "trip.c": files(__package__).joinpath("trip.c").read_text(encoding="utf-8"),
        **{name: rope_sources()[name] for name in _ROPE_HEADERS},
        "numbers.h": _numbers_header(law, kernels),
        "structures.h": "\n".join(map(definition, (Access, TripSample, Trip))),
        "law.c": generate_c((law,), "law"),
    }
    return CDLL(str(compile_library(sources, compiler, cache_folder(), "hoist_trip")))


def _numbers_header(law: Any, kernels: integrator.DriveKernels) -> str:
    """Return the text of numbers.h: numbers and types of trip.c that follow from Python."""
    argument = kernels.argument_slices
    result = kernels.result
    numbers = _NUMBERS | {
        **{f"AT_{name.upper()}": argument[name].start for name in ("s", "h", "path", "l0")},
        **{
            f"AT_{name.upper()}": result[name].start for name in ("work_totals", "error", "outputs")
        },
        "REACHED": result["work_totals"].stop,
        "SIZE": result["outputs"].stop,
        **{f"SZ_{name.upper()}": _memory_size(name, law, kernels.advance) for name in _MEMORY},
    }
    defines = "".join(f"#define {name} {value!r}\n" for name, value in numbers.items())
    places = ", ".join(map(str, _ENDS))
    return (
        f"{defines}"
        f"typedef enum {{ {', '.join(_STOPS)} }} Stop;\n"
        f"static const int ENDS_OUTPUTS[] = {{{places}}};\n"
    )


def _memory_size(name: str, law: Any, advance: Any) -> int:
    """Return the size of a working array that serves both functions of CasADi."""
    return 1 + max(int(getattr(function, f"sz_{name}")()) for function in (law, advance))
