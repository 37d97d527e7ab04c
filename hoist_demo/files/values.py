"""A value of a file: a number in SI, "22 t", or { value, unit, status, source, low, high }."""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, partial
from tokenize import TokenError
from typing import Annotated, Any, Literal, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    PlainValidator,
    WithJsonSchema,
)

from hoist_demo.parameters.quantity import FileParameter, Value, fmi_unit
from rope_model import DatumStatus
from rope_model.texts import printable

MAX_TEXT = 200  #: Characters of a title, of a source, or of a name for people.
GIVEN = "given"  #: Status of a value that is set without one.
ASSUMED = "assumed"  #: Status of a value without a source.
DERIVED = "derived"  #: Status of a value that follows by a rule.
VARIED = "varied"  #: Status of a value that differs between runs.
STATUSES = tuple(dict.fromkeys((*get_args(DatumStatus), "data sheet", DERIVED, GIVEN)))
ValueStatus = Literal[STATUSES]  # type: ignore[valid-type]
#: letters with a small power, joined; pint alone would read past commas and figures
_UNIT = re.compile(r"(?:1/)?[A-Za-z%µ°]+\^?-?\d?(?:\s*[ ./*·]\s*[A-Za-z%µ°]+\^?-?\d?)*")
_SHARES = {"%": Fraction(1, 100)}  #: Units of pure numbers.
_UNCLEAR = ("ton", "tons")  #: Units that are refused: a US ton is no tonne.
_WITH_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")
#: A number with a comma in it, for decimals or thousands.
_COMMA = re.compile(r"\s*([-+]?\d+),(\d+)")
#: Products without a sign: kNm, Nm/rad, kgm2.
_JOINED = re.compile(r"\b([kMG]?N|kg)m(?=$|[0-9./^])")
#: Raised by pint and by the tokenizer that it takes.
_NO_UNIT = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    SyntaxError,
    TypeError,
    ValueError,
)


def read_text(content: Any) -> str:
    """Return a title, a name or a source: a line of at most MAX_TEXT characters.

    ValueError for another.
    """
    text = str(content)
    if not isinstance(content, str | int | float):
        raise ValueError(f"{text[:MAX_TEXT]!r} must be a text: put it in quotation marks")
    if len(text) > MAX_TEXT:
        raise ValueError(
            f"{text[:20]!r}... of {len(text)} characters must have at most {MAX_TEXT}: shorten it"
        )
    if printable(text) != text:
        raise ValueError(f"{text!r} must be a line of printable characters: leave out the others")
    return text


Text = Annotated[
    str, PlainValidator(read_text), WithJsonSchema({"type": "string", "maxLength": MAX_TEXT})
]


@dataclass(frozen=True)
class ParameterValue:
    """A value with its source.

    ``low`` and ``high`` are how far it may be off, in the parameter's unit.
    """

    value: Value
    status: str = GIVEN  # "": the file's
    source: str = ""
    low: float | None = None
    high: float | None = None
    follows: bool = False  # whether a rule derived it from stated values


def values_of(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values without status and source, by name."""
    values_by_name: dict[str, Any] = {}
    for key, entry in values.items():
        if isinstance(entry, ParameterValue):
            values_by_name[key] = entry.value
        else:
            values_by_name[key] = entry
    return values_by_name


def statuses(values: Mapping[str, ParameterValue]) -> dict[str, str]:
    """Return the status of each value by name."""
    return {key: entry.status for key, entry in values.items()}


def with_status(
    values: Iterable[tuple[str, object]], status: str = GIVEN
) -> dict[str, ParameterValue]:
    """Return the values among what a table sets, with this status where they state none."""
    return {
        k: replace(v, status=v.status or status) for k, v in values if isinstance(v, ParameterValue)
    }


def unreached(given: Mapping[str, ParameterValue], reached: Mapping[str, Value]) -> Iterable[str]:
    """Yield a sentence for each value of [fixed] that is not the one which a run has in the end."""
    for name, entry in given.items():
        if name not in reached:
            yield (
                f"[fixed] {name} = {entry.value!r} is a value that this command does not take: "
                "leave it out"
            )
        elif reached[name] != entry.value:
            yield (
                f"[fixed] {name} = {entry.value!r} does not reach the rope or the hoist, which has "
                f"{reached[name]!r}: leave it out"
            )


class ValueTable(BaseModel):
    """A value's own table, before its parameter is asked."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    value: Any = None
    unit: str = ""  # "": the parameter's
    status: ValueStatus = ""  # "": the file's
    source: Text = ""
    low: Any = None
    high: Any = None


def value_type(parameter: FileParameter) -> Any:
    """Return the type of a key for pydantic: what it holds is a ParameterValue."""
    read = AfterValidator(partial(_parameter_value, parameter))
    table = BeforeValidator(_as_table)
    return Annotated[ValueTable, table, read, WithJsonSchema(value_schema(parameter))]


def _as_table(content: object) -> object:
    if isinstance(content, dict):
        return content
    return {"value": content}


def _parameter_value(parameter: FileParameter, table: ValueTable) -> ParameterValue:
    low = _read_end(parameter, table.low, table.unit)
    high = _read_end(parameter, table.high, table.unit)
    if low is not None and high is not None and low > high:
        raise ValueError(
            f"{parameter.name}: low = {low:g} must be at most high = {high:g}: exchange them"
        )
    if table.value is not None:
        value = read_value(parameter, table.value, table.unit)
    elif low is not None and high is not None:
        value = 0.5 * (low + high)
    else:
        raise ValueError(
            f"{parameter.name} has no value: write {{ value = ..., unit = ... }}, or low and high"
        )
    smallest = -math.inf if low is None else low
    largest = math.inf if high is None else high
    if not isinstance(value, str) and not smallest <= value <= largest:
        raise ValueError(
            f"{parameter.name} = {value:g} must be within low and high, {smallest:g} to "
            f"{largest:g}: correct it"
        )
    return ParameterValue(value, table.status, table.source, low, high)


def _read_end(parameter: FileParameter, content: Any, unit: str) -> float | None:
    """Return an end of a range in the parameter's unit; None where the file has none."""
    if content is None:
        return None
    return float(read_value(parameter, content, unit))


def read_value(parameter: FileParameter, content: Any, unit: str = "") -> Value:
    """Return a plain value in the parameter's unit, which may stand behind the number: "22 t"."""
    if isinstance(content, str) and not parameter.choices and parameter.numeric:
        match = _WITH_UNIT.fullmatch(content)
        if comma := _COMMA.match(content):
            raise ValueError(
                f"{parameter.name} = {content[:MAX_TEXT]!r} has a comma within its number: write a "
                f"point for decimals and nothing between thousands, {comma[1]}.{comma[2]} or "
                f"{comma[1]}{comma[2]}"
            )
        if match is None:
            raise ValueError(
                f"{parameter.name} = {content[:MAX_TEXT]!r} must be a finite number, with a unit "
                f"behind it or in {parameter.unit_words}: correct it"
            )
        return parameter.read(_converted(parameter, match[1], match[2] or unit))
    if unit and isinstance(content, int | float) and not isinstance(content, bool):
        content = _converted(parameter, content, unit)
    return parameter.read(content)


def _converted(parameter: FileParameter, number: str | float, unit: str) -> float:
    """Return a number with this unit in the parameter's unit, rounded once.

    52 mm are 0.052 m, to the last bit.
    """
    factor: Fraction | None = Fraction(1)
    if unit:
        factor = _factor(_JOINED.sub(r"\1.m", fmi_unit(unit)), parameter.unit)
    if factor is None:
        raise ValueError(
            f"{parameter.name} has unit = {unit[:MAX_TEXT]!r}, which must measure the same as "
            f"{parameter.unit_words}: convert the value to it"
        )
    try:
        return float(Fraction(str(number)) * factor)
    except (ValueError, OverflowError):
        return math.nan  # the parameter refuses it


@cache
def _factor(unit: str, to: str) -> Fraction | None:
    """Return what one ``unit`` is in ``to``.

    None where they measure different things, or one is unknown.
    """
    if unit == to:
        return Fraction(1)
    if to == "1":  # to pint a pure number may be anything
        return _SHARES.get(unit)
    # turns, radians and hertz are one to pint
    if unit in _UNCLEAR or ("Hz" in unit) != ("Hz" in to) or not _UNIT.fullmatch(unit):
        return None
    import pint  # loads slowly, and most files need it not

    powers = partial(re.sub, r"(?<=[A-Za-z])(-?\d)", r"**\1")
    registry = _exact_units(pint)
    try:
        units = [registry.parse_units(powers(text.replace(".", "*"))) for text in (unit, to)]
        quantity = registry.Quantity(Fraction(1), units[0])
        return Fraction(quantity.to(units[1]).magnitude)
    except (pint.PintError, TokenError, *_NO_UNIT):
        return None


_exact_units = cache(lambda pint: pint.UnitRegistry(non_int_type=Fraction))  # made in half a second


def value_schema(parameter: FileParameter) -> dict[str, Any]:
    """Return the JSON Schema of a value with its unit and status."""
    without_table = list(_schemas_without_table(parameter))
    end_of_range = without_table[0] if parameter.numeric else False
    properties = {
        **_table_schema()["properties"],
        "value": {"anyOf": without_table},
        "low": end_of_range,
        "high": end_of_range,
    }
    table = {"type": "object", "properties": properties, "additionalProperties": False}
    return {"anyOf": [*without_table, table], "description": parameter.help_text}


ParameterValues = dict[str, ParameterValue]
_table_schema = cache(ValueTable.model_json_schema)


def _schemas_without_table(parameter: FileParameter) -> Iterable[dict[str, Any]]:
    """Yield the schemas of a value that stands without status, source and range."""
    if parameter.choices and parameter.kind == "String":
        yield {"enum": [*parameter.choices]}
    elif parameter.choices:
        yield {"enum": [*parameter.choices, *range(len(parameter.choices))]}
    elif not parameter.numeric:
        yield {"type": parameter.kind.lower()}
    else:
        bounds = parameter.bounds
        schema: dict[str, Any] = {"type": "number" if parameter.kind == "Real" else "integer"}
        if bounds.lower is not None:
            schema["exclusiveMinimum" if bounds.opens else "minimum"] = bounds.lower
        if bounds.upper is not None:
            schema["maximum"] = bounds.upper
        yield schema
        yield {"type": "string", "pattern": r"^\s*[-+]?[0-9.]+([eE][-+]?[0-9]+)?\s*\S*"}
