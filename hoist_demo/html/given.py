"""The data a run was given, as table rows: each field of a frozen dataclass with the unit its source line states.

The house writes a field's unit and meaning once, as the comment behind it: `speed: float = 8.0  # m/s, limit`.
"""

from __future__ import annotations

import inspect
import re
from dataclasses import fields, is_dataclass

from hoist_demo.html.page import Row, number

_FIELD = re.compile(r"^[ \t]+(\w+)[ \t]*:[^#\n]*#[ \t]*([^,;:\n]+)[,;:]?[ \t]*(.*)$", re.MULTILINE)
_NO_UNIT = "-"


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
            found.append((name, number(value), "" if unit == _NO_UNIT else unit))
    return found


def _notes(kind: type) -> dict[str, tuple[str, str]]:
    """Unit and meaning of each field, from the comments of the class; nothing where the source is not at hand."""
    try:
        source = inspect.getsource(kind)
    except (OSError, TypeError):
        return {}
    return {match[1]: (match[2].strip(), match[3].strip()) for match in _FIELD.finditer(source)}
