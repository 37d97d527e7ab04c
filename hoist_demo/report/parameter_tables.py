"""The data of a run as table rows: each parameter's name, value, unit, meaning and status."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.report.formatting import Row, number, unit_text

_NO_UNIT = "-"
TitledRows = tuple[str, list[Row]]  #: Title and rows.


def parameter_tables(data: Mapping[str, object], statuses: Mapping[str, str]) -> list[TitledRows]:
    """Return a table for each dataclass, under the section's title."""
    return [
        (title, parameter_rows(part, f"{title.lower()}.", statuses)) for title, part in data.items()
    ]


def rope_tables(
    rope: RopeData, fidelities: Sequence[str], statuses: Mapping[str, str]
) -> list[TitledRows]:
    """Return tables of the rope's source, of the fidelity computed, and of all its parameters."""
    ran = ", then ".join(fidelities) or "not known"
    head: list[Row] = [(name, text, "") for name, text in rope.model.items()]
    head += [
        ("level of accuracy", rope.level or "of none by name; see solver, mesh and model", ""),
        ("fidelity that ran", ran, ""),
    ]
    if rope.fidelity_reason:
        head.append(("because", rope.fidelity_reason, ""))
    parameters: list[Row] = []
    for name in rope.parameters:
        unit = unit_text(rope.units.get(name, ""))
        status = statuses.get(f"{rope.prefix}{name}", "")
        parameters.append((name, word(rope.display(name)), unit, status))
    return [
        (rope.with_name("Balance rope"), head),
        (rope.with_name("Parameters of the balance rope"), parameters),
    ]


def word(value: object) -> str:
    """Format a value for people."""
    if isinstance(value, bool):
        if value:
            return "yes"
        return "no"
    if isinstance(value, int | float):
        return number(value)
    return str(value)


def parameter_rows(data: Any, section: str, statuses: Mapping[str, str]) -> list[Row]:
    """Return one row per number, flag or word of a dataclass and of the dataclasses within it."""
    listed: list[Row] = []
    for field in fields(data):
        value = getattr(data, field.name)
        unit = field.metadata.get("unit", "")
        meaning = field.metadata.get("description", "")
        key = f"{section}{field.name}"
        label = f"{key}, {meaning}" if meaning else key
        if is_dataclass(value):
            listed += parameter_rows(value, f"{key}.", statuses)
        elif value is None or isinstance(value, str | int | float):
            shown_unit = ""
            if isinstance(value, int | float) and unit != _NO_UNIT:
                shown_unit = unit_text(unit)
            text = word("none" if value in (None, "") else value)
            listed.append((label, text, shown_unit, statuses.get(key, "")))
    return listed
