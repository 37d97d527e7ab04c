"""Samples of a study, and the goals of a search: the table [tune], checked.

minimise   = { metric = weight }                     the cost is the weighted sum
subject_to = { metric = { below = 1, above = 0 } }   what every run must keep; may have the unit
sample, searches, steps, seed                        points of a Latin hypercube, searches from the best of them,
                                                     points of each search at most

Latin hypercube: M. D. McKay, R. J. Beckman and W. J. Conover, Technometrics 21, 1979; scipy.stats.qmc draws it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hoist_demo.design.tuning import Plan
from hoist_demo.parameters.quantity import Value, fmi_unit
from hoist_demo.study.metrics import UNITS


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


_SENSES = {"below": 1.0, "above": -1.0}


@dataclass(frozen=True)
class Bound:
    """Bound on a metric of every run."""

    metric: str
    value: float
    sense: float  # 1: below the value, -1: above it

    def excess(self, metrics: Mapping[str, float]) -> float:
        """Return the excess over the bound, as a part of it unless it is 0; 0 or less if it is kept."""
        return self.sense * (metrics[self.metric] - self.value) / (abs(self.value) or 1.0)


@dataclass(frozen=True)
class Tuning:
    """Goal, bounds and length of a search."""

    minimise: Mapping[str, float]  # weight of each metric; 1 / its unit
    bounds: tuple[Bound, ...]
    plan: Plan


def read_tuning(table: Mapping[str, Any], dimensions: int) -> Tuning:
    """The search over so many ranges; a `ValueError` names key, value and cure."""
    weights = _weights(table.get("minimise", {}))
    return Tuning(weights, _bounds(table.get("subject_to", {})), _plan(table, max(dimensions, 1)))


def whole_number(table: Mapping[str, Any], name: str, otherwise: int | None = None) -> int:
    """A count above 0; where there is none, the other one."""
    value = table.get(name, otherwise)
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ValueError(f"{name} = {value!r} must be a whole number above 0: give one")
    return value


def seed_of(table: Mapping[str, Any]) -> int:
    """The seed, 0 where there is none."""
    value = table.get("seed", 0)
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise ValueError(f"seed = {value!r} must be a whole number of at least 0: give one")
    return value


def _weights(minimise: Any) -> dict[str, float]:
    if not isinstance(minimise, dict) or not minimise:
        raise ValueError(f"minimise = {minimise!r} must be metrics with weights: {{ cycle_time = 1.0 }}")
    return {name: _number(f"minimise.{name}", _known(f"minimise.{name}", name, w)) for name, w in minimise.items()}


def _bounds(table: Any) -> tuple[Bound, ...]:
    if not isinstance(table, dict):
        raise ValueError(f"subject_to = {table!r} must be metrics with bounds: {{ sway = {{ below = 0.3 }} }}")
    found = []
    for name, bounds in table.items():
        key = f"subject_to.{name}"
        _known(key, name, bounds)
        if not isinstance(bounds, dict) or not {*_SENSES} & {*bounds} or not {*bounds} <= {*_SENSES, "unit"}:
            raise ValueError(f"{key} = {bounds!r} must have below or above, and may have unit: {{ below = 0.3 }}")
        unit = bounds.get("unit", UNITS[name])
        if fmi_unit(str(unit)) != UNITS[name]:
            raise ValueError(f"{key} has unit = {unit!r}, which must be {UNITS[name]!r}: convert the value to it")
        given = [(word, sense) for word, sense in _SENSES.items() if word in bounds]
        found += [Bound(name, _number(f"{key}.{word}", bounds[word]), sense) for word, sense in given]
    return tuple(found)


def _plan(table: Mapping[str, Any], dimensions: int) -> Plan:
    sample = whole_number(table, "sample", 4 * dimensions)
    searches, steps = whole_number(table, "searches", 2), whole_number(table, "steps", 8 * dimensions)
    least = 2 * dimensions + 2
    if searches > sample:
        raise ValueError(f"searches = {searches} must be at most sample = {sample}: each begins at a point of it")
    if steps < least:
        raise ValueError(f"steps = {steps} must be at least {least}, two for each range and two more: give more")
    return Plan(sample, searches, steps, seed_of(table))


def _known(key: str, metric: str, content: Any) -> Any:
    if metric not in UNITS:
        raise ValueError(f"{key} is not a metric: choose of {', '.join(UNITS)}")
    return content


def _number(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError(f"{key} = {value!r} must be a finite number: give one")
    return float(value)
