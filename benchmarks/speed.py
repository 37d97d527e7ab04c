"""Speed, start and size of the rope in all its forms: ``make bench``.

``python -m benchmarks.speed monopol-1000`` measures the native forms on the rope of another scene.
The coupled winding of a scene, the 120 m rope's by default, on TMN-ETM, communication steps of 10 ms, in which the host
sets the ends' motion, steps, and reads the end forces.  Each form runs in a process of its own, interleaved with the
others; medians over the rounds.
A real-time factor is simulated time over processor time.
"""

from __future__ import annotations

import argparse
import json
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from tqdm import tqdm

from fmu_src.export import export_fmu
from fmu_src.native.build import host_platform
from fmu_src.native.export import export_native
from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data
from hoist_demo.cosimulation.participants.rope_plant import EndMotion
from rope_model import SIGNALS, Solver, balance_rope

from .kinematic import ends_at

H, SCENE = 0.01, "rope-120"
READ = ("left.fy", "right.fy", "left.fy_mean", "right.fy_mean")
#: s of the winding that are run, and of another scene's
WINDOW = {"native": 24.0, "Python, compiled": 24.0, "Python, portable": 4.0}
DEEP_WINDOW = 60.0
CASES = [(place, form) for form in WINDOW for place in ("in process", "FMU")]
KERNELS = {"native": 0, "Python, compiled": 1, "Python, portable": 2}
ROUNDS = 5


class Measured(NamedTuple):
    """Processor time (s) of each step, of making and of hanging up the rope, and what these took of memory (MB)."""

    steps: list[float]
    made: float
    initialised: float
    memory: float


class Stepper(NamedTuple):
    """Hangs the rope up; steps it to a time and reads the end forces."""

    start: Callable[[], bool]
    step: Callable[[float], bool]


def window(form: str, scene: str) -> float:
    """s that are run."""
    return WINDOW[form] if scene == SCENE else DEEP_WINDOW


def in_process(form: str, name: str) -> Stepper:
    """The rope in this process."""
    winding = replace(find_case(name).winding, start_delay=0.0)
    reference, travel = s_curve(winding), winding.travel
    scene = rope_data(find_case(name).rope)
    if form == "native":
        rope = balance_rope(scene, "native")
    else:
        solver = Solver(kernels="portable" if "portable" in form else "compiled")
        rope = balance_rope(scene.with_(solver=solver), "python")

    def step(t: float) -> bool:
        valid = rope.advance_to(t, *ends_at(reference, travel, t)).valid
        rope.signals(READ)
        return valid

    return Stepper(lambda: rope.initialize(0.0, *ends_at(reference, travel, 0.0)).valid, step)


def through_fmu(form: str, path: Path, name: str) -> Stepper:
    """The rope in an FMU, stepped by FMPy."""
    winding = replace(find_case(name).winding, start_delay=0.0)
    reference, travel = s_curve(winding), winding.travel
    unread = [name for name in SIGNALS if name not in READ]
    fmu = FmuRope(path, {**find_case(name).rope, "solver.kernels": KERNELS[form]}, unread)

    def motions(t: float) -> list[EndMotion]:
        return [EndMotion(y=end.y, vy=end.vy, ay=end.ay) for end in ends_at(reference, travel, t)]

    def step(t: float) -> bool:
        valid = fmu.step(round(t / H - 1) * H, H, *motions(t)).valid
        fmu.signals()
        return valid

    return Stepper(lambda: fmu.initialize(0.0, *motions(0.0)).valid, step)


def resident() -> float:
    """Memory (MB) of this process; not a number where the system does not tell."""
    told = Path("/proc/self/statm")
    if not told.is_file():
        return float("nan")
    return 1e-6 * int(told.read_text(encoding="utf-8").split()[1]) * resource.getpagesize()


def measure(place: str, form: str, path: Path, scene: str) -> Measured:
    """One run of one form."""
    before, start = resident(), time.process_time()
    stepper = in_process(form, scene) if place == "in process" else through_fmu(form, path, scene)
    made = time.process_time() - start
    start = time.process_time()
    assert stepper.start()
    initialised = time.process_time() - start
    memory = resident() - before
    times = []
    for k in range(round(window(form, scene) / H)):
        start = time.process_time()
        valid = stepper.step((k + 1) * H)
        times.append(time.process_time() - start)
        assert valid
    return Measured(times, made, initialised, memory)


def instantiation(path: Path) -> tuple[float, float]:
    """Medians of wall time (s) in which an FMU, its library loaded, is instantiated and initialised."""
    description = fmpy.read_model_description(str(path))
    folder = fmpy.extract(str(path))
    instantiated, initialised = [], []
    for k in range(40):
        slave = FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=folder,
            instanceName=f"rope{k}",
        )
        start = time.perf_counter()
        slave.instantiate()
        instantiated.append(time.perf_counter() - start)
        start = time.perf_counter()
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        initialised.append(time.perf_counter() - start)
        slave.fmi2FreeInstance(slave.component)  # the library stays for the next
    shutil.rmtree(folder, ignore_errors=True)
    return statistics.median(instantiated), statistics.median(initialised)


def main() -> None:
    """Run the rounds and print medians, ratios and percentiles."""
    parser = argparse.ArgumentParser("python -m benchmarks.speed", description=__doc__)
    parser.add_argument("scene", nargs="?", default=SCENE, help="a case of the hoist (%(default)s)")
    scene: str = parser.parse_args().scene
    cases = [case for case in CASES if scene == SCENE or case[1] == "native"]
    found: dict[tuple[str, str], list[Measured]] = {case: [] for case in cases}
    with tempfile.TemporaryDirectory() as folder:
        python, native = Path(folder) / "python.fmu", Path(folder) / "native.fmu"
        export_fmu(python, platforms=(host_platform(),))
        export_native(native, platforms=(host_platform(),))
        paths = {form: native if form == "native" else python for form in WINDOW}
        for _ in tqdm(range(ROUNDS), desc="rounds", leave=False):
            for case in cases:
                command = [sys.executable, "-m", "benchmarks.speed", *case, str(paths[case[1]]), scene]
                done = subprocess.run(command, capture_output=True, text=True, check=True)
                found[case].append(Measured(*json.loads(done.stdout.splitlines()[-1])))
        starts = instantiation(native)
        sizes = {"native": native.stat().st_size, "Python": python.stat().st_size}
    print(f"winding of {scene}, TMN-ETM, H = {H:g} s, medians of {ROUNDS} rounds")
    titles = ("real-time factor", "step, median", "95 %", "99 %", "made", "initialised", "memory")
    print(f"  {'':<30}" + "".join(f"{title:>17}" for title in titles))
    factors = {}
    for case, runs in found.items():
        factors[case] = window(case[1], scene) / statistics.median(sum(run.steps) for run in runs)
        cells = [f"{1e3 * x:.3f} ms" for x in np.percentile([t for run in runs for t in run.steps], [50, 95, 99])]
        cells += [
            f"{1e3 * statistics.median(getattr(run, name) for run in runs):.1f} ms" for name in ("made", "initialised")
        ]
        cells.append(f"{statistics.median(run.memory for run in runs):.1f} MB")
        print(f"  {f'{case[1]}, {case[0]}':<30}{factors[case]:>17.1f}" + "".join(f"{cell:>17}" for cell in cells))
    for form in dict.fromkeys(form for _, form in cases):
        overhead = factors["in process", form] / factors["FMU", form] - 1
        print(f"  overhead of the FMU, {form}: {100 * overhead:.1f} %")
    if scene != SCENE:
        return
    ratio = factors["FMU", "native"] / factors["FMU", "Python, compiled"]
    print(f"  native FMU over Python FMU: {ratio:.1f} times as fast")
    print("  native FMU instantiated in {:.3f} ms, initialised in {:.2f} ms".format(*(1e3 * t for t in starts)))
    print("  size of the FMU: " + ", ".join(f"{name} {1e-6 * size:.2f} MB" for name, size in sizes.items()))


if __name__ == "__main__":
    if len(sys.argv) == 5:
        print(json.dumps(measure(sys.argv[1], sys.argv[2], Path(sys.argv[3]), sys.argv[4])))
    else:
        main()
