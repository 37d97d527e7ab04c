"""Values that a study varies: lists, and ranges to draw from.

Latin hypercube: M. D. McKay, R. J. Beckman and W. J. Conover, Technometrics 21, 1979;
scipy.stats.qmc draws it.
"""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    WithJsonSchema,
)

from hoist_demo.files.values import read_value
from hoist_demo.parameters.quantity import FileParameter, Value


@dataclass(frozen=True)
class Range:
    """Interval from which a study draws values."""

    low: float
    high: float
    logarithmic: bool = False
    whole: bool = False

    def at(self, share: float) -> float | int:
        """Return the value at a share between 0 and 1 of the interval."""
        if self.logarithmic:
            low = math.log(self.low)
            value = math.exp(low + share * (math.log(self.high) - low))
        else:
            value = self.low + share * (self.high - self.low)
        if self.whole:
            return round(value)
        return min(max(value, self.low), self.high)


def grid(lists: Mapping[str, tuple[Value, ...]]) -> list[dict[str, Value]]:
    """Return all combinations, the last key fastest."""
    return [dict(zip(lists, values, strict=True)) for values in itertools.product(*lists.values())]


def latin_hypercube(ranges: Mapping[str, Range], runs: int, seed: int) -> list[dict[str, Value]]:
    """Draw ``runs`` points, each range cut into as many strips with one point in each."""
    from scipy.stats import qmc  # slow to load, and a grid needs none

    shares = qmc.LatinHypercube(d=len(ranges), rng=np.random.default_rng(seed)).random(runs)
    points = []
    for row in shares:
        point: dict[str, Value] = {}
        for (key, interval), share in zip(ranges.items(), row, strict=True):
            point[key] = interval.at(float(share))
        points.append(point)
    return points


class _Interval(BaseModel, extra="forbid"):
    low: Any
    high: Any
    unit: str = ""
    scale: Literal["linear", "log"] = "linear"


class _List(BaseModel, extra="forbid"):
    values: list[Any] = Field(min_length=1)
    unit: str = ""


def varied(parameter: FileParameter) -> Any:
    """Return the type of a key of [vary] for pydantic: a tuple of values, or a Range."""
    return Annotated[
        Annotated[_List, Tag("list")] | Annotated[_Interval, Tag("range")],
        Discriminator(_kind),
        BeforeValidator(partial(_table, parameter.name)),
        AfterValidator(partial(_read, parameter)),
        WithJsonSchema({"type": ["array", "object"], "description": parameter.help_text}),
    ]


def _kind(table: object) -> str:
    """Return the tag of a table."""
    if isinstance(table, dict) and "values" in table:
        return "list"
    return "range"


def _table(name: str, content: object) -> object:
    if isinstance(content, list):
        return {"values": content}
    if not isinstance(content, dict) or not content.keys() & {"values", "low", "high"}:
        raise ValueError(
            f"{name} = {content!r} must be a list with values, or {{ low, high }}: fix it in "
            "[fixed]"
        )
    return content


def _read(parameter: FileParameter, table: _List | _Interval) -> tuple[Value, ...] | Range:
    name = parameter.name
    unit = table.unit
    if isinstance(table, _List):
        return tuple(read_value(parameter, value, unit) for value in table.values)
    low = float(read_value(parameter, table.low, unit))
    high = float(read_value(parameter, table.high, unit))
    if parameter.choices or not parameter.numeric:
        raise ValueError(f"{name} must be a list, for it is no number: list its values")
    if not low < high:
        raise ValueError(
            f"{name} has low = {low!r}, which must be below high = {high!r}: exchange them"
        )
    if table.scale == "log" and low <= 0.0:
        raise ValueError(
            f"{name} has low = {low!r}, which must be above 0 for scale = 'log': raise it or take "
            "linear"
        )
    return Range(low, high, logarithmic=table.scale == "log", whole=parameter.kind == "Integer")
