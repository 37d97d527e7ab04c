"""Parts of files like a study's, about ropes in this process: their head, and tables of single values."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from hoist_demo.cases.table import find_case
from hoist_demo.study.catalogue import Catalogue, Value
from hoist_demo.study.definition import flat, strip_unit, with_file
from rope_model import Level


def read_values(catalogue: Catalogue, where: str, table: Mapping[str, Any], problems: list[str]) -> dict[str, Value]:
    """The single values of a table, each checked by itself; what is wrong is added to the problems."""
    found: dict[str, Value] = {}
    try:
        table = with_file(table)
    except ValueError as error:
        problems.append(f"{where}: {error}")
        return found
    for key, content in flat(table):
        try:
            parameter = catalogue[key]
            found[key] = parameter.read(strip_unit(parameter, content))
        except ValueError as error:
            problems.append(f"{where}: {error}")
    return found


def read_head(
    path: Path, name: str, table: Mapping[str, Any], own: Mapping[str, Any], problems: list[str]
) -> dict[str, Any]:
    """Title, case and level of a file about ropes in this process, and keys of its own with their defaults."""
    defaults = {"title": path.stem, "case": "rope-120", "level": "standard", **own}
    for key in table.keys() - defaults.keys():
        problems.append(f"[{name}] {key} = {table[key]!r} is not a key: it has {', '.join(defaults)}")
    head = {key: table.get(key, default) for key, default in defaults.items()}
    if head["level"] not in get_args(Level):
        problems.append(f"[{name}] level = {head['level']!r} must be one of {', '.join(get_args(Level))}: choose one")
    try:
        find_case(str(head["case"]))
    except ValueError as error:
        problems.append(f"[{name}] {error}")
    return head
