"""Trips of the scenes by every method: errors against the reference, and work."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from evidence.promise.scenes import Sample, draw
from evidence.promise.wind import ASKED, BEFORE, EVERY, Run, errors, wind
from evidence.tables import Tables, table
from rope_model import Accuracy, Mesh, Solver

from .methods import ALPHA, BDF2, ESDIRK3, ESDIRK4, SDIRK2, Method, bathe
from .native import rope_by

#: neither of the promise's seeds; ropes' lengths, m; how many of each kind, the first that the seed gives
SEED, LENGTHS = 50, (100.0, 400.0)
NUMBERS = {"smooth": 4, "emergency stop": 3, "release": 1}
#: the communication step, s; even steps as parts of it; the reference's, and those of what checks it
STEP, PARTS, REFERENCE_PART, CHECK_PARTS = EVERY, (1, 2, 4), 16, (8, 16)
#: one mesh for all
MESH = Mesh("auto", loop_error=ASKED.loop / 2)
TODAY, EARLIER, EVEN, RICHARDSON = "control, 0.001", "control by places", "generalized-alpha, rho 0.6", "extrapolated"
ERRORS = ("end force", "horizontal force", "loop [m]", "clamp moment")
COLUMNS = ("scene", "kind", "method", "step [s]", *ERRORS, "work", "failure")


@dataclass(frozen=True)
class Candidate:
    """A method with steps of at most ``step`` (s), and what is set for it."""

    name: str
    step: float
    method: Method = ALPHA
    changes: dict[str, Any] = field(default_factory=dict)

    def run(self, sample: Sample) -> Run:
        """One trip."""
        return wind(sample, STEP, partial(rope_by, self.method), **{**self.changes, "mesh": MESH})


def even(name: str, part: int, method: Method = ALPHA, **solver: Any) -> Candidate:
    """Steps of one length that nothing but Newton's method shortens."""
    step = STEP / part
    return Candidate(name, step, method, {"solver": Solver(step_max=step, tolerance=1e6, **solver)})


def _controlled(force: float, step: float) -> Candidate:
    """The product's steps for an error of the end force, and as much less of the loop's place."""
    asked = Accuracy(end_force=force, loop=ASKED.loop * force / ASKED.end_force)
    return Candidate(f"control, {force:g}", step, changes={"accuracy": asked, "solver": Solver(step_max=step)})


def candidates() -> Iterator[Candidate]:
    """All that are compared."""
    yield Candidate(EARLIER, STEP, changes=BEFORE)
    for force, parts in ((1e-3, (1, 2)), (1e-4, (1, 2)), (1e-5, (1,))):
        yield from (_controlled(force, STEP / part) for part in parts)
    for rho in (0.3, 0.6, 0.8, 0.9):
        shortest = CHECK_PARTS if rho == 0.6 else ()
        yield from (even(f"generalized-alpha, rho {rho:g}", part, rho_inf=rho) for part in (*PARTS, *shortest))
    for method in (bathe(0.8), BDF2, ESDIRK3, ESDIRK4, SDIRK2):
        yield from (even(method.name, part, method) for part in PARTS)


def scenes() -> list[Sample]:
    """The first of each kind, by their number."""
    left, found = dict(NUMBERS), []
    for sample in draw(SEED, 100):
        if LENGTHS[0] <= sample.scene.rope.length <= LENGTHS[1] and left[sample.kind]:
            left[sample.kind] -= 1
            found.append(sample)
    return found


def compare(sample: Sample) -> Iterator[tuple[Any, ...]]:
    """Of one scene; the runs of generalized-alpha give the extrapolated ones too."""
    exact = even("reference", REFERENCE_PART, ESDIRK4, newton_tolerance=1e-9).run(sample)
    if exact.failure:
        raise RuntimeError(f"scene {sample.number}, reference: {exact.failure}")
    runs: dict[float, Run] = {}
    for candidate in candidates():
        run = candidate.run(sample)
        if candidate.name == EVEN:
            runs[candidate.step] = run
        yield _row(sample, candidate.name, candidate.step, run, exact)
    for part in PARTS:
        yield _row(sample, RICHARDSON, STEP / part, _extrapolated(runs[STEP / part], runs[STEP / part / 2]), exact)


def _extrapolated(long: Run, short: Run) -> Run:
    """The second order's error taken out, from runs whose steps are as two to one."""
    return replace(short, signals=(4 * short.signals - long.signals) / 3, work=long.work + short.work)


def _row(sample: Sample, name: str, step: float, run: Run, exact: Run) -> tuple[Any, ...]:
    force, sideways, loop, moment, _ = errors(run, exact)
    return sample.number, sample.kind, name, step, force, sideways, loop, moment, run.work, run.failure


def measure(track: Iterable[Sample]) -> Tables:
    """All tables; ``track`` goes through the scenes."""
    found, told = [], []
    for sample in track:
        found += list(compare(sample))
        told.append(_facts(sample))
    return {"methods": table(COLUMNS, found), "scenes": table(FACTS, told)}


FACTS = ("scene", "kind", "length [m]", "mass [kg/m]", "EI [N m2]", "swivels", "speed [m/s]", "deceleration [m/s2]")


def _facts(sample: Sample) -> tuple[Any, ...]:
    rope, trip = sample.scene.rope, sample.trip
    braked = trip.emergency_deceleration if sample.is_stopped else np.nan
    head = sample.number, sample.kind, rope.length, rope.mass_per_length, rope.EI
    return *head, sample.scene.left.mode, trip.speed, braked
