"""What single terms of the equations change: each switched off, or varied, in three scenes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.kinematic import Winding
from rope_model.parameters import Rope

from .fidelity import force_difference, valid
from .scenes import COUPLED, LONG_TRIP, P240, STOP, Case

SCENES = {
    "winding": Case("120 m winding, swivels locked", COUPLED, "torsional"),
    "emergency stop": Case(
        "120 m winding, emergency stop at 12 s with 5 m/s^2",
        COUPLED,
        "torsional",
        trip=STOP,
        until=STOP.duration + 5.0,
    ),
    "release": Case(
        "240 m winding, swivels released at 20 s, until 25 s",
        P240.scene,
        "torsional",
        trip=LONG_TRIP,
        travel=P240.travel,
        until=25.0,
    ),
}


@dataclass(frozen=True)
class Variant:
    """A rope with one term changed."""

    term: str
    change: str
    rope: Callable[[Rope], Rope]


VARIANTS = (
    Variant("spin inertia", "rhoJ / 100", lambda r: replace(r, rhoJ=0.01 * r.rhoJ)),
    Variant("non-conservative coupling", "the published Qb, Qc", lambda r: replace(r, Qb=2.371e5, Qc=2.301e5)),
    Variant("material damping", "beta_K = 0", lambda r: replace(r, beta_K=0.0)),
    Variant("material damping", "beta_K = 1e-2 s", lambda r: replace(r, beta_K=1e-2)),
    Variant("stretch", "Qa x 10", lambda r: replace(r, Qa=10 * r.Qa)),
)


@dataclass(frozen=True)
class Change:
    """Largest change that a variant makes in a scene (the end force's root mean square), and the steps it takes."""

    scene: str
    variant: Variant
    force: float  # of the largest force
    bottom: float  # m
    theta: float  # rad, at the observation points
    torque: float  # N m, at the ends
    steps: int
    message: str


@dataclass(frozen=True)
class Base:
    """The scale of what changes."""

    scene: str
    force: float  # N
    theta: float  # rad
    torque: float  # N m
    steps: int


def base_of(name: str, run: Winding) -> Base:
    theta = float(np.abs(np.array(run.observed)[:, :, 6]).max())
    torque = float(np.abs(run.torque).max())
    return Base(name, float(np.abs(run.force).max()), theta, torque, run.rope.state.counts.steps)


def change(name: str, variant: Variant, base: Winding) -> Change:
    """One run against the base."""
    case = SCENES[name]
    run = case.wind(case.scene.with_(rope=variant.rope(case.scene.rope)))
    steps = run.rope.state.counts.steps
    if not run.status.valid:
        nan = float("nan")
        return Change(name, variant, nan, nan, nan, nan, steps, run.status.message)
    bottom = np.linalg.norm(np.array(run.bottom) - base.bottom, axis=1).max()
    theta = np.abs(np.array(run.observed) - base.observed)[:, :, 6].max()
    torque = np.abs(np.array(run.torque) - base.torque).max()
    return Change(name, variant, force_difference(run, base)[0], float(bottom), float(theta), float(torque), steps, "")


def measure(advance: Callable[[str], None]) -> tuple[list[Base], list[Change]]:
    """All scenes with all variants; ``advance`` hears of each."""
    bases, changes = [], []
    for name, case in SCENES.items():
        advance(name)
        run = valid(case.wind(case.scene))
        bases.append(base_of(name, run))
        for variant in VARIANTS:
            advance(f"{name}, {variant.change}")
            changes.append(change(name, variant, run))
    return bases, changes
