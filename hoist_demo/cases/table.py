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
        self._paths = {name: FOLDER / f"{name}.toml" for name in names}

    def __getitem__(self, name: str) -> Case:
        return _read(self._paths[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)


CASES = Cases(*HOISTS)
NAMED = Cases(*HOISTS, *SCENARIOS)


def find_case(name: str) -> Case:
    """Return the hoist of a file, or of this name; ValueError with all names when there is none."""
    if name in NAMED:
        return NAMED[name]
    if name.endswith(".toml"):
        return _read(path := Path(name), path.stat().st_mtime_ns if path.is_file() else 0)
    raise ValueError(f"hoist = {name!r} must be a file, NAME.toml, or one of {', '.join(NAMED)}: choose one")


@cache
def _read(path: Path, _changed: int = 0) -> Case:
    return read_hoist(path)
