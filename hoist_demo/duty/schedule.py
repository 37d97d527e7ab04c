"""A duty's file (TOML), read and checked before anything runs.

    [duty]     title, hoist, level, and repeat = how often the trips are wound one after the other
    [fixed]    values of all trips
    [[trip]]   values of one trip: winding.* and the payloads, hoist.payload_left and hoist.payload_right

Keys and values are those of a study's [fixed]. A trip begins where the one before has ended: it waits for
winding.start_delay, travels, and dwells for winding.settle, while its payloads change evenly to those of the next.
All errors of a file are told at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import Field, create_model

from hoist_demo.cases.table import find_case
from hoist_demo.files.catalogue import host_parameters
from hoist_demo.files.fixed import Head, cure, fixed_model, fixed_values, plain, statuses
from hoist_demo.files.reading import FileError, Table, givens, optional, read_toml, table_of, validated
from hoist_demo.parameters import start_heights
from hoist_demo.study.run import RunData, build
from rope_model import Level
from rope_model.texts import printable

_PAYLOADS = ("hoist.payload_left", "hoist.payload_right")
_ROUNDING = 1e-9  #: Of heights [m].


@dataclass(frozen=True)
class Schedule:
    """Trips that are wound one after the other, again and again."""

    title: str
    hoist: str  # name or file
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
        return repr((self.hoist, self.level, self.pattern))


class _Duty(Head):
    level: Level | None = None
    repeat: int = Field(default=1, ge=1)


@cache
def _model() -> type[Table]:
    parameters = host_parameters()
    winding = table_of("winding", (p for name, p in parameters.items() if name.startswith("winding.")))
    payloads = table_of("hoist", (parameters[name] for name in _PAYLOADS))
    trip = create_model("Trip", __base__=Table, winding=optional(winding), hoist=optional(payloads))
    made: type[Table] = create_model(
        "DutyFile",
        __base__=Table,
        duty=(_Duty, Field(default_factory=_Duty)),
        fixed=optional(fixed_model()),
        trip=(list[trip], Field(min_length=1)),  # type: ignore[valid-type]
    )
    return made


def _cure(place: str) -> str:
    """Return what may have been meant by an unknown key; what a trip has not may be a key of all."""
    key = place.rpartition(" ")[2]
    if place.startswith("trip") and key in host_parameters():
        return (
            f"it must be the same in all trips: set it in [fixed]; a trip has winding.* and {' and '.join(_PAYLOADS)}"
        )
    return cure(place)


def read_schedule(path: Path, repeat: int | None = None) -> Schedule:
    """Return the schedule of a file; `repeat` replaces the file's. Raises FileError with all problems."""
    raw = read_toml(path)
    if repeat is not None and isinstance(duty := raw.setdefault("duty", {}), dict):
        duty["repeat"] = repeat
    file: Any = validated(path, _model(), raw, _cure)
    head, problems, pattern = file.duty, list[str](), list[RunData]()
    fixed = fixed_values(file.fixed)
    given = statuses(fixed)
    for k, trip in enumerate(file.trip, 1):
        own = dict(givens(trip))
        given |= statuses(own)
        try:
            pattern.append(build(head.hoist, plain({**fixed, **own})))
        except ValueError as error:
            problems.append(f"trip {k}: {error}")
    if problems:
        raise FileError(path, problems)
    title, level = head.title or printable(path.stem), head.level or find_case(head.hoist).level
    schedule = Schedule(title, head.hoist, level, tuple(pattern), head.repeat, given)
    if problem := _impossible(schedule):
        raise FileError(path, [problem])
    return schedule


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
