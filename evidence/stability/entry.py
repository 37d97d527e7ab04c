"""What a stability entry is, and what it found."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from evidence.claims import Measurement
from evidence.tables import Table, table


@dataclass(frozen=True)
class Finding:
    """Claims about the counterexample and about ours in the same scene; the page draws the curves of some entries."""

    counterexample: tuple[Measurement, ...]
    ours: tuple[Measurement, ...]
    curves: Table | None = None


@dataclass(frozen=True)
class Entry:
    """A scene: ``key`` names it in tests, files and the chapter's template, which tells what happens and why.

    ``slow`` entries take more than some 4 s.
    """

    key: str
    title: str
    measure: Callable[[], Finding]
    slow: bool = False


def points(axes: tuple[str, str], curves: Mapping[str, tuple[Any, Any]]) -> Table:
    """Return curves by name as a table, one point per row."""
    rows = [
        (name, float(a), float(b))
        for name, (x, y) in curves.items()
        for a, b in zip(x, y, strict=True)
    ]
    return table(("curve", *axes), rows)
