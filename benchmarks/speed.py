"""Real-time factors of the coupled 120 m TMN-ETM winding: ``make bench``.

In process and through the FMU, compiled and portable, each in a process of its own and interleaved; medians over the
rounds.  A factor is simulated time over the processor time of a communication step of 10 ms, in which the host sets
the ends' motion, steps, and reads the end forces.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np
from tqdm import tqdm

from balance_rope import DEFAULT_FMU as FMU
from fmu_src.export import export_fmu
from hoist_demo.fmu_rope import FmuRope
from hoist_demo.parameters import Winding
from hoist_demo.reference import s_curve
from hoist_demo.rope_plant import EndMotion
from rope_model.parameters import Solver, rope_120
from rope_model.simulation.signals import SIGNALS, end_signals
from rope_model.simulation.simulator import RopeSimulator

from .kinematic import ends_at

H, TRAVEL = 0.01, 90.0
READ = ("left.fy", "right.fy", "left.fy_mean", "right.fy_mean")
#: s of the winding that are run; the portable form is slow
WINDOW = {"compiled": 24.0, "portable": 4.0}
CASES = [(place, form) for form in WINDOW for place in ("in process", "FMU")]
ROUNDS = 5


def stepper(place: str, form: str) -> Callable[[float], bool]:
    """A function that steps the rope to a time and reads the end forces."""
    reference = s_curve(Winding(start_delay=0.0))
    if place == "in process":
        scene = rope_120().scene
        rope = RopeSimulator(scene.with_(solver=Solver(kernels="portable" if form == "portable" else "compiled")))
        assert rope.initialize(0.0, *ends_at(reference, TRAVEL, 0.0)).valid

        def step(t: float) -> bool:
            valid = rope.advance_to(t, *ends_at(reference, TRAVEL, t)).valid
            end_signals(rope)
            return valid

        return step

    unread = [name for name in SIGNALS if name not in READ]
    fmu = FmuRope(FMU, {"solver.kernels": {"compiled": 1, "portable": 2}[form]}, unread)

    def motions(t: float) -> list[EndMotion]:
        return [EndMotion(y=end.y, vy=end.vy, ay=end.ay) for end in ends_at(reference, TRAVEL, t)]

    assert fmu.initialize(0.0, *motions(0.0)).valid

    def step_fmu(t: float) -> bool:
        valid = fmu.step(round(t / H - 1) * H, H, *motions(t)).valid
        fmu.signals()
        return valid

    return step_fmu


def measure(place: str, form: str) -> list[float]:
    """Processor time of each communication step, s."""
    step, times = stepper(place, form), []
    for k in range(round(WINDOW[form] / H)):
        start = time.process_time()
        valid = step((k + 1) * H)
        times.append(time.process_time() - start)
        assert valid
    return times


def main() -> None:
    """Run the rounds and print medians, ratios and percentiles."""
    if not FMU.exists():
        export_fmu(FMU)
    totals: dict[tuple[str, str], list[float]] = {case: [] for case in CASES}
    steps: dict[tuple[str, str], list[float]] = {case: [] for case in CASES}
    for _ in tqdm(range(ROUNDS), desc="rounds", leave=False):
        for case in CASES:
            command = [sys.executable, "-m", "benchmarks.speed", *case]
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            times = json.loads(done.stdout.splitlines()[-1])
            totals[case].append(sum(times))
            steps[case] += times
    print(f"coupled 120 m winding, TMN-ETM, H = {H:g} s, medians of {ROUNDS} rounds")
    print(f"  {'':<24}{'real-time factor':>18}{'step, median':>15}{'95 %':>9}{'99 %':>9}")
    for case in CASES:
        factor = WINDOW[case[1]] / statistics.median(totals[case])
        median, p95, p99 = 1e3 * np.percentile(steps[case], [50, 95, 99])
        print(f"  {case[1] + ', ' + case[0]:<24}{factor:>18.2f}{median:>12.2f} ms{p95:>6.2f} ms{p99:>6.2f} ms")
    for form in WINDOW:
        ratio = statistics.median(totals["FMU", form]) / statistics.median(totals["in process", form])
        print(f"  overhead of the FMU, {form}: {100 * (ratio - 1):.1f} %")


if __name__ == "__main__":
    if len(sys.argv) == 3:
        print(json.dumps(measure(*sys.argv[1:])))
    else:
        main()
