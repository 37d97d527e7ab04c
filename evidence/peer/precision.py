"""Work against precision: runs with their errors, fronts, and what equal errors cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from evidence.tables import Table

Metric = Literal["force", "loop"]
#: where the codes are compared: relative end force, and m
LEVELS: dict[Metric, tuple[float, ...]] = {"force": (1e-3, 3e-4, 1e-4, 5e-5), "loop": (2e-2, 1e-2, 5e-3, 3e-3, 2e-3)}


@dataclass(frozen=True)
class Point:
    """A run of a table: time and errors.  NaN where it failed."""

    code: str  # "ours" or "Exudyn"
    group: str  # of variants that make a line
    label: str
    step: float  # s
    cost: float  # CPU time per simulated second
    force: float  # relative to the largest force
    loop: float  # m
    failure: str = ""

    def of(self, metric: Metric) -> float:
        """One of the two errors."""
        return self.loop if metric == "loop" else self.force


def points(t: Table) -> list[Point]:
    """The planar windings; of the errors against our finest mesh and Exudyn's the larger: neither is its own judge."""
    force, loop = (
        np.maximum(t[f"{name}_vs_ours{unit}"], t[f"{name}_vs_exudyn{unit}"])
        for name, unit in (("force_error", ""), ("loop_error", "_m"))
    )
    columns = (t["code"], t["group"], t["variant"], t["step_s"], t["cpu_s_per_s"], force, loop, t["failure"])
    return [Point(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]


def front(given: Sequence[Point], metric: Metric) -> list[Point]:
    """The runs that no other one beats in both error and cost, cheapest first."""
    kept: list[Point] = []
    for p in sorted((p for p in given if np.isfinite(p.of(metric))), key=lambda p: p.cost):
        if not kept or p.of(metric) < kept[-1].of(metric):
            kept.append(p)
    return kept


def cost_at(kept: Sequence[Point], metric: Metric, level: float) -> float:
    """CPU time per simulated second of an error of ``level`` or better, interpolated on a front in logarithms.

    NaN when no run is that good.
    """
    errors, costs = np.log([(p.of(metric), p.cost) for p in reversed(kept)]).T
    return float(np.exp(np.interp(np.log(level), errors, costs, left=np.nan)))
