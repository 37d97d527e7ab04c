"""Parameters of files and data classes: fields that state their unit and meaning, units in one spelling, values read.

The metadata have the same names as those of rope_model's parameters.
"""

import math
import re
from collections.abc import Iterable
from dataclasses import Field, dataclass, field, fields
from typing import Any, TypeVar

T = TypeVar("T")
#: beyond it a number is none that could be computed with
_MOST = 1e300


def quantity(default: T, unit: str, meaning: str = "") -> T:
    """A field with its unit, "-" of a pure number, and with what it means beyond its name."""
    return field(default=default, metadata={"unit": unit, "description": meaning})


def unit_of(of: Field[Any]) -> str:
    """The unit that a field states, "" for none."""
    return str(of.metadata.get("unit", ""))


def meaning_of(of: Field[Any]) -> str:
    """Return what a field means beyond its name."""
    return str(of.metadata.get("description", ""))


def units_of(data: type[Any]) -> dict[str, str]:
    """Unit of each field that states one."""
    return {f.name: unit_of(f) for f in fields(data) if unit_of(f)}


def fmi_unit(unit: str) -> str:
    """The unit as FMI writes it: `N s/m`, `N*s/m` and `N.s/m` are one, `m/s^2` is `m/s2`, none is `1`."""
    text = re.sub(r"[\s*·]+", ".", unit.strip()).replace("^", "")
    return "1" if text in ("", "-") else text


Value = float | int | bool | str


def word_of(choices: Iterable[str], value: object) -> str | None:
    """The choice that a text is, whatever its case; None where it is none."""
    return next((word for word in choices if isinstance(value, str) and word.lower() == value.lower()), None)


@dataclass(frozen=True)
class Parameter:
    """A parameter by its name in files."""

    name: str
    unit: str  # as FMI spells it, "1" where there is none
    kind: str  # Real, Integer, Boolean or String
    start: Value = ""  # what it is where it is not set; of the host its data class knows
    minimum: float | None = None
    maximum: float | None = None
    choices: tuple[str, ...] = ()  # words of a text, or of the codes of a number
    meaning: str = ""

    def read(self, value: object) -> Value:
        """The value in the parameter's type; a `ValueError` names key, value and cure."""
        bad = f"{self.name} = {value!r}"
        if self.kind == "Boolean":
            if not isinstance(value, bool):
                raise ValueError(f"{bad} must be true or false: write one of them")
            return value
        if self.kind == "String":
            word = word_of(self.choices, value) if self.choices else value
            if not isinstance(word, str):
                what = f"one of {', '.join(self.choices)}" if self.choices else "a text"
                raise ValueError(f"{bad} must be {what}: choose one")
            return word
        if self.choices:
            value = self._code(value)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= _MOST:
            raise ValueError(f"{bad} must be a finite number: give it in {self.unit_words}")
        if self.kind != "Real" and float(value) != round(value):
            raise ValueError(f"{bad} must be a whole number: round it")
        if (self.minimum is not None and value < self.minimum) or (self.maximum is not None and value > self.maximum):
            low, high = (-math.inf if self.minimum is None else self.minimum), self.maximum
            bound = f"at least {low:g}" if high is None else f"within {low:g} and {high:g}"
            raise ValueError(f"{bad} must be {bound}: give it in {self.unit_words}")
        return float(value) if self.kind == "Real" else round(value)

    def _code(self, value: object) -> object:
        """The code of a choice, given by code or by word."""
        code = self.choices.index(word) if (word := word_of(self.choices, value)) else value
        if isinstance(code, bool) or code not in range(len(self.choices)):
            known = ", ".join(f"{k} ({word})" for k, word in enumerate(self.choices))
            raise ValueError(f"{self.name} = {value!r} must be one of {known}: give code or word")
        return code

    @property
    def numeric(self) -> bool:
        """True of numbers, and of choices that have codes."""
        return self.kind in ("Real", "Integer")

    @property
    def unit_words(self) -> str:
        """Unit, in a sentence."""
        return "plain numbers" if self.unit == "1" else self.unit

    @property
    def about(self) -> str:
        """Meaning with its unit."""
        return f"{self.meaning or self.name}{'' if self.unit == '1' else f' [{self.unit}]'}"
