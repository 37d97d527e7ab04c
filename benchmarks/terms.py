"""What each term that is off by default changes in a winding, and what it costs: ``make terms``.

Three ropes are wound as their cases say, in C, with all defaults and then with one term at a time.  Printed per term:
the largest changes of the loop's lowest place, of the ends' vertical forces and of the loop's yaw, and the processor
time of the steps over that of the run without, by medians of runs that take turns.  Takes five minutes.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from tqdm import tqdm

from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data
from rope_model import BalanceRope, Scene

from .kinematic import Array, Winding, wind

CASES = ("rope-120", "rope-240", "monopol-1000")
ROUNDS = 3
SETTLE = 10.0  # s
AIR = {"air.density": 1.2}
#: far away, so that the looking is what costs
FAR = {
    "lining.width": 60.0,
    "lining.depth": 60.0,
    "conveyance.height": 3.0,
    "conveyance.width": 0.2,
    "conveyance.depth": 0.2,
    "head_ropes.diameter": 0.04,
    "sump.level": -2000.0,
}
#: name: parameters over those of the case
TERMS: Mapping[str, Mapping[str, Any]] = {
    "nothing": {},
    "damping of torsion, 20 times that of stretch": {"rope.torsion_damping": 20.0},
    "damping of bending, 20 times that of stretch": {"rope.bending_damping": 20.0},
    "torsional stiffness that grows with tension, c2 = 0.5": {"rope.c2": 0.5},
    "air at rest": AIR,
    "conveyances in it, b = 0.3": AIR | {"air.buffet": 0.3},
    "a gallery of 5 m in mid-shaft, 10 m/s across": AIR | {"air.vz": 10.0, "air.cross_height": 5.0},
    "wires that rub, EI to 10 EI": {"rope.EI_stick": 10.0},
    "permanent curvature of 0.05 1/m": {"rope.initial_curvature": 0.05},
    "legs that may touch": {"contact.rope_stiffness": 1e6},
    "bodies that are far": FAR,
}


def scene_with(case: str, term: str) -> Scene:
    """The rope of a case with a term; wires stick at so many times its EI, a gallery is in the middle of its way."""
    case_of, parameters = find_case(case), dict(TERMS[term])
    if "rope.EI_stick" in parameters:
        parameters["rope.EI_stick"] *= rope_data(case_of.rope).rope.EI
    if "air.cross_height" in parameters:
        parameters["air.cross_y"] = 0.5 * abs(case_of.winding.travel)
    return rope_data({**case_of.rope, **parameters, "model.fidelity": 1})  # torsional


def run(case: str, term: str) -> tuple[Winding, Array]:
    """A winding, and the loop's yaw (rad) in it."""
    trip, yaw = find_case(case).winding, list[float]()

    def watch(rope: BalanceRope) -> None:
        yaw.append(float(rope.signals(["loop.yaw"])["loop.yaw"]))

    found = wind(scene_with(case, term), s_curve(trip), abs(trip.travel), SETTLE, watch=watch)
    assert found.status.valid, (case, term, found.status.message)
    return found, np.array(yaw)


def lines(case: str) -> Iterator[str]:
    """A line for each term."""
    runs: dict[str, list[tuple[Winding, Array]]] = {term: [] for term in TERMS}
    for _ in range(ROUNDS):
        for term in tqdm(TERMS, desc=case, leave=False):
            runs[term].append(run(case, term))
    plain, plain_yaw = runs["nothing"][0]
    for term, found in runs.items():
        one, yaw = found[0]
        loop = np.linalg.norm(np.subtract(one.bottom, plain.bottom), axis=1).max()
        force = np.abs(np.subtract(one.force, plain.force)).max()
        cost = statistics.median(w.cpu / p.cpu for (w, _), (p, _) in zip(found, runs["nothing"], strict=True))
        turned = np.degrees(np.abs(yaw - plain_yaw).max())
        yield f"{term:<54}{1e3 * loop:>9.2f} mm{force:>10.2f} N{turned:>8.2f} deg{cost:>8.2f}"


def main() -> None:
    argparse.ArgumentParser("python -m benchmarks.terms", description=__doc__).parse_args()
    for case in CASES:
        print(f"\n{case + ': changes by at most':<54}{'loop':>12}{'end force':>12}{'yaw':>12}{'time':>8}")
        for line in lines(case):
            print(line, flush=True)


if __name__ == "__main__":
    main()
