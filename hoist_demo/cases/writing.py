"""Writing of hoists' files: every value with its unit, its meaning and where it comes from."""

import re
from collections.abc import Iterable

from hoist_demo.cases.hoist_file import SUSPENSION_PARAMETERS
from hoist_demo.files.registry import host_parameters, rope_parameters
from hoist_demo.files.values import GIVEN, ParameterValue, ParameterValues
from hoist_demo.parameters.quantity import FileParameter
from rope_model.texts import printable, toml_string

_PARAMETERS = {**SUSPENSION_PARAMETERS, **host_parameters(), **rope_parameters()}
_ORDER = list(
    dict.fromkeys(name.partition(".")[0] for name in (*host_parameters(), *rope_parameters()))
)


def hoist_text(
    name: str, values: ParameterValues, ropes: Iterable[ParameterValues], comment: str = ""
) -> str:
    """Return a hoist's file with these values by name, and a [[rope]] with those of each rope."""
    parts = [
        *(f"# {printable(text)}" for text in comment.splitlines()),
        f"name = {toml_string(name)}",
        "",
    ]
    tables: dict[str, list[str]] = {}
    for key in sorted(values, key=_place):
        table, _, last = key.rpartition(".")
        tables.setdefault(table, []).append(_line(key, last, values[key]))
    for table, lines in tables.items():
        if table:
            parts.append(f"[{table}]")
        parts += [*lines, ""]
    for rope in ropes:
        parts += [
            "[[rope]]",
            *(_line(key, key.removeprefix("rope."), entry) for key, entry in rope.items()),
            "",
        ]
    return "\n".join(parts).rstrip() + "\n"


def _place(name: str) -> int:
    """Return the place of a key in a file: keys without a table first."""
    table, dot, _ = name.partition(".")
    if dot:
        return _ORDER.index(table)
    return 0


def _line(name: str, key: str, entry: ParameterValue) -> str:
    within = name.replace("rope.swivels.", "left.swivel.").removeprefix("rope.")
    parameter = (
        _PARAMETERS.get(name) or _PARAMETERS.get(within) or FileParameter(name, "1", "String")
    )
    meaning = parameter.meaning.replace("[assumed]", "").replace("{side} ", "").strip(" ;,")
    notes = "; ".join(filter(None, (meaning, entry.source)))
    quoted = re.sub(r"\w+\[\d+\]", r'"\g<0>"', key)  # TOML has brackets in quotes only
    line = f"{quoted} = {_value(parameter, entry)}"
    return f"{line}  # {printable(notes)}" if notes else line


def _value(parameter: FileParameter, entry: ParameterValue) -> str:
    value = entry.value
    if parameter.choices and type(value) is int:
        value = parameter.choices[value]
    if isinstance(value, str | bool):
        if isinstance(value, str):
            text = toml_string(value)
        else:
            text = str(value).lower()
        if parameter.name in _PARAMETERS and entry.status != GIVEN:
            return f"{{ value = {text}, status = {toml_string(entry.status)} }}"
        return text
    if parameter.kind == "String":  # a count, and no datum
        return repr(value)
    if parameter.unit == "1":
        unit = ""
    else:
        unit = f", unit = {toml_string(parameter.unit)}"
    return f"{{ value = {value!r}{unit}, status = {toml_string(entry.status)} }}"
