"""Numbers and the claims about them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from evidence.rendering import number


@dataclass(frozen=True)
class Measurement:
    """One number, what it is, and the claim about it: ``value`` is ``relation`` ``bound``."""

    what: str
    value: float
    unit: str  # '1' without one
    relation: Literal["<", ">"]
    bound: float

    @property
    def holds(self) -> bool:
        """Whether the claim is true; never for NaN."""
        return self.value < self.bound if self.relation == "<" else self.value > self.bound


def below(what: str, value: float, bound: float, unit: str = "1") -> Measurement:
    """Return the claim that ``value`` is below ``bound``."""
    return Measurement(what, float(value), unit, "<", bound)


def above(what: str, value: float, bound: float, unit: str = "1") -> Measurement:
    """Return the claim that ``value`` is above ``bound``."""
    return Measurement(what, float(value), unit, ">", bound)


def text(m: Measurement) -> str:
    """Return the value against its bound."""
    unit = "" if m.unit == "1" else f" {m.unit}"
    return f"{number(m.value, '.4g')}{unit} {m.relation} {number(m.bound, 'g')}{unit}"
