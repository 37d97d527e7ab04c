"""What files of studies, duties, uncertain windings and measurements have in common: a head, and values of runs."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import Field, create_model, field_validator

from hoist_demo.cases.table import find_case
from hoist_demo.files.catalogue import Catalogue, cure_of, of_run
from hoist_demo.files.reading import Table, givens
from hoist_demo.files.rope_file import read_rope_file
from hoist_demo.files.values import Given, Text, given
from hoist_demo.parameters.quantity import Value

#: tables that hold values of runs
_HOLDERS = ("fixed.", "vary.", "values.", "sought.")


class Head(Table):
    """Title, and the hoist that is wound: a file, or the name of one that comes with the project."""

    title: Text = ""
    hoist: Text = "rope-120"

    @field_validator("hoist")
    @classmethod
    def _is_there(cls, name: str) -> str:
        find_case(name)
        return name


@cache
def fixed_model() -> type[Table]:
    """Return the model of a table with values of runs; `from` names a rope's parameter file, which counts less."""
    file = (Text, Field(default="", alias="from", description="parameter file that balance-rope identify wrote"))
    made: type[Table] = create_model("Fixed", __base__=Table, file=file, **of_run(given))
    return made


def fixed_values(table: Any) -> dict[str, Given]:
    """Return the values of such a table by name; ValueError where its file is wrong."""
    if table is None:
        return {}
    below = read_rope_file(Path(table.file), Catalogue()) if table.file else {}
    return below | dict(givens(table))


def plain(values: Mapping[str, Given]) -> dict[str, Value]:
    """Return the values alone."""
    return {key: one.value for key, one in values.items()}


def statuses(values: Mapping[str, Given]) -> dict[str, str]:
    """Return where each value comes from."""
    return {key: one.status for key, one in values.items()}


def cure(place: str) -> str:
    """Return what may have been meant by an unknown key at a place of such a file."""
    key = place.rpartition(" ")[2]
    for holder in _HOLDERS:
        key = key.removeprefix(holder)
    if key.rpartition(".")[2] == "case":
        return 'write hoist = "NAME", or hoist = "FILE.toml"'
    return cure_of(key) if "." in key else "see docs/reference/files.md"
