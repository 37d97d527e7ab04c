"""A file of measurements, from which a rope is identified; a list of values is a series."""

from __future__ import annotations

from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal, Self, Union

from pydantic import AfterValidator, BeforeValidator, Field, create_model, model_validator

from hoist_demo.calibration.measurements import DEFAULTS, KINDS, MAGNITUDES, PLANES, Bench, Measurement
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data
from hoist_demo.files.catalogue import rope_parameters, table
from hoist_demo.files.reading import EMPTY, Table, flat, read
from hoist_demo.files.rope_file import FOLLOWING
from hoist_demo.files.run_values import RopeQuestion
from hoist_demo.files.values import Given, Text, given, plain, statuses
from hoist_demo.parameters.quantity import Parameter
from rope_model import SIGNALS, Datum

#: groups of parameters that may be looked for beside the properties
SOUGHT = ("rope", "air")
#: s: longer than any swing after a trip lasts, and a track takes its time to compute
LONGEST = 3600.0

#: bounds of a measurement's circumstances
_BOUNDS: dict[str, Any] = {
    **dict.fromkeys(("load", "length", "speed", "acceleration", "jerk"), Field(gt=0.0, allow_inf_nan=False)),
    **dict.fromkeys(("t", "until"), Field(ge=0.0, le=LONGEST)),
    "number": Field(ge=1.0, multiple_of=1.0),
}
_ANY = Field(allow_inf_nan=False)
#: an output, docs/reference/variables.md
Signal: Any = Literal[tuple(SIGNALS)]


class Wanted(Table):
    """An output at rest that is to be known."""

    signal: Signal = "loop.yaw"
    left_y: float = Field(0.0, allow_inf_nan=False)  # m
    right_y: float = Field(0.0, allow_inf_nan=False)  # m


def _sought(parameter: Parameter) -> Any:
    """Return the type of a parameter that is looked for."""

    def checked(one: Given) -> Given:
        if parameter.name in {f"rope.{name}" for name in FOLLOWING}:
            raise ValueError(f"{parameter.name} follows from the properties, all of which are sought: give [known]")
        if one.low is None or one.high is None or not 0.0 <= one.low < one.high:
            raise ValueError(f"{parameter.name} = {one.value!r} must be {{ low, high }}, in order and from 0 on")
        return one

    return Annotated[given(parameter), AfterValidator(checked)]


_Sought = flat("Sought", {group: (table(group, _sought), None) for group in SOUGHT})


class _Measured(Table):
    """One of the measurements."""

    name: Text = ""
    sigma: float = Field(gt=0.0, allow_inf_nan=False)

    @model_validator(mode="after")
    def _belong_together(self) -> _Measured:
        values: Any = vars(self)
        many = len(values["value"])
        for name in KINDS[values["what"]].numbers:
            if len(values[name]) not in (1, many):
                raise ValueError(f"{name} has {len(values[name])} numbers, value {many}: give one or as many")
        t, until = values.get("t", ()), values.get("until", ())
        for start, end in zip(t, until, strict=True) if len(t) == len(until) else product(t, until):
            if end <= start:
                raise ValueError(f"until = {end:g} must be above t = {start:g}: give times in s")
        if 0.0 in values.get("travel", ()):
            raise ValueError("travel = 0 must not be 0: give the way of the left end in m")
        return self

    def measurement(self) -> Measurement:
        """Return the measurement."""
        values: Any = vars(self)
        kind = KINDS[values["what"]]
        texts = {name: values[name] for name in kind.texts}
        unit = kind.unit or SIGNALS[texts["signal"]].unit
        name, numbers = self.name or texts.get("signal", values["what"]), {name: values[name] for name in kind.numbers}
        return Measurement(name, values["what"], unit, values["value"], self.sigma, numbers, texts)


def _numbers(one: Any) -> Any:
    """Return the type of a number, or of a list of some."""
    as_list = BeforeValidator(lambda content: content if isinstance(content, list) else [content])
    return Annotated[tuple[Annotated[float, one], ...], as_list, Field(min_length=1)]


def _kind(what: str) -> Any:
    """Return the model of a kind of measurement."""
    of_value = Field(gt=0.0) if what in MAGNITUDES else Field(ge=0.0) if what == "swept" else _ANY
    fields: dict[str, Any] = {"what": (Literal[what], ...), "value": (_numbers(of_value), ...)}
    for name, unit in KINDS[what].numbers.items():
        default = (DEFAULTS[name],) if name in DEFAULTS else ...
        fields[name] = (_numbers(_BOUNDS.get(name, _ANY)), Field(default, description=unit))
    fields |= {name: (Signal if name == "signal" else Literal[PLANES], ...) for name in KINDS[what].texts}
    return create_model(what.title().replace(" ", ""), __base__=_Measured, **fields)


_Any: Any = Annotated[Union[tuple(map(_kind, KINDS))], Field(discriminator="what")]  # noqa: UP007 (of a tuple)


class Measured(RopeQuestion):
    """Declaration of all keys."""

    sought: Annotated[dict[str, Given], _Sought] = EMPTY
    measured: list[_Any] = Field(min_length=1)
    wanted: Wanted = EMPTY

    @cached_property
    def measurements(self) -> tuple[Measurement, ...]:
        """What was measured."""
        return tuple(one.measurement() for one in self.measured)

    @cached_property
    def bench(self) -> Bench:
        """The rope on which it is predicted."""
        where = f"range of [sought], {self.path.name}"
        ranges = {
            name: Datum(float(one.low or 0.0), float(one.high or 0.0), rope_parameters()[name].unit, "assumed", where)
            for name, one in self.sought.items()
        }
        return Bench(self.catalogue_rope, rope_data(plain(self.fixed)), ranges)

    @property
    def given(self) -> dict[str, str]:
        """Where each value of [fixed] comes from."""
        return statuses(self.fixed)

    @model_validator(mode="after")
    def _is_within_reach(self) -> Self:
        length = self.bench.known.length
        problems = [
            f"measured {k}: {problem}"
            for k, one in enumerate(self.measurements, 1)
            for problem in _out_of_reach(one, length)
        ]
        if problems:
            raise ValueError("\n".join(problems))
        return self


def read_measured(path: Path) -> Measured:
    """Return the contents of a file; raise FileError with all problems."""
    return read(path, Measured)


def _out_of_reach(m: Measurement, length: float) -> list[str]:
    """Return the problems of end heights, at rest or after a trip, for a rope of this length."""
    if "left_y" not in m.numbers:
        return []
    apart = [(left, right, left - right) for left, right in m.each("left_y", "right_y")]
    if "travel" in m.numbers:
        ways = [travel for (travel,) in m.each("travel")]
        apart += [(left, right, gap + 2 * way) for (left, right, gap), way in zip(apart, ways, strict=True)]
    return [
        f"left_y = {left:g}, right_y = {right:g}: the ends must be less than the rope's length = {length:g} m apart, "
        f"before and after a trip, and are {abs(gap):g} m: correct left_y, right_y or travel, in m"
        for left, right, gap in apart
        if abs(gap) >= length
    ]
