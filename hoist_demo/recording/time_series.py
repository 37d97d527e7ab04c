"""Time series of all signals, and their CSV files.

The CSV files carry no clock and no date: the same run writes the same bytes. The rope's shape
samples go into a file of their own, at a few instants, because hundreds of columns would bury the
rest, as would those of the stations.
"""

import csv
import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rope_model.files import whole_file

Array = NDArray[np.float64]
TIME = "time"
_ALONG = ("s", "tension", "bending", "torsion")


@dataclass(frozen=True)
class Recording:
    """Signals by name, all of one length, with their units; ``time`` [s] is one of them."""

    signals: Mapping[str, Array]
    units: Mapping[str, str]

    def __getitem__(self, name: str) -> Array:
        return self.signals[name]

    def __contains__(self, name: str) -> bool:
        return name in self.signals

    def has(self, *names: str) -> bool:
        """Return True if all these signals were recorded."""
        return all(name in self.signals for name in names)

    @property
    def time(self) -> Array:
        """Instants of the rows [s]."""
        return self.signals[TIME]

    def seconds(self, flag: str) -> float:
        """Return the time during which a 0/1 signal is 1 [s]; a value holds until the next row."""
        if flag not in self:
            return 0.0
        return float(np.sum(np.diff(self.time) * self[flag][:-1]))

    def shape_at(self, row: int) -> Array | None:
        """Return the rope's points at a row from left to right, shape (n, 3) [m].

        None if not recorded.
        """
        shapes = self.shapes_at([row])
        if shapes is None:
            return None
        shape: Array = shapes[0]
        return shape

    def shapes_at(self, rows: Sequence[int]) -> Array | None:
        """Return the rope's points at several rows, shape (rows, n, 3) [m].

        None if not recorded.
        """
        count = sum(1 for name in self.signals if name.startswith("shape.x["))
        if count == 0:
            return None
        points = np.empty((len(rows), count, 3))
        for k, axis in enumerate("xyz"):
            for i in range(count):
                points[:, i, k] = self.signals[f"shape.{axis}[{i + 1}]"][rows]
        return points

    def along(self, name: str) -> Array | None:
        """Return ``tension`` or its like at the rope's points, shape (rows, n).

        None if not recorded.
        """
        columns = [
            values for key, values in self.signals.items() if key.startswith(f"shape.{name}[")
        ]
        if not columns:
            return None
        return np.array(columns, dtype=np.float64).T


class Recorder:
    """Collector of rows of numbers, which become signals on request."""

    def __init__(self, names: Sequence[str], units: Mapping[str, str], size: int) -> None:
        """Allocate so many rows of these signals."""
        self.names = tuple(names)
        self.size = size
        self.count = 0
        self._units = dict(units)
        self._table = np.empty((size, len(self.names)))

    def add(self, *parts: Sequence[float] | Array) -> None:
        """Append one row, given in parts one after the other."""
        np.concatenate(parts, out=self._table[self.count])
        self.count += 1

    @property
    def following(self) -> Array:
        """View of the free rows, for a caller who fills and counts them himself."""
        return self._table[self.count :]

    def resume(self, recording: Recording, rows: int) -> None:
        """Copy the first rows of a recording."""
        self._table[:rows] = np.array([recording[name][:rows] for name in self.names]).T
        self.count = rows

    def recording(self) -> Recording:
        """Return all rows so far."""
        columns = self._table[: self.count].T.copy()
        units = {name: self._units.get(name, "") for name in self.names}
        return Recording(dict(zip(self.names, columns, strict=True)), units)


def is_along(name: str) -> bool:
    """Return True for what is known at many places of a rope."""
    return any(f".{part}." in f".{name}" for part in ("shape", "station"))


def match_signals(patterns: Iterable[str], available: Sequence[str]) -> tuple[str, ...]:
    """Return the available signals that match the patterns, in their order.

    A ``*`` stands for any letters.
    """
    matches: dict[str, None] = {}
    for pattern in patterns:
        expression = re.compile(re.escape(pattern).replace(r"\*", ".*"))
        names = [name for name in available if expression.fullmatch(name)]
        if not names:
            near = difflib.get_close_matches(pattern, available, n=3)
            cure = "see docs/reference/variables.md"
            if near:
                cure = f"did you mean {' or '.join(near)}?"
            raise ValueError(f"signals has {pattern!r}, which nothing shows: {cure}")
        matches |= dict.fromkeys(names)
    return tuple(matches)


def write_csv(recording: Recording, path: Path, names: Sequence[str] = ()) -> None:
    """Write signals with their time, header ``name [unit]``.

    Without names all but those of ``is_along``.
    """
    if names:
        names = [TIME, *(name for name in names if name in recording and name != TIME)]
    else:
        names = [name for name in recording.signals if not is_along(name)]
    with whole_file(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([_header(name, recording.units.get(name, "")) for name in names])
        # minus zero is zero, as in _number, which formats one at a time and takes three times as long
        table = np.column_stack([recording[name] for name in names]) + 0.0
        line = ",".join([_FORMAT] * len(names)) + "\n"
        for row in table.tolist():
            file.write(line % tuple(row))


def write_shapes(recording: Recording, rows: Sequence[int], path: Path) -> None:
    """Write rope points at the given rows.

    Columns: time, point number from the left end, x, y, z, tension and stresses.
    """
    along = {name: values for name in _ALONG if (values := recording.along(name)) is not None}
    more = [_header(name, recording.units.get(f"shape.{name}[1]", "")) for name in along]
    with whole_file(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["time [s]", "point", "x [m]", "y [m]", "z [m]", *more])
        for row in rows:
            shape = recording.shape_at(row)
            if shape is not None:
                t = _number(recording.time[row])
                points = np.column_stack([shape, *(values[row] for values in along.values())])
                for number, point in enumerate(points, 1):
                    writer.writerow([t, number, *map(_number, point)])


def shape_rows(recording: Recording, count: int = 7) -> list[int]:
    """Return rows at evenly spaced instants, first and last included."""
    last = len(recording.time) - 1
    if last < 0:
        return []
    return sorted({round(last * k / (count - 1)) for k in range(count)})


def _number(value: float) -> str:
    """Format with ten digits.

    Minus zero is zero, so that the sign of a rounding error does not show.
    """
    return _FORMAT % (float(value) + 0.0)


_FORMAT = "%.10g"  #: Ten digits.


def _header(name: str, unit: str) -> str:
    if unit:
        return f"{name} [{unit}]"
    return name
