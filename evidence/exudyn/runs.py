"""One run of either code through a winding, and how far it is from a reference."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from tqdm import tqdm

from benchmarks.kinematic import wind
from evidence.exudyn.exudyn_rope import Method, PeerError, PeerRope
from evidence.ropes import at_rest
from evidence.tables import Array
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model import EndMotion, Mesh, Scene, rope_120
from rope_model.physics.node import arc_lengths
from rope_model.reference.outputs import lowest_point

CASE = rope_120()
TRAVEL = CASE.travel  # m
REFERENCE = s_curve(Trip())
SAMPLE = 0.04  # s; steps of 5, 10, 20 and 40 ms end on it
DURATION = SAMPLE * round((REFERENCE.duration + 3.0) / SAMPLE)  # s

#: the rope without coupling of tension and torsion, which Exudyn's elements do not have
UNCOUPLED = CASE.scene.with_(rope=replace(CASE.scene.rope, Qb=0.0, Qc=0.0))


@dataclass(frozen=True)
class Run:
    """Vertical end forces (n, 2), N, and the loop's lowest point (n, 3), m, every SAMPLE; NaN after a failure."""

    code: str  # "ours" or "Exudyn"
    group: str  # of variants that make a line
    label: str
    elements: int
    step: float  # s
    cpu: float  # s, of the time steps alone
    force: Array
    bottom: Array
    failure: str = ""

    @property
    def cost(self) -> float:
        """CPU time per simulated second."""
        return self.cpu / DURATION


def ours(group: str, label: str, scene: Scene) -> Run:
    """Return one run of ours; the host's step is the largest step."""
    step = scene.solver.step_max
    run = wind(
        scene, REFERENCE, TRAVEL, DURATION - REFERENCE.duration, round(SAMPLE / step), interval=step
    )
    run.completed(label)
    return Run(
        "ours",
        group,
        label,
        run.rope.elements,
        step,
        run.cpu,
        np.array(run.force),
        np.array(run.bottom),
    )


@cache
def hanging_shape(scene: Scene, heights: tuple[float, float]) -> tuple[Array, Array]:
    """Arc lengths and nodes (n, 7) of our equilibrium between the heights: where Exudyn's search begins."""
    left, right = (EndMotion(y=y) for y in heights)
    rope = at_rest(scene.with_(mesh=Mesh(kind="eem", elements=600)), left, right)
    return arc_lengths(rope.state.partition.lengths), rope.state.motion.q


def exudyn(element: str, count: int, method: Method) -> Run:
    """Return one run of Exudyn."""
    heights = (0.0, TRAVEL)
    label = f"{count}, {1e3 * method.step:g} ms"
    samples = round(DURATION / SAMPLE)
    try:
        rope = PeerRope(
            UNCOUPLED, element, count, hanging_shape(UNCOUPLED, heights), heights, REFERENCE
        )
        rope.rest()
        record = rope.run(DURATION, SAMPLE, method)
    except PeerError as failed:
        force = np.full((samples, 2), np.nan)
        bottom = np.full((samples, 3), np.nan)
        return Run("Exudyn", element, label, count, method.step, np.nan, force, bottom, str(failed))
    s = arc_lengths(rope.lengths)
    bottom = np.array([lowest_point(q, s).position for q in record.q])
    return Run("Exudyn", element, label, count, method.step, record.cpu, record.force, bottom)


def measure_times(cases: Mapping[str, Callable[[], Run]], rounds: int, short: float) -> list[Run]:
    """Run every case once, those below ``short`` seconds ``rounds`` times in turn; the median of the CPU times."""
    runs: dict[str, list[Run]] = {key: [] for key in cases}
    for turn in range(rounds):
        for key, case in tqdm(cases.items(), desc=f"round {turn + 1}", unit="run", leave=False):
            if turn == 0 or runs[key][0].cpu < short:
                runs[key].append(case())
    return [replace(done[0], cpu=float(np.median([r.cpu for r in done]))) for done in runs.values()]
