"""Values that a study varies: lists, and ranges to draw from.

Latin hypercube: M. D. McKay, R. J. Beckman and W. J. Conover, Technometrics 21, 1979; scipy.stats.qmc draws it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np
from pydantic import PlainValidator, WithJsonSchema

from hoist_demo.files.values import read_facts, read_value
from hoist_demo.parameters.quantity import Parameter, Value


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


def varied(parameter: Parameter) -> Any:
    """Return the type of a key of [vary] for pydantic: what it holds is a tuple of values, or a Range."""
    unit = "" if parameter.unit == "1" else f" [{parameter.unit}]"
    schema = {"type": ["array", "object"], "description": f"{parameter.meaning or parameter.name}{unit}"}
    return Annotated[Any, PlainValidator(partial(read_varied, parameter)), WithJsonSchema(schema)]


def read_varied(parameter: Parameter, content: Any) -> tuple[Value, ...] | Range:
    """Return the values of a list, or the Range of { low, high }; a ValueError names key, value and cure."""
    name = parameter.name
    table = read_facts(name, {"values": content} if isinstance(content, list) else _table(name, content))
    unit, values = table.get("unit"), table.get("values")
    if isinstance(values, list) and values and not table.keys() & {"low", "high", "scale", "value"}:
        return tuple(read_value(parameter, value, unit) for value in values)
    if not {"low", "high"} <= table.keys() or table.keys() & {"value", "values"}:
        raise ValueError(f"{name} = {content!r} must be a list with values, or have low and high: give them")
    if parameter.kind not in ("Real", "Integer") or parameter.choices:
        raise ValueError(f"{name} = {content!r} must be a list, for it is no number: list its values")
    low, high = (float(read_value(parameter, table[end], unit)) for end in ("low", "high"))
    scale = table.get("scale", "linear")
    if scale not in ("linear", "log"):
        raise ValueError(f"{name} has scale = {scale!r}, which must be linear or log: choose one")
    if not low < high:
        raise ValueError(f"{name} has low = {low!r}, which must be below high = {high!r}: exchange them")
    if scale == "log" and low <= 0.0:
        raise ValueError(f"{name} has low = {low!r}, which must be above 0 for scale = 'log': raise it or take linear")
    return Range(low, high, scale == "log", parameter.kind == "Integer")


def _table(name: str, content: Any) -> Mapping[str, Any]:
    if not isinstance(content, Mapping):
        raise ValueError(f"{name} = {content!r} must be a list or {{ low, high }}: fix it in [fixed]")
    return content
