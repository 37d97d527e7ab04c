"""Files like a study's (TOML): their tables, their head, and single values with unit and status."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, get_args

from hoist_demo.cases.table import find_case
from hoist_demo.files.catalogue import Catalogue
from hoist_demo.files.reading import flat, read_toml
from hoist_demo.files.rope_file import following_statuses
from hoist_demo.files.values import GIVEN, LONGEST_TEXT
from hoist_demo.parameters.quantity import Parameter, Value, fmi_unit
from rope_model import DatumStatus, Level
from rope_model.texts import printable

LEVELS = get_args(Level)  #: Levels of accuracy of a rope in this process.

_SPECIFICATION = {"value", "values", "low", "high", "unit", "scale", "status"}


class Problems(list[str]):
    """What is wrong with a file, each once."""

    @contextmanager
    def collect(self, where: str = "") -> Iterator[None]:
        """Add the ValueError of a block, which it ends, with its place in the file."""
        try:
            yield
        except ValueError as error:
            problem = f"{where}: {error}" if where else str(error)
            if problem not in self:
                self.append(problem)


def read_tables(path: Path, of: str, kinds: Mapping[str, type], problems: Problems) -> dict[str, Any]:
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


def read_values(catalogue: Catalogue, where: str, table: Mapping[str, Any], problems: Problems) -> dict[str, Value]:
    """The single values of a table, each checked by itself; what is wrong is added to the problems."""
    found: dict[str, Value] = {}
    given: Mapping[str, Any] = {}
    with problems.collect(where):
        given = with_file(table)
    for key, content in flat(given):
        with problems.collect(where):
            parameter = catalogue[key]
            found[key] = parameter.read(strip_unit(parameter, content))
    return found


def read_statuses(table: Mapping[str, Any]) -> dict[str, str]:
    """Return the sources of a table's values: their own, those of the file that `from` names, else given."""
    found = file_statuses(Path(str(table["from"]))) if "from" in table else {}
    for key, content in flat({key: content for key, content in table.items() if key != "from"}):
        found[key] = content.get("status", GIVEN) if isinstance(content, dict) else GIVEN
    return found


def file_statuses(path: Path) -> dict[str, str]:
    """Return the statuses of the values in a parameter file's [fixed]: calibrated, measured, ..., else given."""
    raw = read_toml(path)
    return read_statuses(raw.get("fixed", {})) | following_statuses(
        {
            key: content.get("status", "measured") if isinstance(content, dict) else "measured"
            for key, content in raw.get("known", {}).items()
        }
    )


def read_head(
    path: Path, name: str, table: Mapping[str, Any], own: Mapping[str, Any], problems: Problems
) -> dict[str, Any]:
    """Title, case and level of a file about ropes in this process, and keys of its own with their defaults."""
    defaults = {"title": printable(path.stem), "hoist": "rope-120", "level": "standard", **own}
    for key in table.keys() - defaults.keys():
        problems.append(f"[{name}] {key} = {table[key]!r} is not a key: it has {', '.join(defaults)}")
    head = {key: table.get(key, default) for key, default in defaults.items()}
    head["title"] = read_text(f"[{name}] title", head["title"], problems)
    if head["level"] not in LEVELS:
        problems.append(f"[{name}] level = {head['level']!r} must be one of {', '.join(LEVELS)}: choose one")
    with problems.collect(f"[{name}]"):
        find_case(str(head["hoist"]))
    return head


def read_text(where: str, content: Any, problems: Problems) -> str:
    """A title, a name or a source: a line of at most LONGEST_TEXT characters.

    What is wrong is added to the problems.
    """
    if isinstance(content, dict | list):
        problems.append(f"{where} = {content!r} must be a text: put it in quotation marks")
    text = str(content)
    if len(text) > LONGEST_TEXT:
        problems.append(
            f"{where} = {text[:20]!r}... has {len(text)} characters and must have at most {LONGEST_TEXT}: shorten it"
        )
    if printable(text) != text:
        problems.append(
            f"{where} = {text[:LONGEST_TEXT]!r} must be a line of printable characters: leave out the others"
        )
    return text


def with_file(table: Mapping[str, Any]) -> Mapping[str, Any]:
    """The values of the file that the key ``from`` names, and before them the table's own."""
    if "from" not in table:
        return table
    rest = {key: content for key, content in table.items() if key != "from"}
    fixed = read_toml(Path(str(table["from"]))).get("fixed", {})
    if not isinstance(fixed, dict):
        raise ValueError(f"{table['from']}: fixed = {fixed!r} must be one table: write [fixed] above it")
    return dict(flat(fixed)) | dict(flat(rest))


def strip_unit(parameter: Parameter, content: Any) -> Any:
    """The content without its unit, which is checked: a value, a list, or a range's table."""
    if not isinstance(content, dict):
        return content
    for name in content.keys() - _SPECIFICATION:
        raise ValueError(f"{parameter.name}.{name} is not known: the keys of a value are {', '.join(_SPECIFICATION)}")
    unit = content.get("unit")
    if unit is not None and fmi_unit(str(unit)) != parameter.unit:
        raise ValueError(
            f"{parameter.name} has unit = {unit!r}, which must be {parameter.unit!r}: convert the value to it"
        )
    if (status := content.get("status")) is not None and status not in get_args(DatumStatus):
        known = ", ".join(get_args(DatumStatus))
        raise ValueError(f"{parameter.name} has status = {status!r}, which must be one of {known}: choose one")
    rest = {name: value for name, value in content.items() if name not in ("unit", "status")}
    if len(rest) == 1 and next(iter(rest)) in ("value", "values"):
        return next(iter(rest.values()))
    return rest
