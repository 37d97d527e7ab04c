"""A value as a file gives it: a number in SI, "22 t", or { value, unit, status, source, low, high }."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from tokenize import TokenError
from typing import Annotated, Any, get_args

from pydantic import PlainValidator, WithJsonSchema

from hoist_demo.parameters.quantity import Parameter, Value, fmi_unit
from rope_model import DatumStatus
from rope_model.texts import printable

LONGEST_TEXT = 200  #: Characters of a title, of a source, or of a name for people.

#: statuses of what is set without one, of what follows by a rule, and of what differs between runs
GIVEN, DERIVED, VARIED = "given", "derived", "varied"
STATUSES = tuple(dict.fromkeys((*get_args(DatumStatus), "data sheet", DERIVED, GIVEN)))
#: keys of a value that is a table
VALUE_KEYS = ("value", "values", "unit", "status", "source", "low", "high", "scale")
#: letters with a small power, joined; pint alone would read past commas and figures
_UNIT = re.compile(r"(?:1/)?[A-Za-z%µ°]+\^?-?\d?(?:\s*[ ./*·]\s*[A-Za-z%µ°]+\^?-?\d?)*")
#: pure numbers may be percentages; a US ton is no tonne
_SHARES, _UNCLEAR = {"%": (1.0, 100.0)}, ("ton", "tons")
_WITH_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


@dataclass(frozen=True)
class Given:
    """A value with its source; `low` and `high` are how far it may be off, in the parameter's unit."""

    value: Value
    status: str = GIVEN
    source: str = ""
    low: float | None = None
    high: float | None = None


def read_given(parameter: Parameter, content: Any) -> Given:
    """Return the value of a key; a ValueError names key, value and cure."""
    if not isinstance(content, Mapping):
        return Given(read_value(parameter, content))
    table = read_facts(parameter.name, content)
    unit, low, high = table.get("unit"), table.get("low"), table.get("high")
    ends = [None if end is None else float(read_value(parameter, end, unit)) for end in (low, high)]
    if "value" not in table and ends[0] is not None and ends[1] is not None:
        return Given(0.5 * (ends[0] + ends[1]), table.get("status", GIVEN), table.get("source", ""), *ends)
    if "value" not in table:
        raise ValueError(f"{parameter.name} = {dict(content)!r} has no value: write {{ value = ..., unit = ... }}")
    value = read_value(parameter, table["value"], unit)
    return Given(value, table.get("status", GIVEN), table.get("source", ""), *ends)


def read_facts(name: str, content: Mapping[str, Any]) -> dict[str, Any]:
    """Return a value's own table, with known keys, status and source; ValueError as `read_given`."""
    for key in content.keys() - set(VALUE_KEYS):
        raise ValueError(f"{name}.{key} is not known: the keys of a value are {', '.join(VALUE_KEYS)}")
    status = content.get("status", GIVEN)
    if status not in STATUSES:
        raise ValueError(f"{name} has status = {status!r}, which must be one of {', '.join(STATUSES)}: choose one")
    if "source" in content:
        read_text(content["source"], f"{name} source")
    return dict(content)


def read_value(parameter: Parameter, content: Any, unit: str | None = None) -> Value:
    """Return a plain value in the parameter's unit, which may stand behind the number: "22 t"."""
    if isinstance(content, str) and not parameter.choices and parameter.kind in ("Real", "Integer"):
        found = _WITH_UNIT.fullmatch(content)
        if found is None:
            raise ValueError(
                f"{parameter.name} = {content[:LONGEST_TEXT]!r} must be a finite number, with a unit behind it or in "
                f"{_unit(parameter)}: correct it"
            )
        content, unit = float(found[1]), found[2] or unit
    if unit is not None:
        content = _converted(parameter, content, unit)
    return parameter.read(content)


def _converted(parameter: Parameter, content: Any, unit: Any) -> Any:
    if not isinstance(unit, str):
        raise ValueError(f"{parameter.name} has unit = {unit!r}, which must be a text: put it in quotation marks")
    if fmi_unit(unit) == parameter.unit or isinstance(content, bool) or not isinstance(content, int | float):
        return content
    factor = _factor(fmi_unit(unit), parameter.unit) if _UNIT.fullmatch(unit.strip()) else None
    if factor is None:
        raise ValueError(
            f"{parameter.name} has unit = {unit[:LONGEST_TEXT]!r}, which must measure the same as "
            f"{_unit(parameter)}: convert the value to it"
        )
    return content * factor[0] / factor[1]


@cache
def _factor(unit: str, to: str) -> tuple[float, float] | None:
    """Return what one `unit` is in `to`, as a product and a divisor: 52 mm are 52 / 1000 m, to the last bit.

    None where they measure different things, or one is unknown.
    """
    if to == "1" or unit in _UNCLEAR or ("Hz" in unit) != ("Hz" in to):  # turns, radians and hertz are one to pint
        return _SHARES.get(unit) if to == "1" else None
    import pint  # loads slowly, and most files need it not

    powers = partial(re.sub, r"(?<=[A-Za-z])(-?\d)", r"**\1")
    registry: Any = pint.UnitRegistry()
    try:
        one = registry.Quantity(1.0, registry.parse_units(powers(unit.replace(".", "*"))))
        factor = float(one.to(registry.parse_units(powers(to.replace(".", "*")) if to != "1" else "")).magnitude)
    except (
        pint.PintError,
        ValueError,
        AttributeError,
        TypeError,
        AssertionError,
        SyntaxError,
        KeyError,
        ArithmeticError,
        TokenError,
    ):
        return None
    whole = round(1.0 / factor) if 0.0 < factor < 1.0 else 0
    return (1.0, float(whole)) if whole and math.isclose(1.0 / factor, whole, rel_tol=1e-12) else (factor, 1.0)


def _unit(parameter: Parameter) -> str:
    return "plain numbers" if parameter.unit == "1" else parameter.unit


def read_text(content: Any, where: str = "") -> str:
    """Return a title, a name or a source: a line of at most LONGEST_TEXT characters; ValueError for another."""
    what = f"{where} = " if where else ""
    if not isinstance(content, str | int | float):
        raise ValueError(f"{what}{str(content)[:LONGEST_TEXT]!r} must be a text: put it in quotation marks")
    text = str(content)
    if len(text) > LONGEST_TEXT:
        raise ValueError(
            f"{what}{text[:20]!r}... has {len(text)} characters and must have at most {LONGEST_TEXT}: shorten it"
        )
    if printable(text) != text:
        raise ValueError(f"{what}{text!r} must be a line of printable characters: leave out the others")
    return text


Text = Annotated[str, PlainValidator(read_text), WithJsonSchema({"type": "string", "maxLength": LONGEST_TEXT})]


def given(parameter: Parameter) -> Any:
    """Return the type of a key for pydantic: what it holds is a Given."""
    return Annotated[Any, PlainValidator(partial(read_given, parameter)), WithJsonSchema(value_schema(parameter))]


def value_schema(parameter: Parameter) -> dict[str, Any]:
    """Return the JSON Schema of a value with its unit and status."""
    facts = {"unit": {"type": "string"}, "status": {"enum": [*STATUSES]}, "source": {"type": "string"}}
    plain = list(_plain(parameter))
    ends = {"low": plain[0], "high": plain[0]} if parameter.kind in ("Real", "Integer") else {}
    table = {"value": {"anyOf": plain}, **facts, **ends}
    of_table = {"type": "object", "properties": table, "additionalProperties": False}
    unit = "" if parameter.unit == "1" or parameter.kind not in ("Real", "Integer") else f" [{parameter.unit}]"
    return {"anyOf": [*plain, of_table], "description": f"{parameter.meaning or parameter.name}{unit}"}


def _plain(parameter: Parameter) -> Iterable[dict[str, Any]]:
    bounds = {"minimum": parameter.minimum, "maximum": parameter.maximum}
    if parameter.kind == "Boolean":
        yield {"type": "boolean"}
    elif parameter.choices:
        yield {"enum": [*parameter.choices, *(() if parameter.kind == "String" else range(len(parameter.choices)))]}
    elif parameter.kind == "String":
        yield {"type": "string"}
    else:
        kind = "number" if parameter.kind == "Real" else "integer"
        yield {"type": kind} | {name: bound for name, bound in bounds.items() if bound is not None}
        yield {"type": "string", "pattern": r"^\s*[-+]?[0-9.]+([eE][-+]?[0-9]+)?\s*\S*"}
