"""How long one communication step of the native rope takes, and what makes the longest ones long.

``python -m benchmarks.latency rope-120`` prints percentiles of a scene; `make latency` measures all and writes
docs/latency.md.

Measured is wall time (performance counter) around the call alone: in process `advance_to`, through the native FMU, by
FMPy's low-level functions with arrays made before, fmi2SetReal of all end motions, fmi2DoStep and fmi2GetReal of the
end forces.  All of a run's calls are made by one thread, with Python's garbage collector off, after a warm-up run of
the same scene.  The scenes are whole trips with the conveyances' motion prescribed, with or without an emergency stop.

The same run is made several times, the cases taking turns.  Its steps do the same work each time, to the bit, so

- a percentile *as run* is the median of the rounds' percentiles: with what the system puts in between, but one
  hiccup in one round does not decide it;
- a step's *own* time is the shortest of the rounds: what the rope itself takes.  On a quiet machine both agree.

Quiet means: nothing else runs, and the clock does not change (Linux: `cpupower frequency-set -g performance`), one
core kept for it (`taskset -c 1 make latency`; better one that isolcpus keeps free).
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter_ns

import fmpy
import numpy as np
from fmpy.fmi2 import (
    FMU2Slave,
    calloc,
    defaultCallbacks,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    free,
)
from numpy.typing import NDArray
from tqdm import tqdm

from fmu_src.native.build import host_platform
from fmu_src.native.export import export_native
from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data
from hoist_demo.parameters import Winding
from rope_model import SIGNALS, EndMotion, Level, balance_rope

from .kinematic import ends_at

Array = NDArray[np.float64]
#: a scene's winding comes to rest and goes on for so long, s
SETTLE = 5.0
#: an emergency stop begins at this part of the trip's duration: at rope-240 after its swivels' release
STOP = 0.6
SCENES, TRIPS = ("rope-120", "rope-240", "monopol-1000"), ("winding", "emergency stop")
LEVELS: tuple[Level, ...] = ("draft", "standard")
STEPS, FMU_STEP = (5e-3, 10e-3, 20e-3), 10e-3  # s
ROUNDS = 3
PERCENTILES = (50.0, 90.0, 99.0, 99.9, 100.0)
READ = ("left.fy", "right.fy", "left.fy_mean", "right.fy_mean")

#: makes the k-th communication step; whether its results are valid
Step = Callable[[int], bool]


@dataclass(frozen=True)
class Case:
    """A scene's trip at a level of accuracy in steps of ``H`` (s), in process or through the FMU."""

    scene: str
    trip: str
    level: Level
    H: float
    place: str = "in process"

    @property
    def winding(self) -> Winding:
        """The trip, which begins at once."""
        plain = replace(find_case(self.scene).winding, start_delay=0.0)
        return plain if self.trip == "winding" else replace(plain, emergency_at=STOP * s_curve(plain).duration)

    @cached_property
    def motions(self) -> list[tuple[EndMotion, EndMotion]]:
        """Of both ends at 0, H, 2 H ..."""
        reference, travel = s_curve(self.winding), self.winding.travel
        steps = round((reference.duration + SETTLE) / self.H)
        return [ends_at(reference, travel, k * self.H) for k in range(steps + 1)]


def cases() -> list[Case]:
    """All that are measured."""
    trips = [(scene, trip, level) for scene in SCENES for trip in TRIPS for level in LEVELS]
    inside = [Case(*trip, H) for trip in trips for H in STEPS]
    return inside + [Case(*trip, FMU_STEP, "FMU") for trip in trips]


@contextmanager
def in_process(case: Case) -> Iterator[Step]:
    """The rope in this process, initialised."""
    rope, motions, H = balance_rope(rope_data(find_case(case.scene).rope, case.level), "native"), case.motions, case.H
    started = rope.initialize(0.0, *motions[0])
    assert started.valid, started.message
    advance = rope.advance_to

    def step(k: int) -> bool:
        left, right = motions[k]
        return advance(k * H, left, right).valid

    yield step


class Memory:
    """What an instance of FMI 2.0 takes from its host."""

    def __init__(self) -> None:
        self.blocks: list[int] = []  # bytes
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = defaultCallbacks.logger
        self.callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(self._take)
        self.callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)

    def _take(self, number: int, size: int) -> int:
        self.blocks.append(number * size)
        return int(calloc(number, size))


@contextmanager
def through_fmu(case: Case, path: Path, memory: Memory) -> Iterator[Step]:
    """The FMU at ``path`` with the scene's parameters, initialised."""
    description, folder = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    variables = {v.name: v for v in description.modelVariables}
    identifier = description.coSimulation.modelIdentifier
    fmu = FMU2Slave(guid=description.guid, modelIdentifier=identifier, unzipDirectory=folder, instanceName="rope")

    def references(names: Sequence[str]) -> ctypes.Array[ctypes.c_uint]:
        return (ctypes.c_uint * len(names))(*(variables[name].valueReference for name in names))

    inputs, outputs = (
        references([f"{side}.{name}" for side in ("left", "right") for name in asdict(EndMotion())]),
        references(READ),
    )
    values = [
        (ctypes.c_double * len(inputs))(*asdict(left).values(), *asdict(right).values()) for left, right in case.motions
    ]
    forces = (ctypes.c_double * len(outputs))()
    fmu.instantiate(callbacks=memory.callbacks)
    try:
        fmu.setBoolean([variables["inputs_at_step_end"].valueReference], [True])
        for name, value in find_case(case.scene).rope.items():
            variable = variables[name]
            (fmu.setReal if variable.type == "Real" else fmu.setInteger)([variable.valueReference], [value])
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.fmi2SetReal(fmu.component, inputs, len(inputs), values[0])
        fmu.exitInitializationMode()
        component, H = fmu.component, case.H

        def step(k: int) -> bool:
            fmu.fmi2SetReal(component, inputs, len(inputs), values[k])
            fmu.fmi2DoStep(component, (k - 1) * H, H, 1)
            fmu.fmi2GetReal(component, outputs, len(outputs), forces)
            return True  # a failed call raises

        yield step
    finally:
        fmu.freeInstance()
        shutil.rmtree(folder, ignore_errors=True)


def timed(step: Step, steps: int) -> Array:
    """s, wall time of each step."""
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


@dataclass(frozen=True)
class Work:
    """What the rope did in each step: columns as COUNTED, the warm-up run of a case in process."""

    counts: NDArray[np.int64]
    elements: int
    fidelity: str


#: what is counted in a step
COUNTED = tuple(name for name in SIGNALS if name.startswith("count."))


def work(case: Case) -> Work:
    """Run a case in process and count."""
    rope = balance_rope(rope_data(find_case(case.scene).rope, case.level), "native")
    assert rope.initialize(0.0, *case.motions[0]).valid
    counts = [tuple(rope.signals(COUNTED).values())]
    for k, ends in enumerate(case.motions[1:], 1):
        assert rope.advance_to(k * case.H, *ends).valid
        counts.append(tuple(rope.signals(COUNTED).values()))
    made = np.array(counts, dtype=np.int64)
    return Work(made[1:] - made[:-1], rope.elements, rope.fidelity)


@dataclass(frozen=True)
class Measured:
    """Times (rounds, steps) in s of a case's steps; what they did, and of the FMU what it took of memory."""

    case: Case
    times: Array
    work: Work
    memory: tuple[int, int, int]  # bytes, blocks when it is initialised; blocks taken while stepping

    @property
    def own(self) -> Array:
        """s, of each step."""
        return np.asarray(self.times.min(axis=0))

    @property
    def as_run(self) -> Array:
        """s, at PERCENTILES."""
        return np.asarray(np.median(np.percentile(self.times, PERCENTILES, axis=1), axis=1))

    @property
    def late(self) -> float:
        """Share of the steps that took longer than the communication step, as run."""
        return float(np.median(np.mean(self.times > self.case.H, axis=1)))


def measure(chosen: Sequence[Case], rounds: int = ROUNDS) -> list[Measured]:
    """All rounds of the cases, which take turns."""
    inside = {case: replace(case, place="in process") for case in chosen}
    done = {case: work(case) for case in tqdm(dict.fromkeys(inside.values()), desc="warm-up", leave=False)}
    times: dict[Case, list[Array]] = {case: [] for case in chosen}
    memory = dict.fromkeys(chosen, (0, 0, 0))
    with TemporaryDirectory() as folder:
        paths = {
            level: Path(folder) / f"{level}.fmu" for case in chosen if case.place == "FMU" for level in [case.level]
        }
        for level, path in paths.items():
            export_native(path, level=level, platforms=(host_platform(),))
        for case in tqdm([*chosen] * rounds, desc=f"{rounds} rounds", leave=False):
            steps = len(case.motions) - 1
            if case.place == "in process":
                with in_process(case) as step:
                    times[case].append(timed(step, steps))
                continue
            taken = Memory()
            with through_fmu(case, paths[case.level], taken) as step:
                before = len(taken.blocks)
                times[case].append(timed(step, steps))
                memory[case] = sum(taken.blocks[:before]), before, len(taken.blocks) - before
    return [Measured(case, np.array(times[case]), done[inside[case]], memory[case]) for case in chosen]


def main() -> None:
    """Percentiles of one scene."""
    parser = argparse.ArgumentParser("python -m benchmarks.latency")
    parser.add_argument("scene", nargs="?", default=SCENES[0], help="a case of the hoist (%(default)s)")
    parser.add_argument("--rounds", type=int, default=ROUNDS, metavar="N", help="(%(default)s)")
    options = parser.parse_args()
    chosen = [Case(options.scene, trip, level, H) for trip in TRIPS for level in LEVELS for H in STEPS]
    print("us, as run, and the largest of the steps' own times")
    for found in measure(chosen, options.rounds):
        case, figures = found.case, [*found.as_run, found.own.max()]
        named = f"{case.scene}, {case.trip}, {case.level}, {1e3 * case.H:g} ms"
        print(f"{named:<46}" + "".join(f"{1e6 * x:>9.1f}" for x in figures) + f"{found.late:>10.2%} late")


if __name__ == "__main__":
    main()
