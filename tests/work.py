"""How much work ropes need that come to rest, and communication steps that succeed: ``python tests/work.py``.

The bounds on both, of rope_model.simulation.stepping.hang and stepping, stand above the largest numbers found here.
Ropes are turned in by up to TURNS turns, some in linings that leave no room.  Steps are those of the trips of
random_shafts and of emergency stops, at errors of down to a hundredth of the usual.  The rests are those of the
Python form, which makes the native one's corrections and tells their number.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from unittest.mock import patch

import numpy as np
from random_poses import poses
from random_shafts import draw

from hoist_demo.control.trajectory import emergency_stop, s_curve
from rope_model import EndMotion, Layout, Lining, Mesh, Model, Rope, RopeSimulator, Scene, Shaft, at_level, balance_rope
from rope_model.parameters import Swivel
from rope_model.simulation.stepping import hang as hanging
from rope_model.simulation.stepping import statics
from rope_model.simulation.stepping.stepping import most_work

SEED, RESTS, TRIPS = 27, 60, 30
TURNS = 40.0
STEPS = (0.001, 0.005, 0.01, 0.02, 0.05, 0.1)  # s
LONGEST = 12.0  # s, of a trip that is looked at


@dataclass
class Searches:
    """Corrections of one initialisation: all, those of searches that found no rest, and those of its longest search."""

    all: int = 0
    lost: int = 0
    longest: int = 0


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
        spacing, twist, rises = (
            rng.uniform(0.8, 3.0),
            rng.uniform(-1.0, 1.0) * 2.0 * math.pi * TURNS,
            rng.uniform(-0.9, 0.9),
        )
        Qb, Qc = (2.336e5 * rng.uniform(-1.0, 1.0, 2)).tolist()
        lining = Lining(width=spacing * rng.uniform(0.9, 1.3), depth=rng.uniform(0.1, 1.0))
        scene = Scene(
            Rope(length=length, EI=EI, installed_twist=twist, Qb=Qb, Qc=Qc),
            Layout(spacing),
            mesh=Mesh("auto"),
            model=Model("torsional"),
            shaft=Shaft(lining=lining) if k % 4 == 1 else Shaft(),
        )
        yield scene, EndMotion(), EndMotion(y=rises * length)


def search(scene: Scene, left: EndMotion, right: EndMotion) -> tuple[bool, Searches]:
    """Whether it comes to rest, and what it took."""
    found = Searches()

    def counted(*arguments: object, **named: object) -> statics.Equilibrium:
        try:
            rest = statics.find_equilibrium(*arguments, **named)  # type: ignore[arg-type]
        except statics.StaticsError as error:
            found.all += error.corrections
            found.lost += 0 if error.turned else error.corrections
            raise
        found.all, found.longest = found.all + rest.iterations, max(found.longest, rest.iterations)
        return rest

    with patch("rope_model.simulation.stepping.hang.find_equilibrium", counted):
        return RopeSimulator(scene).initialize(0.0, left, right).valid, found


def step_works(seed: int) -> Iterator[tuple[float, int, float]]:
    """Interval (s), Newton iterations and bound of each communication step of a trip."""
    rng, case = np.random.default_rng([SEED, seed]), draw(SEED * 1000 + seed)
    H, share = float(rng.choice(STEPS)), float(rng.choice([0.01, 0.1, 1.0]))
    touch = replace(case.scene.shaft.contact, rope_stiffness=float(rng.choice([0.0, 1e5])))
    rope = replace(case.scene.rope, EI=math.exp(rng.uniform(math.log(20.0), math.log(600.0))))
    swivel = Swivel(rng.choice(["locked", "free", "coulomb"]))
    scene = at_level(
        Scene(rope, case.scene.layout, swivel, swivel, shaft=replace(case.scene.shaft, contact=touch)), "standard"
    )
    error = share * scene.accuracy.end_force
    scene = replace(scene, model=Model("torsional"), accuracy=replace(scene.accuracy, end_force=error))
    full = s_curve(case.trip)
    trip = emergency_stop(full, 0.4 * full.duration, rng.uniform(2.0, 8.0), rng.uniform(20.0, 200.0))

    def ends(t: float) -> tuple[EndMotion, EndMotion]:
        p = (trip if seed % 2 else full).at(t)
        other = case.trip.travel - p.position
        return EndMotion(y=p.position, vy=p.speed, ay=p.acceleration), EndMotion(
            y=other, vy=-p.speed, ay=-p.acceleration
        )

    native = balance_rope(scene, "native")
    if not native.initialize(0.0, *ends(0.0)).valid:
        return
    for k in range(1, round(min(full.duration, LONGEST) / H)):
        before = native.state.counts.newton
        if not native.advance_to(k * H, *ends(k * H)).valid:
            return
        yield H, native.state.counts.newton - before, float(most_work(H, scene.solver.step_max))


def main() -> None:
    parser = argparse.ArgumentParser("python tests/work.py", description=__doc__)
    parser.add_argument("--rests", type=int, default=RESTS)
    parser.add_argument("--trips", type=int, default=TRIPS)
    options = parser.parse_args()
    found = [search(*one) for one in rests(options.rests)]
    good = [searches for valid, searches in found if valid]
    most, lost = max(s.all for s in good), max(s.lost for s in good)
    print(f"{len(good)} of {len(found)} ropes come to rest, with at most {most} corrections, {lost} of them lost, and")
    print(
        f"{max(s.longest for s in good)} in a search; the bounds are {hanging.MOST_CORRECTIONS} and {hanging.MOST_LOST}"
    )
    steps = [step for seed in range(options.trips) for step in step_works(seed)]
    for H in STEPS:
        works = [(work, bound) for interval, work, bound in steps if interval == H]
        if works:
            work, bound = max(works)
            print(f"H = {H:5g} s: {len(works):6d} steps, at most {work:5d} Newton iterations, bound {bound:.0f}")


if __name__ == "__main__":
    main()
