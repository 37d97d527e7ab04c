"""Writing of hoists' files: every value with its unit, its meaning and where it comes from."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from hoist_demo.files.catalogue import host_parameters, rope_parameters
from hoist_demo.files.hoist_file import PLACE_PARAMETERS
from hoist_demo.files.values import GIVEN
from hoist_demo.parameters.quantity import Parameter, Value
from rope_model.texts import printable, toml_string


class Line(NamedTuple):
    """A value of a file, by its name in a study."""

    name: str
    value: Value
    status: str = GIVEN
    source: str = ""


def hoist_text(name: str, lines: Iterable[Line], ropes: Sequence[Iterable[Line]], about: str = "") -> str:
    """Return a hoist's file with these values, and a [[rope]] with those of each rope."""
    parts = [f"# {printable(text)}" for text in about.splitlines()] + [f"name = {toml_string(name)}", ""]
    tables: dict[str, list[Line]] = {}
    for line in lines:
        tables.setdefault(line.name.rpartition(".")[0], []).append(line)
    for line in tables.pop("", []):
        parts += [f"{line.name} = {_value(line)}", ""]
    for table, members in sorted(tables.items(), key=lambda item: _ORDER.index(item[0].partition(".")[0])):
        parts += [f"[{table}]", *(_line(line, line.name.rpartition(".")[2]) for line in members), ""]
    for rope in ropes:
        parts += ["[[rope]]", *(_line(line, line.name.removeprefix("rope.")) for line in rope), ""]
    return "\n".join(parts).rstrip() + "\n"


_ORDER = list(dict.fromkeys(name.partition(".")[0] for name in (*host_parameters(), *rope_parameters())))


def _facts(line: Line) -> Parameter:
    name = line.name.replace("rope.swivels.", "left.swivel.").removeprefix("rope.")
    known = {**PLACE_PARAMETERS, **host_parameters(), **rope_parameters()}
    return known.get(line.name) or known.get(name) or Parameter(line.name, "1", "String")


def _line(line: Line, key: str) -> str:
    meaning = _facts(line).meaning.replace("[assumed]", "").replace("{side} ", "").strip(" ;,")
    notes = ": ".join(filter(None, (meaning, line.source)))
    return f"{key} = {_value(line)}{f'  # {printable(notes)}' if notes else ''}"


def _value(line: Line) -> str:
    facts, value = _facts(line), line.value
    if facts.choices and isinstance(value, int) and not isinstance(value, bool):
        value = facts.choices[value]
    plain = (
        toml_string(value) if isinstance(value, str) else str(value).lower() if isinstance(value, bool) else repr(value)
    )
    if isinstance(value, str | bool):
        return plain
    if line.name == "rope.number":  # a count, and no datum
        return repr(value)
    unit = "" if facts.unit == "1" else f", unit = {toml_string(facts.unit)}"
    return f"{{ value = {value!r}{unit}, status = {toml_string(line.status)} }}"
