"""Ropes in poses from a seed, kind by kind: the first hangs as drawings show it, the last has everything at once.

Nearly everything is drawn over the whole range that the rope takes, so that many poses are absurd: none may fail but
with a reason that names value, bound and cure.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rope_model import EndMotion, Layout, Mesh, Model, Rope, Scene, balance_rope

SEED, NUMBER = 2026, 1000
LENGTH, MASS, BENDING, SPACING = (60.0, 1200.0), (3.0, 15.0), (50.0, 3000.0), (1.2, 3.0)  # m, kg/m, N m^2, m
#: EA (N) per mass per length (kg/m); the other stiffnesses grow with the section as those of the published case
STIFFNESS = (1.1e7, 2.0e7)
PUBLISHED = Rope()
#: (Qb - Qc) / (Qb + Qc): the published pair has .015
UNSYMMETRIC = (-0.5, 0.5)
#: how near an end the loop hangs, in rope lengths
NEAR = (0.05, 0.5)
ASIDE = 3.0  # m: how far an end hangs beside its place, in rope lengths no more than a tenth
TURNS = 3.0  # of yaw of an end, and of installed twist


@dataclass(frozen=True)
class Pose:
    kind: str
    scene: Scene
    left: EndMotion
    right: EndMotion


#: what each kind has beside hanging straight; draws of the same number are the same rope
KINDS = {
    "as drawn": (),
    "height difference": ("height",),
    "ends aside": ("height", "aside"),
    "sides swapped": ("height", "aside", "swapped"),
    "ends yawed": ("height", "yawed"),
    "twist installed": ("height", "twisted"),
    "Qb, Qc unequal": ("height", "unsymmetric"),
    "all at once": ("height", "aside", "swapped", "yawed", "twisted", "unsymmetric"),
}


def poses(seed: int = SEED, number: int = NUMBER) -> Iterator[Pose]:
    rng = np.random.default_rng(seed)
    for k in range(number):
        kind = list(KINDS)[k % len(KINDS)]
        yield _pose(rng, kind, frozenset(KINDS[kind]))


def _pose(rng: np.random.Generator, kind: str, has: frozenset[str]) -> Pose:
    def evenly(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    def in_logarithms(bounds: tuple[float, float]) -> float:
        return float(np.exp(rng.uniform(*np.log(bounds))))

    def if_has(what: str, value: float) -> float:
        return value if what in has else 0.0

    length, mass, spacing = in_logarithms(LENGTH), evenly(*MASS), evenly(*SPACING)
    Qa, section = mass * in_logarithms(STIFFNESS), mass / PUBLISHED.mass_per_length
    stiffer = Qa / PUBLISHED.Qa
    Qs = evenly(0.0, 1.0) * stiffer * math.sqrt(section) * PUBLISHED.Qs
    unequal = if_has("unsymmetric", evenly(*UNSYMMETRIC))
    rope = Rope(
        length=length, mass_per_length=mass, Qa=Qa, Qb=(1.0 + unequal) * Qs, Qc=(1.0 - unequal) * Qs,
        Qd=stiffer * section * PUBLISHED.Qd, EI=in_logarithms(BENDING), rhoJ=section**2 * PUBLISHED.rhoJ,
        diameter=math.sqrt(section) * PUBLISHED.diameter,
        installed_twist=if_has("twisted", evenly(-1.0, 1.0) * 2.0 * math.pi * TURNS),
    )  # fmt: skip
    rises = if_has("height", evenly(-1.0, 1.0) * (1.0 - 2.0 * NEAR[0]) * length)
    aside = min(ASIDE, 0.1 * length)
    ends = []
    for side in (-1.0, 1.0):
        x = if_has("aside", evenly(-0.3, 0.3) * spacing) - if_has("swapped", side * spacing)
        z = if_has("aside", evenly(-1.0, 1.0) * aside)
        yaw = if_has("yawed", evenly(-1.0, 1.0) * 2.0 * math.pi * TURNS)
        ends.append(EndMotion(x=x, y=0.5 * side * rises, z=z, yaw=yaw))
    scene = Scene(rope, Layout(spacing), mesh=Mesh("auto"), model=Model("torsional"))
    return Pose(kind, scene, ends[0], ends[1])


@dataclass(frozen=True)
class Rest:
    """What became of a pose: the reason it was refused for, or what was found, and the processor time (s) it took."""

    kind: str
    refusal: str
    cpu: float
    weight_error: float = 0.0  # relative
    snapped: bool = False


def hang(pose: Pose) -> Rest:
    rope, start = balance_rope(pose.scene), time.process_time()
    status = rope.initialize(0.0, pose.left, pose.right)
    cpu = time.process_time() - start
    if not status.valid:
        return Rest(pose.kind, status.message, cpu)
    data = pose.scene.rope
    weight = data.mass_per_length * pose.scene.layout.gravity * data.length
    carried = -sum(rope.signals(["left.fy", "right.fy"]).values())
    return Rest(pose.kind, "", cpu, abs(carried / weight - 1.0), rope.state.snapped_at != 0)


#: a refusal names a bound and a cure, which the search's own failure cannot
NO_REASON = "no equilibrium within"
