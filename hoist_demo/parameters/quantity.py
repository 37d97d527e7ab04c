"""Fields of data classes that state their unit and meaning: studies and reports read them there.

The metadata have the same names as those of rope_model's parameters.
"""

from __future__ import annotations

from dataclasses import Field, field, fields
from typing import Any, TypeVar

T = TypeVar("T")


def quantity(default: T, unit: str, meaning: str = "") -> T:
    """A field with its unit, "-" of a pure number, and with what it means beyond its name."""
    return field(default=default, metadata={"unit": unit, "description": meaning})


def unit_of(of: Field[Any]) -> str:
    """The unit that a field states, "" for none."""
    return str(of.metadata.get("unit", ""))


def meaning_of(of: Field[Any]) -> str:
    """Return the unit and description of a field."""
    return str(of.metadata.get("description", ""))


def units_of(data: type[Any]) -> dict[str, str]:
    """Unit of each field that states one."""
    return {f.name: unit_of(f) for f in fields(data) if unit_of(f)}
