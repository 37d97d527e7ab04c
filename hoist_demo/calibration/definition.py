"""A file of measurements (TOML), read and checked before anything is computed.

    [rope]        construction, diameter, length, lay: what the catalogue is asked for
    [known]       properties that are known better than the catalogue does: a number, or { low, high }
    [sought]      parameters of rope and air that are looked for beside the properties: { low, high }
    [fixed]       values of rope and shaft, as in a study
    [[measured]]  what, value, sigma (its standard error), and the numbers of its kind; a list of values is a series
    [wanted]      signal, left_y, right_y: the output at rest that is to be known better

All numbers in SI units. All errors of a file are told at once. [rope] and [known] are those of the parameter file that
the fit writes, too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, TypeGuard, get_args

from hoist_demo.calibration.measurements import DEFAULTS, FOLLOWING, KINDS, MAGNITUDES, PLANES, Bench, Measurement
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data
from hoist_demo.files.catalogue import Catalogue
from hoist_demo.files.reading import FileError, flat
from hoist_demo.parameters.quantity import Parameter
from hoist_demo.study.reading import Problems, read_statuses, read_tables, read_text, read_values
from rope_model import SIGNALS, Datum, DatumStatus, KnownRope, rope
from rope_model.texts import printable

_TABLES = {"rope": dict, "known": dict, "sought": dict, "fixed": dict, "measured": list, "wanted": dict}
_ROPE = {"construction": "word", "diameter": "number", "length": "number", "lay": "word"}
#: groups of parameters that may be looked for beside the properties
SOUGHT = ("rope.", "air.")
#: s: longer than any swing after a trip lasts, and a track takes its time to compute
LONGEST = 3600.0
#: a property that is known may lie outside of the catalogue's range, but not so many times: then its unit is wrong
FAR_OFF = 10.0
#: kept in the file, for commands that need no fit
_FACTS = ("status", "source")


@dataclass(frozen=True)
class Wanted:
    """An output at rest that is to be known."""

    signal: str
    left: float  # m
    right: float  # m


@dataclass(frozen=True)
class Measured:
    """A checked file."""

    path: Path
    bench: Bench
    measurements: tuple[Measurement, ...]
    wanted: Wanted
    given: Mapping[str, str]  # where each value of [fixed] comes from


def read_measured(path: Path, parameters: Mapping[str, Parameter]) -> Measured:
    """Return the contents of a file for a rope with these parameters; raise FileError with all problems."""
    problems = Problems()
    raw = read_tables(path, "measurements", _TABLES, problems)
    known = read_known(path, raw, problems)
    fixed = read_values(Catalogue(parameters), "[fixed]", raw.get("fixed", {}), problems)
    for key in fixed.keys() & {f"rope.{name}" for name in FOLLOWING}:
        problems.append(f"[fixed] {key} follows from the properties: give [known] or [rope] instead")
    sought = _sought(path, Catalogue(parameters), raw.get("sought", {}), problems)
    tables = raw.get("measured", [])
    if not tables:
        problems.append("nothing is measured: give at least one [[measured]]")
    found = [_measurement(number, table, problems) for number, table in enumerate(tables, 1)]
    if known is not None:
        for number, m in enumerate(found, 1):
            problems += [f"measured {number}: {problem}" for problem in _out_of_reach(m, known.length)]
    wanted = _wanted(raw.get("wanted", {}), problems)
    if problems or known is None or wanted is None:
        raise FileError(path, problems)
    try:
        bench = Bench(known, rope_data(fixed), sought)
    except ValueError as error:
        raise FileError(path, [str(error)]) from error
    given = read_statuses(raw.get("fixed", {}))
    return Measured(path, bench, tuple(m for m in found if m is not None), wanted, given)


def _sought(path: Path, catalogue: Catalogue, table: Mapping[str, Any], problems: Problems) -> dict[str, Datum]:
    """The ranges of what is looked for beside the properties; what is wrong is added to the problems."""
    found = {}
    for name, content in flat(table):
        if not name.startswith(SOUGHT):
            problems.append(f"[sought] {name} must be a parameter of {' or '.join(SOUGHT)}: give it in [fixed]")
            continue
        if name in {f"rope.{one}" for one in FOLLOWING}:
            problems.append(f"[sought] {name} follows from the properties, which are all sought: give [known] instead")
            continue
        if not isinstance(content, dict) or content.keys() != {"low", "high"}:
            problems.append(f"[sought] {name} = {content!r} must be {{ low, high }}: give both")
            continue
        try:
            ends = [catalogue[name].read(content[end]) for end in ("low", "high")]
        except ValueError as error:
            problems.append(f"[sought] {error}")
            continue
        low, high = (float(end) for end in ends)
        if not 0.0 <= low < high:
            problems.append(f"[sought] {name} = {content!r} must be {{ low, high }} in order, from 0 on: exchange them")
            continue
        found[name] = Datum(low, high, catalogue[name].unit, "assumed", f"range of [sought], {path.name}")
    return found


def read_known(path: Path, raw: Mapping[str, Any], problems: Problems) -> KnownRope | None:
    """The rope of [rope] with the ranges of [known]; None where something is wrong, which is added to the problems."""
    head, before = raw.get("rope", {}), len(problems)
    for key, content in head.items():
        if key not in _ROPE:
            problems.append(f"[rope] {key} = {content!r} is not a key: it has {', '.join(_ROPE)}")
        elif not (_is_number(content) if _ROPE[key] == "number" else isinstance(content, str)):
            problems.append(f"[rope] {key} = {content!r} must be a {_ROPE[key]}: {_CURES[_ROPE[key]]}")
    for key in ("construction", "diameter"):
        if key not in head:
            problems.append(f"[rope] {key} is missing: the catalogue needs construction and diameter")
    if len(problems) > before:
        return None
    try:
        found = rope(**head)
    except ValueError as error:
        problems.append(f"[rope] {error}")
        return None
    data = dict(found.data)
    for name, content in raw.get("known", {}).items():
        _check_facts(f"[known] {name}", content if isinstance(content, dict) else {}, problems)
        if name not in data:
            problems.append(f"[known] {name} = {content!r} is not a property: they are {', '.join(data)}")
        elif (datum := _datum(path, data[name], content)) is None:
            problems.append(
                f"[known] {name} = {content!r} must be a number, or {{ low, high }} in order: give it in SI"
            )
        elif not (data[name].low <= FAR_OFF * datum.low and datum.high <= FAR_OFF * data[name].high):
            problems.append(
                f"[known] {name} = {content!r} must be within {data[name].low / FAR_OFF:.3g} and "
                f"{FAR_OFF * data[name].high:.3g} {datum.unit}, {FAR_OFF:g} times less and more than the catalogue "
                "has: check its unit"
            )
        else:
            data[name] = datum
    return replace(found, data=data)


def _check_facts(where: str, table: Mapping[str, Any], problems: Problems) -> None:
    """What is wrong with status and source of a property is added to the problems."""
    if (status := table.get("status", "measured")) not in get_args(DatumStatus):
        known = ", ".join(get_args(DatumStatus))
        problems.append(f"{where} status = {status!r} must be one of {known}: choose one")
    read_text(f"{where} source", table.get("source", ""), problems)


_CURES = {"number": "give it in m, without quotation marks", "word": "put it in quotation marks"}


def _is_number(content: Any) -> TypeGuard[float]:
    return isinstance(content, int | float) and not isinstance(content, bool) and math.isfinite(content)


def _datum(path: Path, before: Datum, content: Any) -> Datum | None:
    table = content if isinstance(content, dict) else {"low": content, "high": content}
    low, high = table.get("low"), table.get("high")
    numbers = [x for x in (low, high) if _is_number(x)]
    if len(numbers) < 2 or not 0 <= numbers[0] <= numbers[1] or table.keys() - {"low", "high", *_FACTS}:
        return None
    return Datum(
        float(numbers[0]),
        float(numbers[1]),
        before.unit,
        table.get("status", "measured"),
        str(table.get("source", printable(path.name))),
    )


def _measurement(number: int, table: Mapping[str, Any], problems: Problems) -> Measurement | None:
    """One of the measurements; None where something is wrong with it, which is added to the problems."""
    what, before = table.get("what"), len(problems)
    where = f"measured {number}"
    if not isinstance(what, str) or what not in KINDS:
        problems.append(f"{where}: what = {what!r} must be one of {', '.join(KINDS)}: choose one")
        return None
    kind = KINDS[what]
    allowed = {"name", "what", "value", "sigma", *kind.numbers, *kind.texts}
    for key in table.keys() - allowed:
        problems.append(f"{where}: {key} = {table[key]!r} is not a key of {what}: it has {', '.join(sorted(allowed))}")
    values = _numbers(where, "value", table.get("value"), "", problems)
    if what in MAGNITUDES:
        problems += [f"{where}: value = {x:g} must be above 0: give its magnitude" for x in values if x <= 0.0]
    if what == "swept":
        problems += [f"{where}: value = {x:g} must not be below 0: give its magnitude" for x in values if x < 0.0]
    numbers = {}
    for name, unit in kind.numbers.items():
        numbers[name] = _numbers(where, name, table.get(name, DEFAULTS.get(name)), unit, problems)
        if problem := _out_of_range(name, numbers[name]):
            problems.append(f"{where}: {problem}")
        if values and len(numbers[name]) not in (0, 1, len(values)):
            problems.append(
                f"{where}: {name} has {len(numbers[name])} numbers, value {len(values)}: give one or as many"
            )
    if "sigma" not in table:
        problems.append(f"{where}: sigma is missing: give the standard error of the value")
    elif not _is_number(sigma := table["sigma"]) or sigma <= 0:
        problems.append(f"{where}: sigma = {sigma!r} must be a number above 0: give the standard error of the value")
    problems += [f"{where}: {problem}" for problem in _empty_windows(numbers.get("t", ()), numbers.get("until", ()))]
    texts = {name: _text(where, name, table.get(name), problems) for name in kind.texts}
    name = read_text(f"{where}: name", table.get("name", texts.get("signal", what)), problems)
    if len(problems) > before:
        return None
    unit = kind.unit or SIGNALS[texts["signal"]].unit
    return Measurement(name, what, unit, values, float(table["sigma"]), numbers, texts)


def _empty_windows(t: Sequence[float], until: Sequence[float]) -> list[str]:
    """Return the problems of times between which something is measured."""
    pairs = zip(t, until, strict=True) if len(t) == len(until) else product(t, until)
    return [f"until = {end:g} must be above t = {start:g}: give times in s" for start, end in pairs if end <= start]


def _out_of_reach(m: Measurement | None, length: float) -> list[str]:
    """Return the problems of end heights, at rest or after a trip, for a rope of this length."""
    if m is None or "left_y" not in m.numbers:
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


def _out_of_range(name: str, numbers: tuple[float, ...]) -> str:
    """Return the problems of a measurement's circumstances; "" for none."""
    for x in numbers:
        if name in ("load", "length") and x <= 0.0:
            return f"{name} = {x:g} must be above 0: give it in {'N' if name == 'load' else 'm'}"
        if name in ("t", "until") and not 0.0 <= x <= LONGEST:
            return f"{name} = {x:g} must be in [0, {LONGEST:g}] s: count it from the start of the trip"
        if name == "travel" and x == 0.0:
            return f"travel = {x:g} must not be 0: give the way of the left end in m"
        if name in ("speed", "acceleration", "jerk") and x <= 0.0:
            return f"{name} = {x:g} must be above 0: give the limit's magnitude"
        if name == "number" and (x < 1.0 or x % 1.0):
            return f"number = {x:g} must be a whole number from 1 on: count the modes of the plane"
    return ""


def _numbers(where: str, name: str, content: Any, unit: str, problems: Problems) -> tuple[float, ...]:
    """A number, or a list of them."""
    found = content if isinstance(content, list) else [content]
    if content is None:
        problems.append(f"{where}: {name} is missing: give it in {unit or 'SI'}")
        return ()
    if not found or not all(map(_is_number, found)):
        problems.append(
            f"{where}: {name} = {content!r} must be a number or a list of numbers: give it in {unit or 'SI'}"
        )
        return ()
    return tuple(float(x) for x in found)


def _text(where: str, name: str, content: Any, problems: Problems) -> str:
    known = tuple(SIGNALS) if name == "signal" else PLANES
    if content not in known:
        hint = "one of docs/reference/variables.md, outputs" if name == "signal" else f"one of {', '.join(PLANES)}"
        problems.append(f"{where}: {name} = {content!r} must be {hint}: correct it")
    return str(content)


def _wanted(table: Mapping[str, Any], problems: Problems) -> Wanted | None:
    before = len(problems)
    for key in table.keys() - {"signal", "left_y", "right_y"}:
        problems.append(f"[wanted] {key} = {table[key]!r} is not a key: it has signal, left_y, right_y")
    signal = _text("[wanted]", "signal", table.get("signal", "loop.yaw"), problems)
    left, right = (_numbers("[wanted]", key, table.get(key, 0.0), "m", problems) for key in ("left_y", "right_y"))
    return Wanted(signal, left[0], right[0]) if len(problems) == before else None
