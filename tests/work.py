"""How much work ropes need that come to rest, and communication steps that succeed: ``python tests/work.py``.

The bounds on both, of rope_model.simulation.stepping.hang and stepping, stand above the largest numbers found here.
Ropes are turned in by up to TURNS turns, some in linings that leave no room.  Steps are those of the trips of
random_shafts and of emergency stops, at errors of down to a hundredth of the usual.
"""

from __future__ import annotations

import argparse
import ctypes
import math
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
from random_poses import poses
from random_shafts import draw
from scenes import ends_at

from hoist_demo.control.trajectory import emergency_stop, s_curve
from rope_model import EndMotion, Layout, Lining, Mesh, Model, Rope, Scene, Shaft, Swivel, at_level
from rope_model.codegen.build import sources
from rope_model.engine import NativeRope, declare
from rope_model.numerics.kernels import cache_folder, compile_library, find_compiler
from rope_model.simulation.stepping.hang import MOST_CORRECTIONS
from rope_model.simulation.stepping.stepping import most_work

SEED, RESTS, TRIPS = 27, 60, 120
TURNS = 20.0
STEPS = (0.01, 0.02, 0.05, 0.1)  # s
LONGEST = 10.0  # s, of a trip that is looked at
TELL = """
#include "simulator.h"
int64_t rope_corrections(const Simulator *rope);
int64_t rope_corrections(const Simulator *rope) { return rope->corrections; }
"""


@cache
def telling_library() -> ctypes.CDLL:
    compiler = find_compiler()
    assert compiler
    library = declare(ctypes.CDLL(str(compile_library(sources() | {"tell.c": TELL}, compiler, cache_folder(), "work"))))
    library.rope_corrections.restype, library.rope_corrections.argtypes = ctypes.c_int64, [ctypes.c_void_p]
    return library


class TellingRope(NativeRope):
    _library = staticmethod(telling_library)

    @property
    def corrections(self) -> int:
        return int(self._lib.rope_corrections(self._rope))


def rests(number: int) -> Iterator[tuple[Scene, EndMotion, EndMotion]]:
    """Every second one a pose of random_poses, the others turned in far, half of those in a lining."""
    rng = np.random.default_rng(SEED)
    known = poses(SEED, number)
    for k in range(number):
        if k % 2 == 0:
            pose = next(known)
            yield pose.scene, pose.left, pose.right
            continue
        length, EI = np.exp(rng.uniform(np.log((10.0, 0.5)), np.log((1200.0, 500.0)))).tolist()
        spacing, turns, rises = rng.uniform(0.8, 3.0), rng.uniform(-1.0, 1.0) * TURNS, rng.uniform(-0.9, 0.9)
        Qb, Qc = (2.336e5 * rng.uniform(-1.0, 1.0, 2)).tolist()
        lining = Lining(width=spacing * rng.uniform(0.9, 1.3), depth=rng.uniform(0.1, 1.0))
        scene = Scene(
            Rope(length=length, EI=EI, installed_twist=turns * 2.0 * math.pi, Qb=Qb, Qc=Qc),
            Layout(spacing),
            mesh=Mesh("auto"),
            model=Model("torsional"),
            shaft=Shaft(lining=lining) if k % 4 == 1 else Shaft(),
        )
        yield scene, EndMotion(), EndMotion(y=rises * length)


def step_works(seed: int) -> Iterator[tuple[float, int, float]]:
    """Interval (s), Newton iterations and bound of each communication step of a trip."""
    rng, case = np.random.default_rng([SEED, seed]), draw(SEED * 1000 + seed)
    H, share = float(rng.choice(STEPS)), float(rng.choice([0.01, 0.1, 1.0]))
    touch = replace(case.scene.shaft.contact, rope_stiffness=float(rng.choice([0.0, 1e5])))
    rope = replace(case.scene.rope, EI=math.exp(rng.uniform(math.log(20.0), math.log(600.0))))
    swivel = Swivel(rng.choice(["locked", "free", "coulomb"]), start="locked")  # that lets go at once
    shaft = replace(case.scene.shaft, contact=touch)
    scene = at_level(Scene(rope, case.scene.layout, swivel, swivel, shaft=shaft), "standard")
    error = share * scene.accuracy.end_force
    scene = replace(scene, model=Model("torsional"), accuracy=replace(scene.accuracy, end_force=error))
    full = s_curve(case.trip)
    trip = emergency_stop(full, 0.4 * full.duration, rng.uniform(2.0, 8.0), rng.uniform(20.0, 200.0))

    reference, native = trip if seed % 2 else full, NativeRope(scene)
    if not native.initialize(0.0, *ends_at(reference, case.trip.travel, 0.0)).valid:
        return
    for k in range(1, round(min(full.duration, LONGEST) / H)):
        before = native.state.counts.newton
        if not native.advance_to(k * H, *ends_at(reference, case.trip.travel, k * H)).valid:
            return
        yield H, native.state.counts.newton - before, float(most_work(H, scene.solver.step_max))


def main() -> None:
    parser = argparse.ArgumentParser("python tests/work.py", description=__doc__)
    parser.add_argument("--rests", type=int, default=RESTS)
    parser.add_argument("--trips", type=int, default=TRIPS)
    options = parser.parse_args()
    needed: list[int] = []
    given_up: list[int] = []
    seconds: list[float] = []
    for scene, left, right in rests(options.rests):
        rope, begun = TellingRope(scene), time.process_time()
        valid = rope.initialize(0.0, left, right).valid
        (needed if valid else given_up).append(rope.corrections)
        seconds.append(time.process_time() - begun)
    print(f"{len(needed)} ropes come to rest, with at most {max(needed)} corrections; the bound is {MOST_CORRECTIONS}")
    print(f"{len(given_up)} do not, after at most {max(given_up)}; the longest start takes {max(seconds):.1f} s")
    steps = [step for seed in range(options.trips) for step in step_works(seed)]
    for H in STEPS:
        works = [(work, bound) for interval, work, bound in steps if interval == H]
        if works:
            work, bound = max(works)
            print(f"H = {H:5g} s: {len(works):6d} steps, at most {work:5d} Newton iterations, bound {bound:.0f}")


if __name__ == "__main__":
    main()
