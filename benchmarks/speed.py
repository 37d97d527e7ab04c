"""Speed and start of the rope in all its forms: ``make bench``.

``python -m benchmarks.speed monopol-1000`` measures the native forms on the rope of another scene.  The coupled winding
of a scene, the 120 m rope's by default, on TMN-ETM, communication steps of 10 ms, in which the host sets the ends'
motion, steps, and reads the end forces.  The forms take turns; medians over the rounds.  A real-time factor is
simulated time over processor time.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tqdm import tqdm

from benchmarks.kinematic import ends_at
from fmu_src.export import export_fmu
from fmu_src.native.build import host_platform
from fmu_src.native.export import export_native
from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from rope_model import EndMotion, Solver, balance_rope

H, SCENE, ROUNDS = 0.01, "rope-120", 5
READ = ("left.fy", "right.fy", "left.fy_mean", "right.fy_mean")
#: s of the winding that are run, and of another scene's
WINDOW, DEEP_WINDOW = {"native": 24.0, "Python, compiled": 24.0, "Python, portable": 4.0}, 60.0
KERNELS = {"native": 0, "Python, compiled": 1, "Python, portable": 2}


class Stepper(NamedTuple):
    """Hangs the rope up; steps it to a time and reads the end forces."""

    start: Callable[[], bool]
    step: Callable[[float], bool]


def motions(name: str) -> Callable[[float], tuple[EndMotion, EndMotion]]:
    """Return the motion of both ends on the case's trip, which begins at once."""
    winding = replace(find_case(name).winding, start_delay=0.0)
    reference, travel = s_curve(winding), winding.travel
    return lambda t: ends_at(reference, travel, t)


def in_process(form: str, name: str) -> Stepper:
    """Return the rope in this process."""
    ends, scene = motions(name), rope_scene(find_case(name).rope)
    solver = Solver(kernels="portable" if "portable" in form else "compiled")
    native = form == "native"
    rope = (
        balance_rope(scene, "native")
        if native
        else balance_rope(scene.with_(solver=solver), "python")
    )

    def step(t: float) -> bool:
        valid = rope.advance_to(t, *ends(t)).valid
        rope.signals(READ)
        return valid

    return Stepper(lambda: rope.initialize(0.0, *ends(0.0)).valid, step)


def through_fmu(form: str, name: str, path: Path) -> Stepper:
    """Return the rope in an FMU, stepped by FMPy."""
    ends, fmu = (
        motions(name),
        FmuRope(path, {**find_case(name).rope, "solver.kernels": KERNELS[form]}),
    )
    read = fmu.reader(READ)

    def moved(t: float) -> list[EndMotion]:
        return [EndMotion(y=end.y, vy=end.vy, ay=end.ay) for end in ends(t)]

    def step(t: float) -> bool:
        valid = fmu.step(round(t / H - 1) * H, H, *moved(t)).valid
        read()
        return valid

    return Stepper(lambda: fmu.initialize(0.0, *moved(0.0)).valid, step)


def measure(stepper: Stepper, window: float) -> tuple[float, float, float]:
    """Return the real-time factor, the median step and the time to hang up, s of the processor."""
    start = time.process_time()
    assert stepper.start()
    initialised, times = time.process_time() - start, []
    for k in range(round(window / H)):
        start = time.process_time()
        valid = stepper.step((k + 1) * H)
        times.append(time.process_time() - start)
        assert valid
    return window / sum(times), float(np.median(times)), initialised


def main() -> None:
    """Run the rounds and print medians."""
    parser = argparse.ArgumentParser("python -m benchmarks.speed", description=__doc__)
    parser.add_argument("scene", nargs="?", default=SCENE, help="a case of the hoist (%(default)s)")
    scene: str = parser.parse_args().scene
    forms = WINDOW if scene == SCENE else {"native": DEEP_WINDOW}
    found: dict[str, list[tuple[float, float, float]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        python, native = Path(folder) / "python.fmu", Path(folder) / "native.fmu"
        export_fmu(python, platforms=(host_platform(),))
        export_native(native, platforms=(host_platform(),))
        for _ in tqdm(range(ROUNDS), desc="rounds", leave=False):
            for form, window in forms.items():
                fmu = native if form == "native" else python
                found.setdefault(f"{form}, in process", []).append(
                    measure(in_process(form, scene), window)
                )
                found.setdefault(f"{form}, FMU", []).append(
                    measure(through_fmu(form, scene, fmu), window)
                )
    print(f"winding of {scene}, TMN-ETM, H = {H:g} s, medians of {ROUNDS} rounds")
    for name, runs in found.items():
        factor, step, initialised = np.median(runs, axis=0)
        print(
            f"  {name:<30}{factor:>8.1f} x real time{1e3 * step:>9.3f} ms a step{1e3 * initialised:>9.1f} ms to start"
        )


if __name__ == "__main__":
    main()
