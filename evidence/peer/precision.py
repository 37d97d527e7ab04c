"""Work against precision: fronts, and what equal errors cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from .runs import Error, Run

Metric = Literal["force", "loop"]
#: where the codes are compared: relative end force, and m
LEVELS: dict[Metric, tuple[float, ...]] = {"force": (1e-3, 3e-4, 1e-4, 5e-5), "loop": (2e-2, 1e-2, 5e-3, 3e-3, 2e-3)}


@dataclass(frozen=True)
class Measured:
    """A run and its errors against our finest mesh and against Exudyn's."""

    run: Run
    ours: Error
    peer: Error

    def of(self, metric: Metric) -> float:
        """The larger of the two errors: neither code is its own judge."""
        a, b = ((e.force, e.loop)[metric == "loop"] for e in (self.ours, self.peer))
        return max(a, b)


def front(measured: list[Measured], metric: Metric) -> list[Measured]:
    """The runs that no other one beats in both error and cost, cheapest first."""
    kept: list[Measured] = []
    for m in sorted((m for m in measured if np.isfinite(m.of(metric))), key=lambda m: m.run.cpu):
        if not kept or m.of(metric) < kept[-1].of(metric):
            kept.append(m)
    return kept


def cost_at(kept: list[Measured], metric: Metric, level: float) -> float:
    """CPU time per simulated second of an error of ``level`` or better, interpolated on a front in logarithms.

    NaN when no run is that good.
    """
    errors, costs = np.log([(m.of(metric), m.run.cost) for m in reversed(kept)]).T
    return float(np.exp(np.interp(np.log(level), errors, costs, left=np.nan)))
