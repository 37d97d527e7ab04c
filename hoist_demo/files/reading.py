"""Reading of TOML files against pydantic models: all errors at once, each with place, value and cure.

text -> tables, with the dots of quoted keys resolved -> model of that kind of file, which is the typed object
"""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    create_model,
)
from pydantic.json_schema import GenerateJsonSchema

from hoist_demo.files.values import Facts, given
from hoist_demo.parameters.quantity import Parameter
from rope_model.texts import printable


class FileError(ValueError):
    """All that is wrong with a file, one line each."""

    def __init__(self, path: Path, problems: Iterable[str]) -> None:
        self.problems = tuple(dict.fromkeys(map(printable, problems)))
        super().__init__("\n".join(f"{printable(str(path))}: {problem}" for problem in self.problems))


class Table(BaseModel):
    """A table of a file, all keys of which are known."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True, defer_build=True)


class File(Table):
    """A whole file."""

    _path: Path = PrivateAttr(Path())

    def model_post_init(self, context: tuple[Path, ...] | None) -> None:
        """Keep the path."""
        self._path = context[-1] if context else Path()

    @property
    def path(self) -> Path:
        """Where it was read."""
        return self._path


T = TypeVar("T", bound=BaseModel)
#: a table that may be left out: it is then read as an empty one
EMPTY: Any = Field(default={}, validate_default=True)


@dataclass(frozen=True)
class Flat:
    """Annotation for pydantic: the key is a table of this model, and holds what `make` makes of it."""

    model: type[Table]
    make: Callable[[Any], Any]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> Any:
        """Return pydantic's schema."""
        return handler.generate_schema(Annotated[self.model, AfterValidator(self.make)])


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
        fields[f"key{number}"] = (kind, Field(default=None, alias=key))
    made: type[Table] = create_model("".join(map(str.title, name.split("."))), __base__=Table, **fields)
    return made


def contents(table: BaseModel, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield all that a table and those in it set, by dotted names."""
    for name in type(table).model_fields:
        if name in table.model_fields_set:
            content, key = getattr(table, name), f"{prefix}{type(table).model_fields[name].alias or name}"
            inner = isinstance(content, Table) and not isinstance(content, File)
            yield from contents(content, f"{key}.") if inner else [(key, content)]


def flat(name: str, fields: Mapping[str, Any], make: Callable[[Any], Any] | None = None) -> Flat:
    """Return the annotation of a table with these fields, which holds all that it sets, by dotted names."""
    model: type[Table] = create_model(name, __base__=Table, **fields)
    return Flat(model, make or (lambda table: dict(contents(table))))


def read(
    path: Path, model: type[T], opened: Sequence[Path] = (), over: Mapping[str, Mapping[str, object]] | None = None
) -> T:
    """Return the contents of a file; raise FileError with all problems.

    `opened` are the files that led to it; `over` are keys of tables that replace the file's.
    """
    if path.resolve() in (one.resolve() for one in opened):
        raise FileError(path, ["must not lead back to itself: break the circle"])
    try:
        tables = nested(_tables(path))
    except RecursionError as error:
        raise FileError(path, ["is nested too deeply: write [table]s, and values without more of them"]) from error
    except ValueError as error:
        raise error if isinstance(error, FileError) else FileError(path, [str(error)]) from error
    for key, table in (over or {}).items():
        below = tables.get(key, {})
        tables[key] = {**below, **table} if isinstance(below, dict) else below
    try:
        return model.model_validate(tables, context=(*opened, path))
    except ValidationError as error:
        problems = [line for one in error.errors() for line in _problems(_names(model), one)]
        raise FileError(path, problems) from error


def opened_by(info: ValidationInfo) -> tuple[Path, ...]:
    """Return the file that is read, the last, and those that led to it."""
    return info.context or (Path("file"),)


def beside(info: ValidationInfo, name: str) -> Path:
    """Return the path of a file that the one which is read names."""
    return opened_by(info)[-1].parent / name


def _tables(path: Path) -> dict[str, Any]:
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise FileError(path, [f"is not TOML: {error}: write it in UTF-8"]) from error
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", error)
        raise FileError(path, [f"cannot be read ({why}): give an existing file"]) from error
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        words = _missing_comma(text, error) or f"{error}: correct it there"
        raise FileError(path, [f"is not TOML: {words}"]) from error


def _missing_comma(text: str, error: tomllib.TOMLDecodeError) -> str:
    """Return the words on a comma with which the text can be read further; "" where that is not the trouble."""
    if not (place := _place(error)):
        return ""
    (line, column), lines = place, text.splitlines(keepends=True)
    at = sum(map(len, lines[: line - 1])) + column - 1
    try:
        tomllib.loads(text[:at] + "," + text[at:])
    except tomllib.TOMLDecodeError as further:
        if _place(further) <= (line, column + 1):
            return ""
    return f"a comma is missing at line {line}, column {column}: put it before what stands there"


def _place(error: tomllib.TOMLDecodeError) -> tuple[int, ...]:
    """Return line and column; nothing where the text ends too soon."""
    found = re.search(r"line (\d+), column (\d+)", str(error))
    return (int(found[1]), int(found[2])) if found else ()


def nested(table: Mapping[str, Any], place: str = "") -> dict[str, Any]:
    """Return the table with keys that quote their dots as tables, as TOML has them without quotation marks."""
    found: dict[str, Any] = {}
    for key, content in table.items():
        head, dot, rest = key.partition(".")
        if dot:
            content = {rest: content}
        if isinstance(content, dict):
            content = nested(content, f"{place}{head}.")
        elif isinstance(content, list):
            content = [nested(one, f"{place}{head} ") if isinstance(one, dict) else one for one in content]
        found[head] = _joined(found[head], content, f"{place}{head}") if head in found else content
    return found


def _joined(one: Any, other: Any, place: str) -> Any:
    if not (isinstance(one, dict) and isinstance(other, dict)):
        raise ValueError(f"{place} is given twice, with its dots in quotation marks and without: keep one of them")
    return one | {k: _joined(one[k], below, f"{place}.{k}") if k in one else below for k, below in other.items()}


def _problems(names: Sequence[str], error: Any) -> list[str]:
    """Return the lines on one error of pydantic's, in a file that has these keys."""
    # where a table may be of several kinds, its kind stands in the place, too, and is no key
    keys = {part for name in names for part in name.split(".")} | {*error["loc"][-1:]}
    loc = [part for part in error["loc"] if isinstance(part, int) or part in keys]
    kind, content, place = error["type"], error["input"], _place_of(loc)
    short = text if len(text := repr(content)) <= 60 else f"{text[:57]}..."
    if kind == "value_error":
        return [_said(place, line) for line in str(error["ctx"]["error"]).splitlines()]
    match kind:
        case "extra_forbidden":
            key = ".".join(part for part in loc if isinstance(part, str))
            words = f"= {short} is not a key: {cure_of(key, names)}"
        case "missing":
            words = "is missing: give it"
        case "union_tag_invalid":
            expected, key = error["ctx"]["expected_tags"], error["ctx"]["discriminator"].strip("'")
            return [f"{place}: {key} = {error['ctx']['tag']!r} must be one of {expected}: choose one"]
        case "union_tag_not_found":
            return [f"{place}: {error['ctx']['discriminator'].strip(chr(39))} is missing: give it"]
        case "model_type" | "dict_type" | "model_attributes_type":
            words = f"= {short} must be one table: write [{place}] above it"
        case "list_type" | "tuple_type":
            words = f"= {short} must be a list: write [[{place}]] above each table, or [a, b]"
        case "string_type":
            words = f"= {short} must be a text: put it in quotation marks"
        case _:
            words = f"= {short} must {error['msg'].partition(' should ')[2] or error['msg']}: correct it"
    return [f"{place} {words}"]


def _said(place: str, text: str) -> str:
    """Return the place with what is wrong there, which may begin with the key."""
    name = text.partition(" ")[0]
    table = place.removesuffix(name).removesuffix(name.removeprefix("rope.")).rstrip(" .")
    return f"{table}: {text}" if table else text


def _place_of(loc: Sequence[int | str]) -> str:
    """Return the dotted name of a place; members of lists are counted from 1: `rope 2 left.swivel.mode`."""
    parts = (f" {part + 1} " if isinstance(part, int) else f".{part or repr(part)}" for part in loc)
    return "".join(parts).replace(" .", " ").strip(" .")


#: keys of earlier versions, and what to write today
_OLD = {
    "case": 'write hoist = "NAME", or hoist = "FILE.toml"',
    "tune": 'write [sample] method = "tune", and minimise and subject_to in [study]',
    "inputs_at_step_end": "the host sets it: leave it out",
    "model.rung": "write model.fidelity",
    "mesh.leg_growth": "write mesh.grading_length",
    "hoist.shaft": "write hoist.drive_shaft",
}


def cure_of(key: str, known: Sequence[str]) -> str:
    """Return what may have been meant by a key that is none of those known."""
    if old := [words for name, words in _OLD.items() if f".{key}".endswith(f".{name}")]:
        return old[0]
    if key in known:
        return "it is of another kind of that table: leave it out"
    table, dot, last = key.rpartition(".")
    within = [name.removeprefix(table + dot) for name in known if name.rpartition(".")[0] == table]
    within = within or [*Facts.model_fields]  # of a value
    if near := [f"{table}{dot}{name}" for name in difflib.get_close_matches(last, within, cutoff=0.5)]:
        return f"did you mean {' or '.join(near)}?"
    lasts = {name: name.rpartition(".")[2] for name in known}
    alike = {last.upper(), *difflib.get_close_matches(last, set(lasts.values()), cutoff=0.75)}
    if near := [name for name, word in lasts.items() if {word, word.upper()} & alike][:3]:
        return f"did you mean {' or '.join(near)}?"
    return f"the keys are {', '.join(within)}"


def _models(hints: Iterable[Any]) -> Iterator[type[BaseModel]]:
    """Yield the models of tables within types."""
    for hint in hints:
        if isinstance(hint, Flat):
            yield hint.model
        elif isinstance(hint, type) and issubclass(hint, BaseModel):
            yield hint
        else:
            yield from _models(get_args(hint))


@cache
def _names(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the names of all keys of a table and of those in it, each once."""
    found: list[str] = []
    for name, field in model.model_fields.items():
        key = field.alias or name
        tables = (one for one in _models((field.annotation, *field.metadata)) if one is not Facts)
        found += [key, *(f"{key}.{inner}" for one in tables for inner in _names(one))]
    return tuple(dict.fromkeys(found))


class _WithoutDefaults(GenerateJsonSchema):
    """Schema of a file: its tables state what is left out, and TOML has no null."""

    def default_schema(self, schema: Any) -> dict[str, Any]:
        return self.generate_inner(schema["schema"])


def schema_of(model: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON Schema of a kind of file."""
    return model.model_json_schema(schema_generator=_WithoutDefaults)
