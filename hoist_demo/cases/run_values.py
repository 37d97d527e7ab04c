"""Head and values of runs in files of studies, duties, uncertain windings and measurements."""

from typing import Annotated, Any, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from hoist_demo.cases.case import BUILTIN_HOISTS
from hoist_demo.cases.table import find_case
from hoist_demo.files.reading import (
    EMPTY,
    File,
    TomlTable,
    contents,
    flat,
    path_from_file,
    reading_chain,
)
from hoist_demo.files.registry import SWIVELS, at_both_ends, group_table, run_fields
from hoist_demo.files.rope_file import FOLLOWING, KnownFile, RopeValues
from hoist_demo.files.values import ParameterValue, Text, value_type, with_status
from hoist_demo.parameters.problems import Problems
from rope_model import Level
from rope_model.texts import printable


class FileHeader(TomlTable):
    """Title, and the hoist that is wound: a file, or a name of one that the project brings."""

    title: Text = Field("", validate_default=True)
    hoist: Text = "rope-120"

    @field_validator("title")
    @classmethod
    def _check_name(cls, title: str, info: ValidationInfo) -> str:
        return title or printable(reading_chain(info)[-1].stem)

    @field_validator("hoist")
    @classmethod
    def _is_there(cls, name: str, info: ValidationInfo) -> str:
        if name.endswith(".toml") and name not in BUILTIN_HOISTS:
            name = str(path_from_file(info, name))
        find_case(name)
        return name


def _values(content: Any) -> dict[str, ParameterValue]:
    return (content.file or {}) | at_both_ends(with_status(contents(content)).items())


_BOTH = {SWIVELS: (group_table(SWIVELS, value_type), Field(default=None))}
#: a table with values of runs, by name; ``from`` names a rope's parameter file, which counts less
ParameterValues = Annotated[
    dict[str, ParameterValue],
    flat(
        "Values",
        {"file": (RopeValues, Field({}, alias="from")), **run_fields(value_type), **_BOTH},
        _values,
    ),
]


class LevelHeader(FileHeader):
    """Head of a file that is wound in process."""

    level: Level | None = Field(
        None, description="accuracy against speed of the rope; else the hoist's"
    )


class RunFile(File):
    """A file of windings in process; each kind says under which name its head stands."""

    header: LevelHeader
    fixed: ParameterValues = EMPTY

    @property
    def level(self) -> Level:
        return self.header.level or find_case(self.header.hoist).level


class RopeAnalysisFile(KnownFile):
    """A file that asks something of a rope of which properties are known.

    They decide some of its parameters.
    """

    fixed: ParameterValues = EMPTY

    @model_validator(mode="after")
    def _is_decided_once(self) -> Self:
        _ = self.catalogue_rope
        names = sorted(self.fixed.keys() & {f"rope.{name}" for name in FOLLOWING})
        follows = "follows from the properties: give [known] or [rope] instead"
        Problems(f"[fixed] {name} {follows}" for name in names).refuse()
        return self
