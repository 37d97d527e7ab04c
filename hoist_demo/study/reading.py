"""Parts of files like a study's, about ropes in this process: their tables, their head, and single values."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from hoist_demo.cases.table import find_case
from hoist_demo.study.catalogue import Catalogue, Value
from hoist_demo.study.definition import flat, read_toml, strip_unit, with_file
from rope_model import Level


def read_tables(path: Path, of: str, kinds: Mapping[str, type], problems: list[str]) -> dict[str, Any]:
    """The tables of a file, by name: `dict` for one, [name], `list` for several, [[name]].

    What is wrong is added to the problems, and left out.
    """
    found: dict[str, Any] = {}
    for name, content in read_toml(path).items():
        kind = kinds.get(name)
        tables = content if isinstance(content, list) else [content]
        if kind is None:
            problems.append(f"[{name}] is not a table of {of}: the tables are {', '.join(kinds)}")
        elif not isinstance(content, kind) or not all(isinstance(table, dict) for table in tables):
            problems.append(f"{name} = {content!r} must be {_KINDS[kind].format(name)}")
        else:
            found[name] = content
    return found


_KINDS: dict[type, str] = {dict: "one table: write [{0}] above it", list: "tables: write [[{0}]] above each"}


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
