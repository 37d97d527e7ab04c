"""Reading of TOML files by pydantic models: all errors at once, with place, value and cure.

text -> tables -> model of that kind of file, which is the typed object
"""

import difflib
import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args

import pydantic

from hoist_demo.files.values import ValueTable, value_type
from hoist_demo.parameters.quantity import Parameter
from rope_model.texts import printable


class FileError(ValueError):
    """Problems of a file, one line each."""

    def __init__(self, path: Path, problems: Iterable[str]) -> None:
        self.problems = tuple(dict.fromkeys(map(printable, problems)))
        super().__init__(
            "\n".join(f"{printable(str(path))}: {problem}" for problem in self.problems)
        )


class Table(pydantic.BaseModel):
    """TOML table whose keys are all known."""

    model_config = pydantic.ConfigDict(
        extra="forbid", frozen=True, arbitrary_types_allowed=True, defer_build=True
    )


class File(Table):
    """Whole TOML file, with the path from which it was read."""

    _path: Path = pydantic.PrivateAttr(Path())

    def model_post_init(self, context: tuple[Path, ...] | None) -> None:
        """Store the path of the file that is read."""
        self._path = context[-1] if context else Path()

    @property
    def path(self) -> Path:
        """Path from which the file was read."""
        return self._path


T = TypeVar("T", bound=pydantic.BaseModel)
#: a table that may be left out: it is then read as an empty one
EMPTY: Any = pydantic.Field(default={}, validate_default=True)


@dataclass(frozen=True)
class Flat:
    """Annotation for pydantic: the key is a table of this model, and its value is `make` of it."""

    model: type[Table]
    make: Callable[[Any], Any]

    def __get_pydantic_core_schema__(
        self, source: Any, handler: pydantic.GetCoreSchemaHandler
    ) -> Any:
        """Return pydantic's schema."""
        return handler.generate_schema(Annotated[self.model, pydantic.AfterValidator(self.make)])


def table_of(
    name: str, parameters: Iterable[Parameter], leaf: Callable[[Parameter], Any] = value_type
) -> type[Table]:
    """Return the model of a table with these parameters, whose names may have more dots.

    `leaf` gives their types.
    """
    inside: dict[str, list[Parameter]] = {}
    for parameter in parameters:
        inside.setdefault(parameter.name.removeprefix(f"{name}.").partition(".")[0], []).append(
            parameter
        )
    fields: dict[str, Any] = {}
    for number, (key, members) in enumerate(inside.items()):
        plain = members[0].name == f"{name}.{key}"
        kind = leaf(members[0]) if plain else table_of(f"{name}.{key}", members, leaf)
        # brackets in a key are no identifier
        fields[f"key{number}"] = (kind, pydantic.Field(default=None, alias=key))
    made: type[Table] = pydantic.create_model(
        "".join(map(str.title, name.split("."))), __base__=Table, **fields
    )
    return made


def contents(table: pydantic.BaseModel, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield all that a table and those in it set, by dotted names."""
    for name in type(table).model_fields:
        if name in table.model_fields_set:
            content, key = (
                getattr(table, name),
                f"{prefix}{type(table).model_fields[name].alias or name}",
            )
            inner = isinstance(content, Table) and not isinstance(content, File)
            yield from contents(content, f"{key}.") if inner else [(key, content)]


def flat(name: str, fields: Mapping[str, Any], make: Callable[[Any], Any] | None = None) -> Flat:
    """Return the annotation of a table with these fields: its values by dotted names."""
    model: type[Table] = pydantic.create_model(name, __base__=Table, **fields)
    return Flat(model, make or (lambda table: dict(contents(table))))


def read(
    path: Path,
    model: type[T],
    opened: Sequence[Path] = (),
    over: Mapping[str, Mapping[str, object]] | None = None,
) -> T:
    """Return a file's contents or raise FileError.

    Files `opened` led to it, keys of `over` replace the file's.
    """
    if path.resolve() in (one.resolve() for one in opened):
        raise FileError(path, ["must not lead back to itself: break the circle"])
    try:
        tables = _tables(path)
    except RecursionError as error:
        raise FileError(
            path, ["is nested too deeply: write [table]s, and values without more of them"]
        ) from error
    for key, table in (over or {}).items():
        if isinstance(below := tables.setdefault(key, {}), dict):
            below |= table
    try:
        return model.model_validate(tables, context=(*opened, path))
    except pydantic.ValidationError as error:
        raise FileError(
            path, [line for one in error.errors() for line in _problems(_keys(model), one)]
        ) from error


@contextmanager
def errors_of_file(path: Path) -> Iterator[None]:
    """Raise refusals of the block as FileError of this file, unless they are FileErrors already."""
    try:
        yield
    except FileError:
        raise
    except ValueError as error:
        raise FileError(path, str(error).splitlines()) from error


def opened_by(info: pydantic.ValidationInfo) -> tuple[Path, ...]:
    """Return the file that is read, the last, and those that led to it."""
    return info.context or (Path("file"),)


def beside(info: pydantic.ValidationInfo, name: str) -> Path:
    """Return the path of a file that the one which is read names."""
    return opened_by(info)[-1].parent / name


def _tables(path: Path) -> dict[str, Any]:
    try:
        text = path.read_text(encoding="utf-8-sig")  # editors may begin a file with a mark
    except UnicodeDecodeError as error:
        raise FileError(path, [f"is not TOML: {error}: write it in UTF-8"]) from error
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", error)
        raise FileError(path, [f"cannot be read ({why}): give an existing file"]) from error
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        problem = _missing_comma(text, error) or f"{error}: correct it there"
        raise FileError(path, [f"is not TOML: {problem}"]) from error


def _missing_comma(text: str, error: tomllib.TOMLDecodeError) -> str:
    """Return the words on a comma with which the text can be read further.

    "" where that is not the trouble.
    """
    if (position := _position(error)) == _END:
        return ""
    line, column = position
    at = sum(map(len, text.splitlines(keepends=True)[: line - 1])) + column - 1
    try:
        tomllib.loads(text[:at] + "," + text[at:])
    except tomllib.TOMLDecodeError as further:
        if _position(further) <= (line, column + 1):
            return ""
    return f"a comma is missing at line {line}, column {column}: put it before what stands there"


def _position(error: tomllib.TOMLDecodeError) -> tuple[int, int]:
    """Return line and column of a TOML error, or _END."""
    match = re.search(r"line (\d+), column (\d+)", str(error))
    return (int(match[1]), int(match[2])) if match else _END


_END = (sys.maxsize, 0)  # the text ends too soon
_ONE, _SEVERAL = (
    "one table: write [{key_path}] above it",
    "a list: write [[{key_path}]] above each table, or [a, b]",
)
_MUST = {
    **dict.fromkeys(("model_type", "dict_type", "model_attributes_type"), _ONE),
    **dict.fromkeys(("list_type", "tuple_type"), _SEVERAL),
    "string_type": "a text: put it in quotation marks",
}
_MUST = {kind: f"{{key_path}} = {{short}} must be {words}" for kind, words in _MUST.items()}
_TEXTS = _MUST | {
    "extra_forbidden": "{key_path} = {short} is not a key: {cure}",
    "missing": "{key_path} is missing: give it",
    "union_tag_not_found": "{key_path}: {key} is missing: give it",
    "union_tag_invalid": "{key_path}: {key} = {tag!r} must be one of {expected_tags}: choose one",
}


def _problems(names: Sequence[str], error: Any) -> list[str]:
    """Return the lines on one error of pydantic's, in a file that has these keys."""
    # the path of a table of several kinds names its kind, too, which is no key
    keys = {part for name in names for part in name.split(".")} | {*error["loc"][-1:]}
    loc = [part for part in error["loc"] if isinstance(part, int) or part in keys]
    context, key_path, short = error.get("ctx", {}), _key_path(loc), repr(error["input"])
    if error["type"] == "value_error":
        return [_located(key_path, line) for line in str(context["error"]).splitlines()]
    placeholders = {
        "key_path": key_path,
        "short": short if len(short) <= 60 else f"{short[:57]}...",
    }
    cure = cure_of(".".join(part for part in loc if isinstance(part, str)), names)
    if "." in str(loc[-1]):
        cure = "leave out the quotation marks"
    requirement = error["msg"].partition(" should ")[2] or error["msg"]
    key = context.get("discriminator", "").strip("'")
    text = _TEXTS.get(error["type"], "{key_path} = {short} must {requirement}: correct it")
    return [text.format(**context | placeholders, cure=cure, requirement=requirement, key=key)]


def _located(key_path: str, text: str) -> str:
    """Return a problem behind its key path, unless it begins with the key itself."""
    name = text.partition(" ")[0]
    table = key_path.removesuffix(name).removesuffix(name.removeprefix("rope.")).rstrip(" .")
    return f"{table}: {text}" if table else text


def _key_path(loc: Sequence[int | str]) -> str:
    """Return the dotted path of a key.

    Members of lists are counted from 1: `rope 2 left.swivel.mode`.
    """
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


def cure_of(key: str, keys: Sequence[str]) -> str:
    """Return what may have been meant by a key that is none of those known."""
    if old := [words for name, words in _OLD.items() if f".{key}".endswith(f".{name}")]:
        return old[0]
    if key in keys:
        return "it is of another kind of that table: leave it out"
    table, dot, last = key.rpartition(".")
    within = [name.removeprefix(table + dot) for name in keys if name.rpartition(".")[0] == table]
    within = within or [*ValueTable.model_fields]  # keys of a value
    lasts = {name: name.rpartition(".")[2] for name in keys}
    alike = {last.upper(), *difflib.get_close_matches(last, set(lasts.values()), cutoff=0.75)}
    near = [f"{table}{dot}{name}" for name in difflib.get_close_matches(last, within, cutoff=0.5)]
    near = near or [name for name, word in lasts.items() if {word, word.upper()} & alike][:3]
    return f"did you mean {' or '.join(near)}?" if near else f"the keys are {', '.join(within)}"


def _names(hints: Iterable[Any], prefix: str = "") -> Iterator[str]:
    """Yield the names of all keys of the tables within types, and of those in them."""
    for hint in hints:
        table = hint.model if isinstance(hint, Flat) else hint
        if not (isinstance(table, type) and issubclass(table, pydantic.BaseModel)):
            yield from _names(get_args(table), prefix)
        elif table is not ValueTable:
            for name, field in table.model_fields.items():
                yield (key := f"{prefix}{field.alias or name}")
                yield from _names((field.annotation, *field.metadata), f"{key}.")


@cache
def _keys(model: type[pydantic.BaseModel]) -> list[str]:
    """Return the names of all keys of a table and of those in it, each once."""
    return list(dict.fromkeys(_names([model])))
