"""A file of measurements (TOML), read and checked before anything is computed.

    [rope]        construction, diameter, length, lay: what the catalogue is asked for
    [known]       properties that are known better than the catalogue does: a number, or { low, high, status, source }
    [sought]      parameters of rope and air that are looked for beside the properties: { low, high }
    [fixed]       values of rope and shaft, as in a study
    [[measured]]  what, value, sigma (its standard error), and the numbers of its kind; a list of values is a series
    [wanted]      signal, left_y, right_y: the output at rest that is to be known better

All errors of a file are told at once. [rope] and [known] are those of the parameter file that the fit writes, too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal, Union

from pydantic import BeforeValidator, Field, create_model, model_validator

from hoist_demo.calibration.measurements import DEFAULTS, FOLLOWING, KINDS, MAGNITUDES, PLANES, Bench, Measurement
from hoist_demo.calibration.tracks import Markers, read_track
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data
from hoist_demo.files.catalogue import rope_parameters
from hoist_demo.files.fixed import cure, fixed_model, fixed_values, plain, statuses
from hoist_demo.files.reading import FileError, Table, flat, optional, read_toml, validated
from hoist_demo.files.values import Given, Text, given
from rope_model import SIGNALS, Datum, DatumStatus, KnownRope, Rope, rope
from rope_model.catalogue import PROPERTIES, Lay
from rope_model.texts import printable

#: groups of parameters that may be looked for beside the properties
SOUGHT = ("rope.", "air.")
#: s: longer than any swing after a trip lasts, and a track takes its time to compute
LONGEST = 3600.0
#: a property that is known may lie outside of the catalogue's range, but not so many times: then its unit is wrong
FAR_OFF = 10.0

#: bounds of a measurement's circumstances
_BOUNDS: dict[str, Any] = {
    **dict.fromkeys(("load", "length", "speed", "acceleration", "jerk"), Field(gt=0.0, allow_inf_nan=False)),
    **dict.fromkeys(("t", "until"), Field(ge=0.0, le=LONGEST)),
    "number": Field(ge=1.0, multiple_of=1.0),
}
_ANY = Field(allow_inf_nan=False)
#: an output, docs/reference/variables.md
Signal: Any = Literal[tuple(SIGNALS)]


@dataclass(frozen=True)
class Measured:
    """A checked file."""

    path: Path
    bench: Bench
    measurements: tuple[Measurement, ...]
    wanted: Wanted
    given: Mapping[str, str]  # where each value of [fixed] comes from


class Wanted(Table):
    """An output at rest that is to be known."""

    signal: Signal = "loop.yaw"
    left_y: float = Field(default=0.0, allow_inf_nan=False)  # m
    right_y: float = Field(default=0.0, allow_inf_nan=False)  # m


class RopeAsked(Table):
    """What the catalogue is asked for."""

    file: Text = Field(default="", alias="from")
    construction: Text = ""
    diameter: given(rope_parameters()["rope.diameter"]) = None  # type: ignore[valid-type]
    length: given(rope_parameters()["rope.length"]) = None  # type: ignore[valid-type]
    lay: Lay = "right-hand"


class Range(Table):
    """A property that is known better than the catalogue does, or a parameter that is looked for."""

    low: float = Field(ge=0.0, allow_inf_nan=False)
    high: float = Field(ge=0.0, allow_inf_nan=False)
    status: DatumStatus = "measured"
    source: Text = ""

    @model_validator(mode="after")
    def _in_order(self) -> Range:
        if self.low > self.high:
            raise ValueError(f"low = {self.low:g} must be at most high = {self.high:g}: exchange them")
        return self


def _both_ends(content: Any) -> Any:
    return content if isinstance(content, dict) else {"low": content, "high": content}


#: ranges by property
Properties = dict[str, Annotated[Range, BeforeValidator(_both_ends)]]


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


def _listed(content: Any) -> Any:
    return content if isinstance(content, list) else [content]


def _numbers(one: Any) -> Any:
    number = Annotated[float, one]
    return Annotated[tuple[number, ...], BeforeValidator(_listed), Field(min_length=1)]


@cache
def _model() -> type[Table]:
    kinds = []
    for what, kind in KINDS.items():
        of_value = Field(gt=0.0) if what in MAGNITUDES else Field(ge=0.0) if what == "swept" else _ANY
        fields: dict[str, Any] = {"what": (Literal[what], ...), "value": (_numbers(of_value), ...)}
        for name, unit in kind.numbers.items():
            default = (DEFAULTS[name],) if name in DEFAULTS else ...
            fields[name] = (_numbers(_BOUNDS.get(name, _ANY)), Field(default, description=unit))
        for name in kind.texts:
            fields[name] = (Signal if name == "signal" else Literal[PLANES], ...)
        kinds.append(create_model(what.title().replace(" ", ""), __base__=_Measured, **fields))
    union: Any = Annotated[Union[(*kinds, Markers)], Field(discriminator="what")]
    made: type[Table] = create_model(
        "MeasurementsFile",
        __base__=Table,
        rope=(RopeAsked, ...),
        known=(Properties, {}),
        sought=(dict[str, Any], {}),
        fixed=optional(fixed_model()),
        measured=(Annotated[list[union], Field(min_length=1)], ...),
        wanted=(Wanted, Wanted()),
    )
    return made


def read_measured(path: Path) -> Measured:
    """Return the contents of a file; raise FileError with all problems."""
    file: Any = validated(path, _model(), read_toml(path), cure)
    problems: list[str] = []
    known = known_rope(path, file.rope, file.known, problems)
    fixed = fixed_values(file.fixed)
    problems += follows_from_properties(fixed)
    sought = _sought(path, file.sought, problems)
    found = []
    for number, one in enumerate(file.measured, 1):
        try:
            m = _measurement(one, path.parent, known.length if known else math.inf)
        except ValueError as error:
            problems.append(f"measured {number}: {error}")
            continue
        found.append(m)
        problems += [f"measured {number}: {problem}" for problem in _out_of_reach(m, known.length if known else 0.0)]
    if problems or known is None:
        raise FileError(path, problems)
    try:
        bench = Bench(known, rope_data(plain(fixed)), sought)
    except ValueError as error:
        raise FileError(path, [str(error)]) from error
    return Measured(path, bench, tuple(found), file.wanted, statuses(fixed))


def follows_from_properties(fixed: Mapping[str, Given]) -> list[str]:
    """Return a line on each value of [fixed] that the properties decide."""
    names = sorted(fixed.keys() & {f"rope.{name}" for name in FOLLOWING})
    return [f"[fixed] {name} follows from the properties: give [known] or [rope] instead" for name in names]


def known_rope(path: Path, asked: RopeAsked, known: Mapping[str, Range], problems: list[str]) -> KnownRope | None:
    """Return the catalogue's rope with the ranges of [known]; None where something is wrong, as the problems say."""
    diameter, length = (None if one is None else float(one.value) for one in (asked.diameter, asked.length))
    needed = [] if asked.construction else [name for name in PROPERTIES if name not in known]
    if diameter is None or needed:
        also = f", without a construction [known] {', '.join(needed)}" if needed else ""
        problems.append(f"[rope] construction or diameter is missing: the catalogue needs both{also}")
        return None
    size = Rope.length if length is None else length
    try:
        # without a construction the file alone says what bounds a property
        anything = {name: Datum(0.0, math.inf, one.unit, "assumed", "") for name, one in PROPERTIES.items()}
        found = (
            rope(asked.construction, diameter, size, asked.lay)
            if asked.construction
            else KnownRope("", diameter, size, asked.lay, anything)
        )
    except ValueError as error:
        problems.append(f"[rope] {error}")
        return None
    data = dict(found.data)
    for name, one in known.items():
        if name not in data:
            problems.append(f"[known] {name} is not a property: they are {', '.join(data)}")
        elif not (data[name].low <= FAR_OFF * one.low and one.high <= FAR_OFF * data[name].high):
            said = f"{one.low:g} to {one.high:g}" if one.low < one.high else f"{one.high:g}"
            problems.append(
                f"[known] {name} = {said} must be within {data[name].low / FAR_OFF:.3g} and "
                f"{FAR_OFF * data[name].high:.3g} {data[name].unit}, {FAR_OFF:g} times less and more than the "
                "catalogue has: check its unit"
            )
        else:
            source = one.source or printable(path.name)
            data[name] = Datum(one.low, one.high, data[name].unit, one.status, source)
    return replace(found, data=data)


def _sought(path: Path, table: Mapping[str, Any], problems: list[str]) -> dict[str, Datum]:
    """The ranges of what is looked for beside the properties; what is wrong is added to the problems."""
    found, parameters = {}, rope_parameters()
    for name, content in flat(table):
        try:
            if not name.startswith(SOUGHT) or name not in parameters:
                raise ValueError(f"must be a parameter of {' or '.join(SOUGHT)}: give it in [fixed]")
            if name in {f"rope.{one}" for one in FOLLOWING}:
                raise ValueError("follows from the properties, which are all sought: give [known] instead")
            if not isinstance(content, dict) or content.keys() != {"low", "high"}:
                raise ValueError(f"= {content!r} must be {{ low, high }}: give both")
            low, high = (float(parameters[name].read(content[end])) for end in ("low", "high"))
            if not 0.0 <= low < high:
                raise ValueError(f"= {content!r} must be {{ low, high }} in order, from 0 on: exchange them")
            found[name] = Datum(low, high, parameters[name].unit, "assumed", f"range of [sought], {path.name}")
        except ValueError as error:
            problems.append(f"[sought] {name} {error}")
    return found


def _measurement(table: Any, folder: Path, length: float) -> Measurement:
    """One of the measurements of a rope of ``length`` (m); ``folder`` is that of the file."""
    if isinstance(table, Markers):
        track = read_track(folder, table, length)
        values = (0.0,) * (int(track.seen.sum()) + track.seen[0].size + 1)
        return Measurement(table.name or table.file, table.what, "m", values, table.sigma, {}, {}, track)
    kind = KINDS[table.what]
    texts = {name: getattr(table, name) for name in kind.texts}
    name = table.name or texts.get("signal", table.what)
    unit = kind.unit or SIGNALS[texts["signal"]].unit
    numbers = {name: getattr(table, name) for name in kind.numbers}
    return Measurement(name, table.what, unit, table.value, table.sigma, numbers, texts)


def _out_of_reach(m: Measurement, length: float) -> list[str]:
    """Return the problems of end heights, at rest or after a trip, for a rope of this length."""
    if "left_y" not in m.numbers or not length:
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
