"""Speed and start of the rope in all its forms: ``make bench``.

``python -m benchmarks.speed monopol-1000`` measures the native forms on the rope of another scene.
The coupled winding of a scene, the 120 m rope's by default, on TMN-ETM, communication steps of 10
ms, in which the host sets the ends' motion, steps, and reads the end forces.  The forms take turns;
medians over the rounds.  A real-time factor is simulated time over processor time.
"""

import argparse
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tqdm import tqdm

from benchmarks.kinematic import ends_at
from fmu_src.native.export import export_native
from fmu_src.python.export import export_fmu
from fmu_src.shell.build import host_platform
from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from rope_model import EndMotion, balance_rope
from rope_model.public import Form

H = 0.01  # s, communication step
SCENE = "rope-120"
ROUNDS = 5
READ = ("left.fy", "right.fy", "left.fy_mean", "right.fy_mean")
#: s of the winding that are run
WINDOW: dict[Form, float] = {"native": 24.0, "reference": 4.0}
DEEP_WINDOW = 60.0  #: s of another scene's winding


class Stepper(NamedTuple):
    """Functions of a form of the rope, which return whether they succeed."""

    start: Callable[[], bool]  # hangs the rope up
    step: Callable[[float], bool]  # steps it to a time [s] and reads the end forces


class Times(NamedTuple):
    """Processor times of a run."""

    factor: float  # simulated time over processor time
    step: float  # s, median
    start: float  # s, to hang the rope up


def motions(name: str) -> Callable[[float], tuple[EndMotion, EndMotion]]:
    """Return the motion of both ends on the case's trip, which begins at once."""
    winding = replace(find_case(name).winding, start_delay=0.0)
    reference = s_curve(winding)
    return lambda t: ends_at(reference, winding.travel, t)


def in_process(form: Form, name: str) -> Stepper:
    """Return the rope in this process."""
    ends = motions(name)
    rope = balance_rope(rope_scene(find_case(name).rope), form)

    def step(t: float) -> bool:
        valid = rope.advance_to(t, *ends(t)).valid
        rope.signals(READ)
        return valid

    return Stepper(lambda: rope.initialize(0.0, *ends(0.0)).valid, step)


def through_fmu(name: str, path: Path) -> Stepper:
    """Return the rope in an FMU, stepped by FMPy."""
    ends = motions(name)
    fmu = FmuRope(path, find_case(name).rope)
    read = fmu.reader(READ)

    def moved(t: float) -> list[EndMotion]:
        return [EndMotion(y=end.y, vy=end.vy, ay=end.ay) for end in ends(t)]

    def step(t: float) -> bool:
        valid = fmu.step(round(t / H - 1) * H, H, *moved(t)).valid
        read()
        return valid

    return Stepper(lambda: fmu.initialize(0.0, *moved(0.0)).valid, step)


def measure(stepper: Stepper, window: float) -> Times:
    """Return the times of a run over this time of the winding [s]."""
    start = time.process_time()
    assert stepper.start()
    start_time = time.process_time() - start
    times = []
    for k in range(round(window / H)):
        start = time.process_time()
        valid = stepper.step((k + 1) * H)
        times.append(time.process_time() - start)
        assert valid
    return Times(window / sum(times), step=float(np.median(times)), start=start_time)


def main() -> None:
    """Run the rounds and print medians."""
    parser = argparse.ArgumentParser("python -m benchmarks.speed", description=__doc__)
    parser.add_argument("scene", nargs="?", default=SCENE, help="a case of the hoist (%(default)s)")
    scene: str = parser.parse_args().scene
    forms = WINDOW
    if scene != SCENE:
        forms = {"native": DEEP_WINDOW}
    runs = defaultdict[str, list[Times]](list)
    with tempfile.TemporaryDirectory() as folder:
        python = Path(folder) / "python.fmu"
        native = Path(folder) / "native.fmu"
        export_fmu(python, platforms=(host_platform(),))
        export_native(native, platforms=(host_platform(),))
        for _ in tqdm(range(ROUNDS), desc="rounds", leave=False):
            for form, window in forms.items():
                fmu = native if form == "native" else python
                runs[f"{form}, in process"].append(measure(in_process(form, scene), window))
                runs[f"{form}, FMU"].append(measure(through_fmu(scene, fmu), window))
    print(f"winding of {scene}, TMN-ETM, H = {H:g} s, medians of {ROUNDS} rounds")
    for name, of_form in runs.items():
        median = Times(*np.median(of_form, axis=0))
        print(
            f"  {name:<30}{median.factor:>8.1f} x real time"
            f"{1e3 * median.step:>9.3f} ms a step{1e3 * median.start:>9.1f} ms to start"
        )


if __name__ == "__main__":
    main()
