"""Advance of a trip in C, by trip.c, up to the next sample that the host in Python must process.

It takes what most trips have: the scheme gauss-seidel-1, the speed controller, head ropes that hold on the sheave, a
rope in a library, and a C compiler. All else goes on in `host.Host`, which gives the same bits.
"""

import math
from ctypes import CDLL, Structure, addressof, byref, c_double, c_int, c_size_t, c_void_p, cast
from dataclasses import astuple
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np

from hoist_demo.control.controller import Command, ControllerState, Gains
from hoist_demo.control.kernel import ARGUMENTS, law_kernel
from hoist_demo.control.trajectory import Trajectory
from hoist_demo.cosimulation.drive_signals import ROW
from hoist_demo.cosimulation.participants.fmi_versions import DISCARD, WARNING
from hoist_demo.cosimulation.participants.library_calls import (
    CALLS,
    FUNCTIONS,
    HEARD,
    Access,
    RopeLibrary,
)
from hoist_demo.cosimulation.run_state import RunState
from hoist_demo.cosimulation.schemes.interface import ENDS, HISTORY, ROPE_FORCES, Sample, Stopwatch
from hoist_demo.drive import integrator, plant
from hoist_demo.drive.equations import FORCES, INPUT_NAMES, STATE_NAMES, WORK_NAMES
from hoist_demo.drive.kernels import generate_c
from hoist_demo.drive.outputs import OUTPUT_INDEX, OUTPUTS
from hoist_demo.drive.plant import SIDE_FORCES
from hoist_demo.parameters import Coupling, Hoist
from rope_model import EndMotion
from rope_model.compiler import cache_folder, compile_library, find_compiler

_STOPS = (
    "WELL",
    "LOOK",
    "DRIVE",
    *CALLS,
)  #: How samples end: well, before one to be looked at, or what has failed.
_SIDES = slice(INPUT_NAMES.index("fx_left"), len(INPUT_NAMES))
_SPELT = {"y": "y", "vy": "v", "ay": "a"}  #: Names in OUTPUTS, where they are others.
#: -1: a hoist has nothing that leans
_ENDS = [
    OUTPUT_INDEX.get(f"{_SPELT.get(name, name)}_{s}", -1)
    for s in ENDS
    for name in EndMotion.__dataclass_fields__
]
_MOTIONS = " ".join(
    f"double {name};" for name in EndMotion.__dataclass_fields__
)  #: Members of it in rope.h.
_MEMORY = ("arg", "res", "iw", "w")  #: Of a function of CasADi.
#: What trip.c takes from here for all hoists, by name.
_NUMBERS: dict[str, float] = {
    **{
        name: getattr(integrator, name)
        for name in ("MIN_STEP", "SAFETY", "SHRINKS", "GROWS", "ORDER")
    },
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
    **{f"{name.upper()}_WORK": WORK_NAMES.index(name) for name in ENDS},
    "OUTPUTS": len(OUTPUTS),
    **{name.upper(): OUTPUT_INDEX[name] for name in ("y_left", "a_left", "pull_left", "rate")},
    **{name.upper(): ARGUMENTS.index(name) for name in ("travel", "speed", "integral")},
    **{name: k for k, name in enumerate(_STOPS)},
    **{f"AS_{name}": k for k, name in enumerate(FUNCTIONS)},
}


def _fields(kind: Any, names: str) -> list[tuple[str, Any]]:
    return [(name, kind) for name in names.split()]


class TripStructure(Structure):
    """Arguments and state of trip.c, its struct Trip."""

    _fields_ = (
        *_fields(c_void_p, "drive z y law_arguments"),
        *_fields(Access, "step motions valid forces sides guard"),
        *_fields(c_void_p, "recorded warning warned text heard"),
        *_fields(c_int, "records warnings watched per_sample per_step"),
        *_fields(c_double, "start H period radius start_height ropes slack_tension"),
        *_fields(c_void_p, "reference samples row"),
        *_fields(c_size_t, "columns"),
        *_fields(c_double, "step_next torque integral residual exchanges drive_time rope_time"),
        *_fields(c_int, "sample_count steps evaluations status"),
    )


class SampleReached(NamedTuple):
    """Sample at which the compiled trip has ended."""

    sample: int  # that is to be recorded next
    cause: str = ""  # why the trip cannot go on
    within: bool = False  # True if steps before that sample are still to be done


class CompiledTrip:
    """The trip of a run in C; the rows of its samples and its state are the run's."""

    def __init__(
        self,
        run: RunState,
        rope: RopeLibrary,
        hoist: Hoist,
        gains: Gains,
        coupling: Coupling,
        start_height: float,
        clocks: tuple[Stopwatch, Stopwatch],
        most: int,
    ) -> None:
        """`clocks` are stopwatches of drive and rope, `most` is the largest number of samples of one call."""
        self._run, self._rope, self._coupling, self._clocks = run, rope, coupling, clocks
        self._drive = drive = run.drive.plant.stick_integrator
        self._library = _library(hoist.equation_structure, drive.kernels)
        self._advance = CDLL(str(drive.kernels.library)).advance
        names = run.recorder.names[len(ROW) :]
        values = {"holding_torque": run.holding_torque, "h": coupling.sample_time}
        arguments = (values.get(name, 0.0) for name in ARGUMENTS)
        self._law_arguments = np.array([*arguments, *astuple(gains), *hoist.numbers])
        self._table, self._forces = rope.table(names, most), rope.table(ROPE_FORCES, 1)
        self._sides = rope.table(SIDE_FORCES if hoist.play is not None else (), 1)
        self._guard = rope.table([name for name in names if name == "guard.tripped"], 1)
        self._recorded = (Access * len(self._table.accesses))(*self._table.accesses)
        self._samples = np.zeros((HISTORY, 7))
        self._heard = HEARD(rope.heard)
        self._trajectory: Trajectory | None = None
        self._trip = TripStructure(
            drive=cast(self._advance, c_void_p),
            z=drive.z.ctypes.data,
            y=drive.y.ctypes.data,
            law_arguments=self._law_arguments.ctypes.data,
            **{name: getattr(rope, name) or Access() for name in ("step", "motions", "valid")},
            **{
                name: next(iter(getattr(self, f"_{name}").accesses), Access())
                for name in ("forces", "sides", "guard")
            },
            recorded=addressof(self._recorded),
            records=len(self._recorded),
            **{name: cast(getattr(rope, name), c_void_p) for name in ("warning", "warned", "text")},
            heard=cast(self._heard, c_void_p),
            warnings=len(rope.warned or ()),
            **{
                name: getattr(coupling, name)
                for name in ("start", "period", "per_sample", "per_step")
            },
            H=coupling.step,
            radius=hoist.sheave_radius,
            start_height=start_height,
            ropes=hoist.tail_rope_number,
            slack_tension=-math.inf if hoist.slack_tension is None else hoist.slack_tension,
            samples=self._samples.ctypes.data,
            columns=len(run.recorder.names),
        )

    def samples(self, first: int, last: int) -> SampleReached:
        """Wind the samples from ``first`` to before ``last``, and the steps behind each."""
        run, trip = self._run, self._trip
        if run.course.trajectory.trip is not None or (
            run.controller is not None and run.controller.brake is not None
        ):
            return SampleReached(first)
        begun = run.course.winding.emergency_at
        trip.watched = begun is None or begun > first * self._coupling.period
        self._set_reference(run.course.trajectory)
        self._copy_to_c()
        rows = run.recorder.following
        reached = c_int(first)
        trip.row = rows.ctypes.data
        stop = _STOPS[self._library.trip_samples(byref(trip), byref(reached), last)]
        self._rope.heard()
        failed = stop not in ("WELL", "LOOK")
        done = reached.value - first + (1 if failed else 0)
        rows[:done, len(ROW) :] = self._table.read(done)
        run.recorder.count += done
        if done:
            self._copy_from_c()
            t = (
                self._coupling.start
                + (run.steps - (1 if stop == "WELL" else 0)) * self._coupling.step
            )
            cause = run.coupled.rope_stepped(t, self._rope.status(stop, trip.status))
            return SampleReached(reached.value, cause, within=stop == "DRIVE")
        return SampleReached(first)

    def _set_reference(self, trajectory: Trajectory) -> None:
        """Put the reference at all samples where C finds it."""
        if trajectory is self._trajectory:
            return
        coupling, self._trajectory = self._coupling, trajectory
        samples, within = np.ogrid[: self._run.recorder.size, : coupling.per_step]
        t = coupling.start + samples * coupling.period + within * coupling.step / coupling.per_step
        self._reference = trajectory.sample((t - coupling.start).ravel())
        self._trip.reference = self._reference.ctypes.data

    def _copy_to_c(self) -> None:
        """Give the run's state to C."""
        run, trip, drive, scheme_state = (
            self._run,
            self._trip,
            self._run.drive,
            self._run.scheme_state,
        )
        state, slices = drive.state, self._drive.result
        parts = {
            "x": state.x,
            "work_totals": state.work_totals,
            "applied_input": drive.input,
            "outputs": drive.outputs,
        }
        self._drive.give(l0=state.free_lengths, H=self._coupling.step, path=0.0, added_mass=0.0)
        for name, values in parts.items():
            self._drive.y[slices[name]] = values
        for row, sample in zip(self._samples, scheme_state.samples, strict=False):
            row[...] = np.concatenate([[sample.t], *sample[1:]])
        trip.sample_count, trip.step_next, trip.steps = (
            len(scheme_state.samples),
            state.step_next,
            run.steps,
        )
        trip.integral = 0.0 if run.controller is None else run.controller.integral
        trip.residual, trip.exchanges = scheme_state.residual, scheme_state.exchanges
        trip.evaluations = trip.drive_time = trip.rope_time = 0

    def _copy_from_c(self) -> None:
        """Take the run's state from C."""
        run, trip, slices = self._run, self._trip, self._drive.result
        last = {name: self._drive.y[place].copy() for name, place in slices.items()}
        state = run.drive.state._replace(
            x=last["x"], work_totals=last["work_totals"], step_next=trip.step_next
        )
        run.drive.arrive(state, last["applied_input"], last["outputs"])
        rows = self._samples[: trip.sample_count].copy()
        samples = tuple(Sample(row.item(0), row[1:3], row[3:5], row[5:]) for row in rows)
        exchanges = int(trip.exchanges)
        run.scheme_state = run.scheme_state._replace(
            samples=samples, exchanges=exchanges, residual=trip.residual
        )
        run.controller, run.steps = ControllerState(trip.integral), trip.steps
        run.commands = [Command(trip.torque, False, run.controller)]
        run.drive.command(trip.torque, 0.0, self._drive.arguments["path"][_SIDES])
        self._drive.evaluations += trip.evaluations
        for clock, time in zip(self._clocks, (trip.drive_time, trip.rope_time), strict=True):
            clock.wall += time


@cache
def _library(structure: Hoist, kernels: integrator.DriveKernels) -> CDLL:
    """Compile and load trip.c for hoists with these parts; RuntimeError without a C compiler."""
    if (compiler := find_compiler()) is None:
        raise RuntimeError("no C compiler found")
    law, results = law_kernel(structure), kernels.result
    numbers = _NUMBERS | {
        **{
            f"AT_{name.upper()}": kernels.argument_slices[name].start
            for name in ("s", "h", "path", "l0")
        },
        **{
            f"AT_{name.upper()}": results[name].start
            for name in ("work_totals", "error", "outputs")
        },
        "REACHED": results["work_totals"].stop,
        "SIZE": results["outputs"].stop,
        **{
            f"SZ_{n.upper()}": 1 + max(getattr(f, f"sz_{n}")() for f in (law, kernels.advance))
            for n in _MEMORY
        },
    }
    sources = {
        "trip.c": files(__package__).joinpath("trip.c").read_text(encoding="utf-8"),
        "numbers.h": "".join(f"#define {name} {value!r}\n" for name, value in numbers.items())
        + f"typedef struct {{ {_MOTIONS} }} EndMotion;\n"
        + f"static const int ENDS_OUTPUTS[] = {{{', '.join(map(str, _ENDS))}}};\n",
        "law.c": generate_c((law,), "law"),
    }
    return CDLL(str(compile_library(sources, compiler, cache_folder(), "hoist_trip")))
