"""Hoists by name, the files of hoist_demo/hoists, and those of the user by path."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

from hoist_demo.cases.case import FOLDER, HOISTS, SCENARIOS, Case
from hoist_demo.files.hoist_file import read_hoist


class Cases(Mapping[str, Case]):
    """Hoists that come with the project, each read when it is asked for."""

    def __init__(self, *names: str) -> None:
        self._names = names

    def __getitem__(self, name: str) -> Case:
        if name not in self._names:
            raise KeyError(name)
        return _read(FOLDER / f"{name}.toml")

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


CASES = Cases(*HOISTS)
NAMED = Cases(*HOISTS, *SCENARIOS)


def find_case(name: str) -> Case:
    """Return the hoist of a file, or of this name; ValueError with all names when there is none."""
    if name in NAMED:
        return NAMED[name]
    if name.endswith(".toml"):
        return _read(Path(name))
    raise ValueError(f"hoist = {name!r} must be a file, NAME.toml, or one of {', '.join(NAMED)}: choose one")


def _read(path: Path) -> Case:
    return _read_version(path, path.stat().st_mtime_ns if path.is_file() else 0)


@cache
def _read_version(path: Path, _changed: int) -> Case:
    return read_hoist(path)
