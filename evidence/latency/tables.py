"""The tables of docs/data/latency, from the times of all steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from benchmarks import rest
from benchmarks.latency import COUNTED, FMU_STEP, ROUNDS, Array, Measured, cases
from benchmarks.latency import measure as measure_cases
from evidence.machine import machine
from evidence.tables import Table, Tables, table

#: part of the steps, the slowest, whose work is counted apart
SLOWEST = 0.01
#: what makes a step more than Newton iterations of the steps that it needs anyway, as it is counted
CAUSES = ("count.rejections", "count.transformations", "count.swivel_events")
#: of the curves: shares of the steps
SHARES = 60

HEAD = ("scene", "trip", "level", "place", "H [s]")
STEPS = (
    *(*HEAD, "elements", "fidelity", "steps", "rounds"),
    *("50 % [s]", "90 % [s]", "99 % [s]", "99.9 % [s]", "largest [s]", "late"),
    *("own 50 % [s]", "own 99.9 % [s]", "own largest [s]", "own late"),
)


def measure(rounds: int = ROUNDS) -> Tables:
    """All tables, from runs."""
    found = measure_cases(cases(), rounds)
    return {
        "steps": steps(found),
        "causes": causes(found),
        "curves": curves(found),
        "memory": memory(found),
        "rest": resting(),
        "machine": machine(),
    }


def _head(m: Measured) -> tuple[str | float, ...]:
    return m.case.scene, m.case.trip, m.case.level, m.case.place, m.case.H


def steps(found: Sequence[Measured]) -> Table:
    """Percentiles as run and of the steps' own times, and the shares that took longer than the communication step."""
    rows = []
    for m in found:
        own = m.own
        about = m.work.elements, m.work.fidelity, own.size, len(m.times)
        alone = np.median(own), np.percentile(own, 99.9), own.max(), np.mean(own > m.case.H)
        rows.append((*_head(m), *about, *m.as_run, m.late, *alone))
    return table(STEPS, rows)


def causes(found: Sequence[Measured]) -> Table:
    """Of the cases in process: the slowest step, and what happened in the slowest SLOWEST of the steps and in all."""
    rows = []
    for m in (m for m in found if m.case.place == "in process"):
        order = np.argsort(m.own)
        worst, slow = order[-1], order[-max(1, round(SLOWEST * order.size)) :]
        count = {name: m.work.counts[:, k] for k, name in enumerate(COUNTED)}
        shares = [float(np.mean(count[name][chosen] > 0)) for chosen in (slow, order) for name in CAUSES]
        means = [float(np.mean(count["count.newton"][chosen])) for chosen in (slow, order)]
        at = (worst + 1) * m.case.H, m.own[worst], *(int(count[name][worst]) for name in COUNTED)
        rows.append((*_head(m), *shares, *means, *explained(count, m.own), *at))
    names = [f"{name}, {which}" for which in ("slowest", "all") for name in CAUSES]
    names += ["count.newton, slowest", "count.newton, all", *EXPLAINED, "worst at [s]", "worst [s]"]
    return table((*HEAD, *names, *(f"worst {name}" for name in COUNTED)), rows)


#: what a Newton iteration and a transformation take by least squares, and the part of the variance that they explain
EXPLAINED = ("iteration [s]", "transformation [s]", "explained")


def explained(count: Mapping[str, NDArray[np.int64]], own: Array) -> tuple[float, float, float]:
    """As EXPLAINED, of the steps' own times (s)."""
    x = np.column_stack([count["count.newton"], count["count.transformations"]]).astype(float)
    taken = np.linalg.lstsq(x, own)[0]
    left = own - x @ taken
    return float(taken[0]), float(taken[1]), 1.0 - float(np.var(left) / np.var(own))


def curves(found: Sequence[Measured]) -> Table:
    """Of the level standard in steps of FMU_STEP in process: the share of the steps that took longer than a time."""
    rows = []
    for m in (m for m in found if (m.case.level, m.case.place, m.case.H) == ("standard", "in process", FMU_STEP)):
        own = np.sort(m.own)[::-1]
        ranks = np.unique(np.geomspace(1, own.size, SHARES).round().astype(int))
        rows += [(m.case.scene, m.case.trip, rank / own.size, own[rank - 1]) for rank in ranks]
    return table(("scene", "trip", "share", "time [s]"), rows)


def memory(found: Sequence[Measured]) -> Table:
    """What an instance of the FMU takes from the host."""
    rows = [
        (m.case.scene, m.case.trip, m.case.level, m.work.elements, *m.memory) for m in found if m.case.place == "FMU"
    ]
    return table(("scene", "trip", "level", "elements", "bytes", "blocks", "blocks while stepping"), rows)


def resting() -> Table:
    """Steps of a rope that rests for long."""
    names = ("what", "first [s]", "last [s]", "last, flushed [s]", "denormal operands", "at the ends", "inside")
    return table(names, [astuple(r) for r in rest.measure()])
