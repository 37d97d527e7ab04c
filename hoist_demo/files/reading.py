"""Reading of TOML files against pydantic models: all errors at once, each with place, value and cure."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model

from hoist_demo.files.values import VALUE_KEYS, Given, given
from hoist_demo.parameters.quantity import Parameter
from rope_model.texts import printable


class FileError(ValueError):
    """All that is wrong with a file, one line each."""

    def __init__(self, path: Path, problems: Iterable[str]) -> None:
        self.problems = tuple(dict.fromkeys(map(printable, problems)))
        super().__init__("\n".join(f"{printable(str(path))}: {problem}" for problem in self.problems))


class Table(BaseModel):
    """A table of a file, all keys of which are known."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


T = TypeVar("T", bound=BaseModel)


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file; raise FileError if it is unreadable."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise FileError(path, [f"cannot be read ({error.strerror}): give an existing file"]) from error
    except UnicodeDecodeError as error:
        raise FileError(path, [f"is not TOML: {error}: write it in UTF-8"]) from error
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise FileError(
            path, [f"is not TOML: {_missing_comma(text, error) or f'{error}: correct it there'}"]
        ) from error


def _missing_comma(text: str, error: tomllib.TOMLDecodeError) -> str:
    """Return the words on a comma with which the text can be read further; "" where that is not the trouble."""
    if (place := _place(error)) is None:
        return ""
    lines = text.splitlines(keepends=True)
    at = sum(map(len, lines[: place[0] - 1])) + place[1] - 1
    try:
        tomllib.loads(text[:at] + "," + text[at:])
    except tomllib.TOMLDecodeError as further:
        if (then := _place(further)) is None or then <= (place[0], place[1] + 1):
            return ""
    return f"a comma is missing at line {place[0]}, column {place[1]}: put it before what stands there"


def _place(error: tomllib.TOMLDecodeError) -> tuple[int, int] | None:
    found = re.search(r"line (\d+), column (\d+)", str(error))
    return (int(found[1]), int(found[2])) if found else None


def table_of(name: str, parameters: Iterable[Parameter], leaf: Callable[[Parameter], Any] = given) -> type[Table]:
    """Return the model of a table with these parameters, whose names may have more dots; `leaf` gives their types."""
    inside: dict[str, list[Parameter]] = {}
    for parameter in parameters:
        inside.setdefault(parameter.name.removeprefix(f"{name}.").partition(".")[0], []).append(parameter)
    fields: dict[str, Any] = {}
    for number, (key, found) in enumerate(inside.items()):
        plain = found[0].name == f"{name}.{key}"
        kind = leaf(found[0]) if plain else table_of(f"{name}.{key}", found, leaf)
        # brackets in a key are no identifier
        fields[f"key{number}"] = (kind | None, Field(default=None, alias=key))
    made: type[Table] = create_model("".join(map(str.title, name.split("."))), __base__=Table, **fields)
    return made


def optional(kind: Any) -> Any:
    """Return the field of a model that may be left out, for `create_model`."""
    return kind | None, None


def contents(table: BaseModel | None, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield all that a table and those in it set, by dotted names."""
    for name, field in () if table is None else type(table).model_fields.items():
        key, content = f"{prefix}{field.alias or name}", getattr(table, name)
        if isinstance(content, BaseModel):
            yield from contents(content, f"{key}.")
        elif content is not None:
            yield key, content


def givens(table: BaseModel | None, prefix: str = "") -> Iterator[tuple[str, Given]]:
    """Yield the values that a table of parameters sets, by dotted names."""
    return ((key, content) for key, content in contents(table, prefix) if isinstance(content, Given))


def validated(path: Path, model: type[T], raw: Mapping[str, Any], cure: Callable[[str], str]) -> T:
    """Return the contents of a file by its model; raise FileError with all problems. `cure` is of unknown keys."""
    try:
        return model.model_validate(nested(raw))
    except ValidationError as error:
        raise FileError(path, [_problem(one, cure) for one in error.errors()]) from error


def _problem(error: Any, cure: Callable[[str], str]) -> str:
    """Return the line on one error of pydantic's."""
    place, kind, content = _place_of(error["loc"]), error["type"], error["input"]
    if kind == "value_error":
        text = str(error["ctx"]["error"])
        name = text.partition(" ")[0]
        table = place.removesuffix(name).removesuffix(name.removeprefix("rope.")).rstrip(" .")
        return f"{table}: {text}" if table else text
    if kind == "extra_forbidden":
        return f"{place} = {_short(content)} is not a key: {cure(place)}"
    if kind == "missing":
        return f"{place} is missing: give it"
    if kind == "union_tag_invalid":
        key = error["ctx"]["discriminator"].strip("'")
        return f"{place}: {key} = {error['ctx']['tag']!r} must be one of {error['ctx']['expected_tags']}: choose one"
    if kind == "union_tag_not_found":
        return f"{place}: {error['ctx']['discriminator'].strip(chr(39))} is missing: give it"
    if kind in ("model_type", "dict_type", "model_attributes_type"):
        return f"{place} = {_short(content)} must be one table: write [{place}] above it"
    if kind == "list_type":
        return f"{place} = {_short(content)} must be a list: write [[{place}]] above each table, or [a, b]"
    text = error["msg"].removeprefix("Input should be ")
    return f"{place} = {_short(content)} must be {text}: correct it"


def _place_of(loc: Sequence[int | str]) -> str:
    """Return the dotted name of a place; members of lists are counted from 1: `rope 2 left.swivel.mode`."""
    text = ""
    for part in loc:
        if isinstance(part, int):
            text += f" {part + 1} "
        else:
            text += part if not text or text.endswith(" ") else f".{part}"
    return text.strip()


def _short(content: Any) -> str:
    text = repr(content)
    return text if len(text) <= 60 else f"{text[:57]}..."


def nested(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table with keys that quote their dots as tables, as TOML has them without quotation marks."""
    found: dict[str, Any] = {}
    for key, content in table.items():
        *outer, last = key.split(".")
        place = found
        for name in outer:
            place = place.setdefault(name, {})
        if isinstance(content, dict):
            place.setdefault(last, {}).update(nested(content))
        elif isinstance(content, list):
            place[last] = [nested(one) if isinstance(one, dict) else one for one in content]
        else:
            place[last] = content
    return found


def flat(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted keys with their contents, whether the file quotes them or not; a value's own table is left whole."""
    for name, content in table.items():
        key = f"{prefix}{name}"
        if isinstance(content, dict) and not content.keys() & set(VALUE_KEYS):
            yield from flat(content, f"{key}.")
        else:
            yield key, content
