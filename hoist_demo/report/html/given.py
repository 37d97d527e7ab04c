"""The data a run was given, as table rows: each field of a frozen dataclass with the unit its source line states.

The house writes a field's unit and meaning once, as the comment behind it: `speed: float = 8.0  # m/s, limit`.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.report.html.page import Row, number, unit_text

_FIELD = re.compile(r"^[ \t]+(\w+)[ \t]*:[^#\n]*#[ \t]*([^,;:\n]+)[,;:]?[ \t]*(.*)$", re.MULTILINE)
_NO_UNIT = "-"

Table = tuple[str, list[Row]]
"""Title and rows."""


def tables(data: Mapping[str, object]) -> list[Table]:
    """A table for each dataclass, by its title."""
    return [(title, rows(part)) for title, part in data.items()]


def rope_tables(rope: RopeData, level: str, rungs: Sequence[str]) -> list[Table]:
    """Where the balance rope comes from, how much of it was computed, and all its parameters."""
    ran = ", then ".join(rungs) or "not known"
    head: list[Row] = [(name, text, "") for name, text in rope.model.items()]
    head += [
        ("level of accuracy", level or "of none by name; see solver, mesh and model", ""),
        ("rung that ran", ran, ""),
    ]
    if rope.rung_reason:
        head.append(("because", rope.rung_reason, ""))
    parameters = [(name, _word(rope.shown(name)), unit_text(rope.units.get(name, ""))) for name in rope.parameters]
    return [("Balance rope", head), ("Parameters of the balance rope", parameters)]


def _word(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return number(value) if isinstance(value, int | float) else str(value)


def rows(data: object) -> list[Row]:
    """One row per number, flag or word of a dataclass, those of dataclasses within it included."""
    if not is_dataclass(data) or isinstance(data, type):
        raise TypeError(f"data = {data!r} must be a dataclass instance: give the parameters themselves")
    notes = _notes(type(data))
    found: list[Row] = []
    for field in fields(data):
        value = getattr(data, field.name)
        unit, meaning = notes.get(field.name, ("", ""))
        name = field.name.replace("_", " ") + (f", {meaning}" if meaning else "")
        if is_dataclass(value):
            found += [(f"{field.name.replace('_', ' ')}: {inner}", text, u) for inner, text, u in rows(value)]
        elif isinstance(value, bool):
            found.append((name, "yes" if value else "no", ""))
        elif isinstance(value, str) or value is None:
            found.append((name, value or "none", ""))
        elif isinstance(value, int | float):
            found.append((name, number(value), "" if unit == _NO_UNIT else unit_text(unit)))
    return found


def _notes(kind: type) -> dict[str, tuple[str, str]]:
    """Unit and meaning of each field, from the comments of the class; nothing where the source is not at hand."""
    try:
        source = inspect.getsource(kind)
    except (OSError, TypeError):
        return {}
    return {match[1]: (match[2].strip(), match[3].strip()) for match in _FIELD.finditer(source)}
