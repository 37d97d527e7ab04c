"""A duty's file (TOML), read and checked before anything runs.

    [duty]     title, case, level, and repeat = how often the trips are wound one after the other
    [fixed]    values of all trips
    [[trip]]   values of one trip: winding.* and the payloads, hoist.payload_left and hoist.payload_right

Keys and values are those of a study's [fixed]. A trip begins where the one before has ended: it waits for
winding.start_delay, travels, and dwells for winding.settle, while its payloads change evenly to those of the next.
All errors of a file are told at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hoist_demo.files.catalogue import Catalogue
from hoist_demo.files.reading import FileError
from hoist_demo.parameters import start_heights
from hoist_demo.parameters.quantity import Parameter, Value
from hoist_demo.study.reading import Problems, read_head, read_statuses, read_tables, read_values
from hoist_demo.study.run import RunData, build
from rope_model import Level

_TABLES = {"duty": dict, "fixed": dict, "trip": list}
_PAYLOADS = ("hoist.payload_left", "hoist.payload_right")
_ROUNDING = 1e-9  #: Of heights [m].


@dataclass(frozen=True)
class Schedule:
    """Trips that are wound one after the other, again and again."""

    title: str
    case: str
    level: Level
    pattern: tuple[RunData, ...]
    repeat: int
    given: Mapping[str, str]  # where each value that is set comes from, by name

    @property
    def count(self) -> int:
        """Number of all trips."""
        return self.repeat * len(self.pattern)

    def trip(self, number: int) -> RunData:
        """Data of a trip, the first being 1; beyond the last one the pattern goes on."""
        return self.pattern[(number - 1) % len(self.pattern)]

    def landing(self, number: int) -> float:
        """Height of the left conveyance after so many trips [m]; the first begins at an end of the shaft."""
        start, _ = start_heights(self.trip(1).hoist, self.trip(1).winding)
        return start + sum(self.trip(k).winding.travel for k in range(1, number + 1))

    @property
    def data(self) -> str:
        """Data that a duty and its continuation must share: all but the number of repetitions."""
        return repr((self.case, self.level, self.pattern))


def read_schedule(path: Path, rope: Mapping[str, Parameter], repeat: int | None = None) -> Schedule:
    """The schedule of a file for a rope with these parameters; `repeat` replaces the file's.

    Raises FileError with all problems.
    """
    return _Reader(path, Catalogue(rope)).schedule({} if repeat is None else {"repeat": repeat})


class _Reader:
    """Collects the problems while it reads."""

    def __init__(self, path: Path, catalogue: Catalogue) -> None:
        self._path, self._catalogue, self._problems = path, catalogue, Problems()
        self._raw = read_tables(path, "a duty", _TABLES, self._problems)

    def schedule(self, given: Mapping[str, Value]) -> Schedule:
        """The schedule, where nothing is wrong; what is given replaces the file's."""
        head = self._head(given)
        fixed = read_values(self._catalogue, "[fixed]", self._raw.get("fixed", {}), self._problems)
        trips = self._raw.get("trip", [])
        if not trips:
            self._problems.append("a duty needs trips: give at least one [[trip]]")
        own = [read_values(self._catalogue, f"trip {k}", trip, self._problems) for k, trip in enumerate(trips, 1)]
        for k, values in enumerate(own, 1):
            for key in values:
                if not (key.startswith("winding.") or key in _PAYLOADS):
                    known = f"winding.* and {' and '.join(_PAYLOADS)}"
                    self._problems.append(f"trip {k}: {key} must be the same in all trips: a trip has {known}")
        self._stop_where_wrong()
        pattern: list[RunData] = []
        for k, values in enumerate(own, 1):
            with self._problems.collect(f"trip {k}"):
                pattern.append(build(head["hoist"], {**fixed, **values}))
        self._stop_where_wrong()
        given = read_statuses(self._raw.get("fixed", {}))
        for trip in trips:
            given |= read_statuses(trip)
        schedule = Schedule(pattern=tuple(pattern), given=given, **head)
        if problem := _impossible(schedule):
            raise FileError(self._path, [problem])
        return schedule

    def _stop_where_wrong(self) -> None:
        if self._problems:
            raise FileError(self._path, self._problems)

    def _head(self, given: Mapping[str, Value]) -> dict[str, Any]:
        """Title, case, level and repeat."""
        table = {**self._raw.get("duty", {}), **given}
        head = read_head(self._path, "duty", table, {"repeat": 1}, self._problems)
        if type(head["repeat"]) is not int or head["repeat"] < 1:
            self._problems.append(
                f"[duty] repeat = {head['repeat']!r} must be a whole number from 1 on: count the cycles"
            )
        return head


def _impossible(schedule: Schedule) -> str:
    """Return the problems of trips that follow one another; "" for none."""
    top = schedule.trip(1).hoist.shaft_travel
    for number in range(1, schedule.count + 1):
        winding, end = schedule.trip(number).winding, schedule.landing(number)
        if not -_ROUNDING <= end <= top + _ROUNDING:
            return (
                f"trip {number}: winding.travel = {winding.travel:g} m leads to {end:g} m, which must be within 0 and "
                f"hoist.shaft_travel = {top:g} m: shorten it, or let the trips lead back"
            )
        if winding.emergency_at is not None:
            return f"trip {number}: winding.emergency_at must be left out: a trip of a duty ends at a landing"
        if winding.settle == 0.0 and _payloads(schedule.trip(number)) != _payloads(schedule.trip(number + 1)):
            return (
                f"trip {number}: winding.settle = 0 s must be above 0, for the payload changes: give the dwell's time"
            )
    return ""


def _payloads(run: RunData) -> tuple[float, float]:
    return run.hoist.payload_left, run.hoist.payload_right
