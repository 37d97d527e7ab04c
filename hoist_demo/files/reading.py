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
from typing import Annotated, Any, NamedTuple, TypeVar, get_args

import pydantic

from hoist_demo.files.values import ValueTable, value_type
from hoist_demo.parameters.quantity import FileParameter
from rope_model.texts import printable


class FileError(ValueError):
    """Problems of a file, one line each."""

    def __init__(self, path: Path, problems: Iterable[str]) -> None:
        self.problems = tuple(dict.fromkeys(map(printable, problems)))
        super().__init__(
            "\n".join(f"{printable(str(path))}: {problem}" for problem in self.problems)
        )


class TomlTable(pydantic.BaseModel):
    """TOML table whose keys are all known."""

    model_config = pydantic.ConfigDict(
        extra="forbid", frozen=True, arbitrary_types_allowed=True, defer_build=True
    )


class File(TomlTable):
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
    """Annotation for pydantic: the key is a table of this model, its value ``make`` of it."""

    model: type[TomlTable]
    make: Callable[[Any], Any]

    def __get_pydantic_core_schema__(
        self, source: Any, handler: pydantic.GetCoreSchemaHandler
    ) -> Any:
        """Return pydantic's schema."""
        return handler.generate_schema(Annotated[self.model, pydantic.AfterValidator(self.make)])


def table_of(
    name: str,
    parameters: Iterable[FileParameter],
    leaf: Callable[[FileParameter], Any] = value_type,
) -> type[TomlTable]:
    """Return the model of a table with these parameters, whose names may have more dots.

    ``leaf`` gives their types.
    """
    members_by_key: dict[str, list[FileParameter]] = {}
    for parameter in parameters:
        key = parameter.name.removeprefix(f"{name}.").partition(".")[0]
        members_by_key.setdefault(key, []).append(parameter)
    fields: dict[str, Any] = {}
    for number, (key, members) in enumerate(members_by_key.items()):
        whole = f"{name}.{key}"
        is_leaf = members[0].name == whole
        if is_leaf:
            kind = leaf(members[0])
        else:
            kind = table_of(whole, members, leaf)
        # brackets in a key are no identifier
        fields[f"key{number}"] = (kind, pydantic.Field(default=None, alias=key))
    title = "".join(map(str.title, name.split(".")))
    model: type[TomlTable] = pydantic.create_model(title, __base__=TomlTable, **fields)
    return model


def contents(table: pydantic.BaseModel, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield all that a table and those in it set, by dotted names."""
    for name, field in type(table).model_fields.items():
        if name not in table.model_fields_set:
            continue
        key = f"{prefix}{field.alias or name}"
        content = getattr(table, name)
        if isinstance(content, TomlTable) and not isinstance(content, File):
            yield from contents(content, f"{key}.")
        else:
            yield key, content


def flat(name: str, fields: Mapping[str, Any], make: Callable[[Any], Any] | None = None) -> Flat:
    """Return the annotation of a table with these fields: its values by dotted names."""
    model: type[TomlTable] = pydantic.create_model(name, __base__=TomlTable, **fields)
    return Flat(model, make or (lambda table: dict(contents(table))))


def read(
    path: Path,
    model: type[T],
    opened: Sequence[Path] = (),
    over: Mapping[str, Mapping[str, object]] | None = None,
) -> T:
    """Return a file's contents or raise FileError.

    Files ``opened`` led to it, keys of ``over`` replace the file's.
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
        table_of_file = tables.setdefault(key, {})
        if isinstance(table_of_file, dict):
            table_of_file |= table
    try:
        return model.model_validate(tables, context=(*opened, path))
    except pydantic.ValidationError as error:
        problems: list[str] = []
        for one in error.errors():
            problems += _problems(_keys(model), one)
        raise FileError(path, problems) from error


@contextmanager
def errors_of_file(path: Path) -> Iterator[None]:
    """Raise refusals of the block as FileError of this file, unless they are FileErrors already."""
    try:
        yield
    except FileError:
        raise
    except ValueError as error:
        raise FileError(path, str(error).splitlines()) from error


def reading_chain(info: pydantic.ValidationInfo) -> tuple[Path, ...]:
    """Return the file that is read, the last, and those that led to it."""
    return info.context or (Path("file"),)


def path_from_file(info: pydantic.ValidationInfo, name: str) -> Path:
    """Return the path of a file that the one which is read names."""
    return reading_chain(info)[-1].parent / name


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
    position = _position(error)
    if position == _END:
        return ""
    before = text.splitlines(keepends=True)[: position.line - 1]
    at = sum(map(len, before)) + position.column - 1
    try:
        tomllib.loads(text[:at] + "," + text[at:])
    except tomllib.TOMLDecodeError as further:
        if _position(further) <= position._replace(column=position.column + 1):
            return ""
    return (
        f"a comma is missing at line {position.line}, column {position.column}: put it before what "
        "stands there"
    )


class _Position(NamedTuple):
    """Position in a text, both counted from 1."""

    line: int
    column: int


_END = _Position(sys.maxsize, 0)  # the text ends too soon


def _position(error: tomllib.TOMLDecodeError) -> _Position:
    """Return line and column of a TOML error, or _END."""
    match = re.search(r"line (\d+), column (\d+)", str(error))
    if match is None:
        return _END
    return _Position(line=int(match[1]), column=int(match[2]))


MAX_SHOWN = 60  #: Characters of a wrong value that a message shows.
_ONE_TABLE = "{key_path} = {short} must be one table: write [{key_path}] above it"
_LIST = "{key_path} = {short} must be a list: write [[{key_path}]] above each table, or [a, b]"
#: Messages by pydantic's types of errors.
_TEXTS = {
    "model_type": _ONE_TABLE,
    "dict_type": _ONE_TABLE,
    "model_attributes_type": _ONE_TABLE,
    "list_type": _LIST,
    "tuple_type": _LIST,
    "string_type": "{key_path} = {short} must be a text: put it in quotation marks",
    "extra_forbidden": "{key_path} = {short} is not a key: {cure}",
    "missing": "{key_path} is missing: give it",
    "union_tag_not_found": "{key_path}: {key} is missing: give it",
    "union_tag_invalid": "{key_path}: {key} = {tag!r} must be one of {expected_tags}: choose one",
}


def _problems(names: Sequence[str], error: Any) -> list[str]:
    """Return the lines on one error of pydantic's, in a file that has these keys."""
    # the path of a table of several kinds names its kind, too, which is no key
    keys = {*error["loc"][-1:]}
    for name in names:
        keys |= {*name.split(".")}
    loc = [part for part in error["loc"] if isinstance(part, int) or part in keys]
    context = error.get("ctx", {})
    key_path = _key_path(loc)
    if error["type"] == "value_error":
        return [_located(key_path, line) for line in str(context["error"]).splitlines()]
    short = repr(error["input"])
    if len(short) > MAX_SHOWN:
        short = f"{short[: MAX_SHOWN - 3]}..."
    cure = cure_of(".".join(part for part in loc if isinstance(part, str)), names)
    if "." in str(loc[-1]):
        cure = "leave out the quotation marks"
    placeholders = {
        "key_path": key_path,
        "short": short,
        "cure": cure,
        "requirement": error["msg"].partition(" should ")[2] or error["msg"],
        "key": context.get("discriminator", "").strip("'"),
    }
    text = _TEXTS.get(error["type"], "{key_path} = {short} must {requirement}: correct it")
    return [text.format(**context | placeholders)]


def _located(key_path: str, text: str) -> str:
    """Return a problem behind its key path, unless it begins with the key itself."""
    name = text.partition(" ")[0]
    table = key_path.removesuffix(name).removesuffix(name.removeprefix("rope.")).rstrip(" .")
    if table:
        return f"{table}: {text}"
    return text


def _key_path(loc: Sequence[int | str]) -> str:
    """Return the dotted path of a key.

    Members of lists are counted from 1: ``rope 2 left.swivel.mode``.
    """
    path = ""
    for part in loc:
        if isinstance(part, int):
            path += f" {part + 1} "
        else:
            path += f".{part or repr(part)}"
    return path.replace(" .", " ").strip(" .")


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
    for name, words in _OLD.items():
        if f".{key}".endswith(f".{name}"):
            return words
    if key in keys:
        return "it is of another kind of that table: leave it out"
    table, dot, last = key.rpartition(".")
    within = [name.removeprefix(table + dot) for name in keys if name.rpartition(".")[0] == table]
    within = within or [*ValueTable.model_fields]  # keys of a value
    lasts = {name: name.rpartition(".")[2] for name in keys}
    alike = {last.upper(), *difflib.get_close_matches(last, set(lasts.values()), cutoff=0.75)}
    near = [f"{table}{dot}{name}" for name in difflib.get_close_matches(last, within, cutoff=0.5)]
    near = near or [name for name, word in lasts.items() if {word, word.upper()} & alike][:3]
    if near:
        return f"did you mean {' or '.join(near)}?"
    return f"the keys are {', '.join(within)}"


def _names(hints: Iterable[Any], prefix: str = "") -> Iterator[str]:
    """Yield the names of all keys of the tables within types, and of those in them."""
    for hint in hints:
        table = hint.model if isinstance(hint, Flat) else hint
        if not (isinstance(table, type) and issubclass(table, pydantic.BaseModel)):
            yield from _names(get_args(table), prefix)
        elif table is not ValueTable:
            for name, field in table.model_fields.items():
                key = f"{prefix}{field.alias or name}"
                yield key
                yield from _names((field.annotation, *field.metadata), f"{key}.")


@cache
def _keys(model: type[pydantic.BaseModel]) -> list[str]:
    """Return the names of all keys of a table and of those in it, each once."""
    return list(dict.fromkeys(_names([model])))
