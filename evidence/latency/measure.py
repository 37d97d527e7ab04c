"""Wall time of one communication step of the native rope, and the cause of the longest ones.

In process a step is ``advance_to``; through the FMU it is fmi2SetReal of all end motions, fmi2DoStep and fmi2GetReal of
the end forces, by FMPy's low-level functions with arrays made before.  One thread makes all calls of a run, without
Python's garbage collector.  The scenes are whole trips with the conveyances' motion prescribed: windings, emergency
stops, and these with a blow of both legs against the shaft's lining after the stop.

Every run is made ROUNDS times, the cases taking turns.  Its steps do the same work each time, to the bit, so

- a percentile *as run* is the median of the rounds' percentiles, with the system's other work in it;
- a step's *own* time is the shortest of the rounds.

Measure on a quiet machine: nothing else runs, and the clock does not change (Linux: `cpupower frequency-set -g
performance`), one core kept for it (``taskset -c 1``).
"""

import ctypes
import gc
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, astuple, dataclass, replace
from functools import lru_cache
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter_ns

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from numpy.typing import NDArray
from tqdm import tqdm

from benchmarks.kinematic import ends_at
from evidence.ropes import at_rest, moving
from evidence.tables import Array, Measures, Tables, table
from fmu_src.native.export import export_native
from fmu_src.shell.build import host_platform
from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.parameters import Winding
from hoist_demo.parameters.quantity import Value
from rope_model import EndMotion, Level

#: rest after a winding, s
SETTLE = 5.0
#: part of the trip's duration at which an emergency stop begins: on rope-240 after its swivels' release
STOP = 0.6
SCENES = ("rope-120", "rope-240", "monopol-1000")
TRIPS = ("winding", "emergency stop", "strike")
LEVELS: tuple[Level, ...] = ("draft", "standard")
#: communication step in s -> bound of its work
BOUNDS = {0.01: 0, 0.001: 12}
#: m: room beside the legs of a strike, and way of both ends; s: its begin after that of the stop, and its duration
ROOM = 0.35
WAY = 0.25
AFTER = 0.5
MOVES = 0.6
ROUNDS = 3
PERCENTILES = (50.0, 99.0, 99.9, 100.0)
#: slowest part of the steps, whose work is counted apart
SLOWEST = 0.01
#: counted in a step; Newton iterations come on top of the one or two that every step needs
CAUSES = ("count.rejections", "count.transformations", "count.swivel_events")
COUNTED = (*CAUSES, "count.newton")
READ = ("left.fy", "right.fy", "left.fy_mean", "right.fy_mean")
HEAD = ("scene", "trip", "level", "place", "H [s]")
STEPS = (
    *HEAD,
    "elements",
    "steps",
    "50 % [s]",
    "99 % [s]",
    "99.9 % [s]",
    "largest [s]",
    "late",
    "own largest [s]",
)
#: makes the k-th communication step; whether its results are valid
Step = Callable[[int], bool]


@dataclass(frozen=True)
class Case:
    """A scene's trip at a level of accuracy, in process or through the FMU."""

    scene: str
    trip: str
    level: Level
    place: str
    h: float  # s, communication step

    @property
    def parameters(self) -> dict[str, Value]:
        """Parameters of the rope by FMI name."""
        found = {**find_case(self.scene).rope, "solver.work_max": BOUNDS[self.h]}
        width = rope_scene(found, self.level).layout.spacing + 2.0 * ROOM
        return found | (
            {"lining.width": width, "lining.depth": width} if self.trip == "strike" else {}
        )

    @property
    def motions(self) -> list[tuple[EndMotion, EndMotion]]:
        """Motions of both ends at 0, h, 2 h ..."""
        return motions_of(self.scene, self.trip, self.h)


@lru_cache(maxsize=1)
def motions_of(scene: str, trip: str, h: float) -> list[tuple[EndMotion, EndMotion]]:
    """Return the motions of both ends at 0, h, 2 h ..."""
    plain: Winding = replace(find_case(scene).winding, start_delay=0.0)
    begin = STOP * s_curve(plain).duration
    reference = s_curve(plain if trip == "winding" else replace(plain, emergency_at=begin))
    times = [k * h for k in range(round((reference.duration + SETTLE) / h) + 1)]
    found = [ends_at(reference, plain.travel, t) for t in times]
    if trip != "strike":
        return found
    aside = (vars(moving(WAY, max(t - begin - AFTER, 0.0), MOVES, x=1.0)) for t in times)
    across = ({name: motion[name] for name in ("x", "vx", "ax")} for motion in aside)
    return [
        (replace(left, **x), replace(right, **x))
        for (left, right), x in zip(found, across, strict=True)
    ]


@contextmanager
def in_process(case: Case) -> Iterator[Step]:
    """Open the rope in this process, initialised."""
    motions = case.motions
    rope = at_rest(rope_scene(case.parameters, case.level), *motions[0])
    yield lambda k: rope.advance_to(k * case.h, *motions[k]).valid


@contextmanager
def through_fmu(case: Case, path: Path) -> Iterator[Step]:
    """Open the FMU at ``path`` with the scene's parameters, initialised."""
    description = fmpy.read_model_description(str(path))
    folder = fmpy.extract(str(path))
    variables = {v.name: v for v in description.modelVariables}
    identifier = description.coSimulation.modelIdentifier
    fmu = FMU2Slave(
        guid=description.guid,
        modelIdentifier=identifier,
        unzipDirectory=folder,
        instanceName="rope",
    )

    def references(names: Sequence[str]) -> ctypes.Array[ctypes.c_uint]:
        return (ctypes.c_uint * len(names))(*(variables[name].valueReference for name in names))

    inputs = references(
        [f"{side}.{name}" for side in ("left", "right") for name in asdict(EndMotion())]
    )
    outputs = references(READ)
    forces = (ctypes.c_double * len(READ))()
    values = [
        (ctypes.c_double * len(inputs))(*asdict(a).values(), *asdict(b).values())
        for a, b in case.motions
    ]
    fmu.instantiate()
    try:
        fmu.setBoolean([variables["inputs_at_step_end"].valueReference], [True])
        for name, value in case.parameters.items():
            variable = variables[name]
            if variable.type == "Real":
                fmu.setReal([variable.valueReference], [value])
            else:
                fmu.setInteger([variable.valueReference], [value])
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.fmi2SetReal(fmu.component, inputs, len(inputs), values[0])
        fmu.exitInitializationMode()

        def step(k: int) -> bool:
            fmu.fmi2SetReal(fmu.component, inputs, len(inputs), values[k])
            fmu.fmi2DoStep(fmu.component, (k - 1) * case.h, case.h, 1)
            fmu.fmi2GetReal(fmu.component, outputs, len(outputs), forces)
            return True  # a failed call raises

        yield step
    finally:
        fmu.freeInstance()
        shutil.rmtree(folder, ignore_errors=True)


def timed(step: Step, steps: int) -> Array:
    """Return the wall time of each step, s."""
    times = np.zeros(steps, dtype=np.int64)
    gc.collect()
    gc.disable()
    try:
        for k in range(1, steps + 1):
            start = perf_counter_ns()
            valid = step(k)
            times[k - 1] = perf_counter_ns() - start
            assert valid
    finally:
        gc.enable()
    return np.asarray(1e-9 * times, dtype=np.float64)


def work(case: Case) -> tuple[NDArray[np.int64], int]:
    """Run a case in process; what each step did (columns as COUNTED), and the number of elements."""
    rope = at_rest(rope_scene(case.parameters, case.level), *case.motions[0])
    counts = [tuple(rope.signals(COUNTED).values())]
    for k, ends in enumerate(case.motions[1:], 1):
        assert rope.advance_to(k * case.h, *ends).valid
        counts.append(tuple(rope.signals(COUNTED).values()))
    made = np.array(counts, dtype=np.int64)
    return made[1:] - made[:-1], rope.elements


def percentiles(case: Case, times: Array, elements: int) -> tuple[object, ...]:
    """Return a row of STEPS from the times (rounds, steps)."""
    as_run = np.median(np.percentile(times, PERCENTILES, axis=1), axis=1)
    late = float(np.median(np.mean(times > case.h, axis=1)))
    return *astuple(case), elements, times.shape[1], *as_run, late, times.min(axis=0).max()


def causes(case: Case, times: Array, counts: NDArray[np.int64]) -> tuple[object, ...]:
    """Return the shares of the slowest steps, and of all, in which each cause occurred, and their mean iterations."""
    order = np.argsort(times.min(axis=0))
    slow = order[-max(1, round(SLOWEST * order.size)) :]
    every = order
    shares = [
        float(np.mean(counts[chosen, k] > 0))
        for chosen in (slow, every)
        for k in range(len(CAUSES))
    ]
    means = [float(np.mean(counts[chosen, -1])) for chosen in (slow, every)]
    return *astuple(case), *shares, *means


def tables() -> Tables:
    """Measure all cases, which take turns."""
    choices = product(("in process", "FMU"), SCENES, TRIPS, BOUNDS, LEVELS)
    cases = [Case(scene, trip, level, place, h) for place, scene, trip, h, level in choices]
    done = {
        replace(c, place="FMU"): work(c)
        for c in tqdm(cases, desc="warm-up", leave=False)
        if c.place != "FMU"
    }
    times: dict[Case, list[Array]] = {case: [] for case in cases}
    with TemporaryDirectory() as folder:
        paths = {level: Path(folder) / f"{level}.fmu" for level in LEVELS}
        for level, path in paths.items():
            export_native(path, level=level, platforms=(host_platform(),))
        for case in tqdm([*cases] * ROUNDS, desc=f"{ROUNDS} rounds", leave=False):
            opened = (
                through_fmu(case, paths[case.level]) if case.place == "FMU" else in_process(case)
            )
            with opened as step:
                times[case].append(timed(step, len(case.motions) - 1))
    rows = [percentiles(c, np.array(times[c]), done[replace(c, place="FMU")][1]) for c in cases]
    slowest = [
        causes(c, np.array(times[c]), done[replace(c, place="FMU")][0])
        for c in cases
        if (c.place, c.level) == ("in process", "standard")
    ]
    names = [f"{name}, {which}" for which in ("slowest", "all") for name in CAUSES]
    named = table((*HEAD, *names, "count.newton, slowest", "count.newton, all"), slowest)
    return {"steps": table(STEPS, rows), "causes": named}


MEASURES: Measures = {"latency": tables}
