"""False trips against missed ones, for every threshold, from the table of windings.

A winding is healthy or fouls; one that fouls at rest is left out.  How far a quantity went counts the same way for all:
more is worse, so that of a clearance it is the negative one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evidence.tables import Table, rows

from .wind import CLEARANCE, LEAD, QUANTITIES

Array = NDArray[np.float64]
PEAK, EARLY = "peak", f"peak {LEAD:g} s before"


@dataclass(frozen=True)
class Guard:
    """How far a quantity went in the healthy windings, and in the foulings before they fouled."""

    healthy: Array
    fouled: Array

    def false(self, threshold: float) -> float:
        """Share of the healthy windings that trip."""
        return float(np.mean(self.healthy > threshold))

    def missed(self, threshold: float) -> float:
        """Share of the foulings that do not."""
        return float(np.mean(self.fouled <= threshold))

    @property
    def told_apart(self) -> float:
        """Share of the pairs of a fouling and a healthy winding in which the fouling went further; 1/2 is chance."""
        further = self.fouled[:, None] - self.healthy
        return float(np.mean(further > 0) + 0.5 * np.mean(further == 0))

    @property
    def highest_without_missed(self) -> float:
        """Threshold just below which every fouling trips."""
        return float(np.nextafter(self.fouled.min(), -np.inf))

    @property
    def lowest_without_false(self) -> float:
        """Threshold at which no healthy winding trips."""
        return float(self.healthy.max())

    @property
    def evenly(self) -> float:
        """Threshold with the smallest sum of both shares."""
        candidates = np.unique(np.concatenate((self.healthy, self.fouled)))
        return float(min(candidates, key=lambda x: self.false(x) + self.missed(x)))


def guard(windings: Table, quantity: str, seeds: tuple[int, ...], when: str = PEAK) -> Guard:
    """Of the windings of some seeds; ``when`` tells how long before the fouling."""
    t = rows(windings, seed=tuple(map(float, seeds)))
    sign = -1.0 if quantity == QUANTITIES[CLEARANCE] else 1.0
    healthy = rows(t, outcome="healthy")[f"{quantity}, {PEAK}"]
    fouled = rows(t, outcome="fouled")[f"{quantity}, {when}"]
    return Guard(sign * healthy, sign * fouled)
