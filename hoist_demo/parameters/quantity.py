"""Parameters of files and data classes: fields with unit, meaning and bounds; reading of values.

Unit, description, ``lower``, ``upper`` and cure have the names of rope_model's parameters. There a
bound may be another parameter, and the least positive number excludes 0; here ``opens`` does.
"""

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache
from typing import Any, Literal, NamedTuple, TypeVar, cast, get_args, get_origin, get_type_hints

T = TypeVar("T")
_LARGEST_NUMBER = 1e300  #: Largest number that can be computed with.


class NumberRange(NamedTuple):
    """Bounds of a number, none where they are None, and the advice for one beyond them."""

    lower: float | None = None
    upper: float | None = None
    opens: bool = False  # lower is beyond them
    cure: str = ""

    @property
    def description(self) -> str:
        """Return the bounds in a sentence."""
        if self.lower is not None and self.upper is not None and not self.opens:
            return f"within {self.lower:.6g} and {self.upper:.6g}"
        parts = []
        if self.lower is not None:
            word = "above" if self.opens else "at least"
            parts.append(f"{word} {self.lower:.6g}")
        if self.upper is not None:
            parts.append(f"at most {self.upper:.6g}")
        return " and ".join(parts) or "finite"

    def contains(self, value: float) -> bool:
        """Return True if a number is finite and keeps them."""
        if not math.isfinite(value):
            return False
        if self.lower is not None and (value < self.lower or (self.opens and value == self.lower)):
            return False
        return self.upper is None or value <= self.upper


POSITIVE = NumberRange(0.0, opens=True)  #: Bounds of most quantities.
NONNEGATIVE = NumberRange(0.0)  #: Bounds of quantities that may be 0.
UNBOUNDED = NumberRange()  #: Bounds of quantities of either sign.
FRACTION = NumberRange(0.0, 1.0, True, "give a fraction")  #: Bounds of a share.


def parameter(default: T, unit: str, meaning: str = "", bounds: NumberRange = POSITIVE) -> T:
    """Return a field with unit ("-" of a pure number), meaning beyond its name, and bounds."""
    return field(default=default, metadata={"unit": unit, "description": meaning, "bounds": bounds})


def fmi_unit(unit: str) -> str:
    """Return the unit as FMI writes it.

    ``N s/m`` and ``N*s/m`` are ``N.s/m``, ``m/s^2`` is ``m/s2``, none is ``1``.
    """
    text = re.sub(r"[\s*·]+", ".", unit.strip()).replace("^", "")
    if text in ("", "-"):
        return "1"
    return text


Value = float | int | bool | str


def word_of(choices: Iterable[str], value: object) -> str | None:
    """Return the choice that a text names, whatever its case; None if it is none."""
    return next(
        (word for word in choices if isinstance(value, str) and word.lower() == value.lower()), None
    )


@dataclass(frozen=True)
class FileParameter:
    """A parameter by its name in files."""

    name: str
    unit: str  # FMI's spelling, "1" for none
    kind: str  # Real, Integer, Boolean or String
    start: Value = ""  # value where it is not set; a data class of the host has its own
    bounds: NumberRange = UNBOUNDED
    choices: tuple[str, ...] = ()  # words of a text, or of the codes of a number
    meaning: str = ""

    def read(self, value: object) -> Value:
        """Return the value in the parameter's type; a ``ValueError`` names key, value and cure."""
        bad = f"{self.name} = {value!r}"
        if self.kind == "Boolean":
            if not isinstance(value, bool):
                raise ValueError(f"{bad} must be true or false: write one of them")
            return value
        if self.kind == "String":
            return self._text(value)
        if self.choices:
            value = self._code(value)
        if (
            isinstance(value, bool)
            or not isinstance(value, (int, float))
            or not abs(value) <= _LARGEST_NUMBER
        ):
            raise ValueError(f"{bad} must be a finite number: give it in {self.unit_words}")
        if self.kind != "Real" and float(value) != round(value):
            raise ValueError(f"{bad} must be a whole number: round it")
        if not self.bounds.contains(value):
            cure = self.bounds.cure or f"give it in {self.unit_words}"
            raise ValueError(f"{bad} must be {self.bounds.description}: {cure}")
        if self.kind == "Real":
            return float(value)
        return round(value)

    def _text(self, value: object) -> str:
        """Return a text, or the choice that it names."""
        if not self.choices:
            text = value
            expected = "a text"
        else:
            text = word_of(self.choices, value)
            expected = f"one of {', '.join(self.choices)}"
        if not isinstance(text, str):
            raise ValueError(f"{self.name} = {value!r} must be {expected}: choose one")
        return text

    def _code(self, value: object) -> object:
        """Return the code of a choice, given by code or by word."""
        word = word_of(self.choices, value)
        code = self.choices.index(word) if word else value
        if isinstance(code, bool) or code not in range(len(self.choices)):
            codes = ", ".join(f"{k} ({word})" for k, word in enumerate(self.choices))
            raise ValueError(f"{self.name} = {value!r} must be one of {codes}: give code or word")
        return code

    @property
    def numeric(self) -> bool:
        """True for numbers, and for choices that have codes."""
        return self.kind in ("Real", "Integer")

    @property
    def unit_words(self) -> str:
        """Unit as words of a sentence."""
        if self.unit == "1":
            return "plain numbers"
        return self.unit

    @property
    def help_text(self) -> str:
        """Meaning with its unit in brackets."""
        text = self.meaning or self.name
        if self.unit == "1":
            return text
        return f"{text} [{self.unit}]"


_KINDS = {bool: "Boolean", int: "Integer", str: "String", float: "Real"}


def leaves(data: Any, prefix: str = "") -> Iterator[FileParameter]:
    """Yield all single values of a data class by dotted names.

    ``brake: Brake | None`` stands for the brake's own.
    """
    hints = get_type_hints(data)
    for one in fields(data):
        name = f"{prefix}{one.name}"
        hint = hints[one.name]
        types = (hint, *get_args(hint))
        kind = next((_KINDS[t] for t in types if t in _KINDS), None)
        start = cast(Any, one.default)
        meaning = str(one.metadata.get("description", ""))
        if get_origin(hint) is Literal:
            yield FileParameter(name, "1", "String", start, choices=get_args(hint), meaning=meaning)
        elif kind is not None:
            yield FileParameter(
                name,
                unit=fmi_unit(one.metadata.get("unit", "")),
                kind=kind,
                start=start,
                bounds=one.metadata.get("bounds", UNBOUNDED),
                meaning=meaning,
            )
        for part in types:
            if isinstance(part, type) and is_dataclass(part):
                yield from leaves(part, f"{name}.")


class ValidatedData:
    """Data that are checked when they are made, each value alone.

    ``of`` stands before their names in messages.
    """

    _of = ""

    def __init_subclass__(cls, of: str = "") -> None:
        cls._of = of

    def __post_init__(self) -> None:
        kind: Any = type(self)
        for name, parameter in _checks(kind, self._of):
            if (value := getattr(self, name)) is not None:
                parameter.read(value)


@cache
def _checks(data: Any, of: str) -> list[tuple[str, FileParameter]]:
    return [(p.name, replace(p, name=f"{of}{p.name}")) for p in leaves(data) if "." not in p.name]
