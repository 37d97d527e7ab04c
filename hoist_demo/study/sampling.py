"""Samples of a study: the product of lists, or a Latin hypercube over ranges.

Latin hypercube: M. D. McKay, R. J. Beckman and W. J. Conover, Technometrics 21, 1979; scipy.stats.qmc draws it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hoist_demo.parameters.quantity import Value


@dataclass(frozen=True)
class Range:
    """An interval to draw from."""

    low: float
    high: float
    logarithmic: bool = False
    whole: bool = False

    def at(self, share: float) -> float | int:
        """The value at a share between 0 and 1 of the interval."""
        if self.logarithmic:
            value = math.exp(math.log(self.low) + share * (math.log(self.high) - math.log(self.low)))
        else:
            value = self.low + share * (self.high - self.low)
        return round(value) if self.whole else min(max(value, self.low), self.high)


def grid(lists: Mapping[str, tuple[Value, ...]]) -> list[dict[str, Value]]:
    """All combinations, the last key fastest."""
    return [dict(zip(lists, values, strict=True)) for values in itertools.product(*lists.values())]


def latin_hypercube(ranges: Mapping[str, Range], runs: int, seed: int) -> list[dict[str, Value]]:
    """`runs` samples, each range cut into as many strips with one sample in each."""
    from scipy.stats import qmc  # slow to load, and a grid needs none

    shares = qmc.LatinHypercube(d=len(ranges), rng=np.random.default_rng(seed)).random(runs)
    return [{key: r.at(float(u)) for (key, r), u in zip(ranges.items(), row, strict=True)} for row in shares]
