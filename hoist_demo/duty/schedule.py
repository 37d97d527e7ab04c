"""A duty's file: trips that follow one another, read and checked before anything runs.

A trip begins where the one before has ended: it waits for winding.start_delay, travels, and dwells
for winding.settle, while its payloads change evenly to those of the next.
"""

from collections.abc import Collection
from functools import cached_property
from pathlib import Path
from typing import Any, Self

from pydantic import Field, model_validator

from hoist_demo.cases.run_values import LevelHeader, ParameterValues, RunFile
from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.identity import Identity, named_values
from hoist_demo.files.reading import read
from hoist_demo.files.values import VARIED, statuses, values_of
from hoist_demo.parameters.problems import Problems
from hoist_demo.run.data import RunData, build
from hoist_demo.run.ropes import Ropes, require_unbroken, ropes_of
from rope_model.physics.elementary import sum_of

_PAYLOADS = ("hoist.payload_left", "hoist.payload_right")
HEIGHT_ROUNDING = 1e-9  #: Of heights [m].


class Duty(LevelHeader):
    """Table [duty] at the head of a schedule's file."""

    repeat: int = Field(1, ge=1, description="how often the trips are wound one after the other")


class Schedule(RunFile):
    """Schema of a schedule's TOML file: trips in order, all of them repeated."""

    header: Duty = Field({}, alias="duty", validate_default=True)
    trips: list[ParameterValues] = Field(alias="trip", min_length=1)

    @property
    def status_by_name(self) -> dict[str, str]:
        """Status of each value that is set, by name; varied if it differs between trips."""
        status_by_name: dict[str, str] = {}
        for values in (self.fixed, *self.trips):
            status_by_name |= statuses(values)
        runs = [values_of({**self.fixed, **trip}) for trip in self.trips]
        for name in status_by_name:
            if len({run.get(name) for run in runs}) > 1:
                status_by_name[name] = VARIED
        return status_by_name

    @cached_property
    def pattern(self) -> tuple[RunData, ...]:
        """Data of the listed trips, once each, from where the first of their cycles begins."""
        runs: list[RunData] = []
        with Problems() as problems:
            for k, trip in enumerate(self.trips, 1):
                for key, entry in trip.items():
                    if key not in _PAYLOADS and not key.startswith("winding."):
                        problems.append(
                            f"trip {k}: {key} = {entry.value!r} must be the same in all trips: set "
                            f"it in [fixed]; a trip has winding.* and {' and '.join(_PAYLOADS)}"
                        )
                with problems.at(f"trip {k}"):
                    start = None
                    if runs:
                        start = runs[-1].start_height + runs[-1].winding.travel
                    runs.append(self._build(trip, start))
        return tuple(runs)

    def _build(self, trip: ParameterValues, start: float | None) -> RunData:
        """Return the data of a trip, designed for its way and the payloads of hoist and [fixed]."""
        return build(self.header.hoist, self.fixed, varied=trip, start=start)

    @cached_property
    def _later(self) -> dict[int, RunData]:
        """Data of trips that begin elsewhere than their pattern, by number; made on request."""
        return {}

    @property
    def count(self) -> int:
        """Number of trips, repetitions included."""
        return self.header.repeat * len(self.pattern)

    def trip(self, number: int) -> RunData:
        """Return the data of a trip, the first being 1; beyond the last one the pattern goes on."""
        cycle, place = divmod(number - 1, len(self.pattern))
        run = self.pattern[place]
        moved = cycle * sum(one.winding.travel for one in self.pattern)
        if abs(moved) < HEIGHT_ROUNDING:
            return run
        if number not in self._later:
            self._later[number] = self._build(self.trips[place], run.start_height + moved)
        return self._later[number]

    def landing(self, number: int) -> float:
        """Height of the left conveyance after so many trips [m].

        The first begins at an end of the shaft.
        """
        cycles, places = divmod(number, len(self.pattern))
        travels = [run.winding.travel for run in self.pattern]
        whole = cycles * float(sum_of(travels))
        return self.pattern[0].start_height + whole + float(sum_of(travels[:places]))

    @property
    def identity(self) -> Identity:
        """Data that a duty and its continuation must share: all but the number of repetitions."""
        values: dict[str, Any] = {"hoist": self.header.hoist, "level": self.level}
        for k, run in enumerate(self.pattern, 1):
            for name, value in run.identity.items():
                values[f"trip {k}: {name}"] = value
        for rope in find_case(self.header.hoist).distinct_ropes:
            parts = (rope.parameters, rope.suspension, rope.breaks, {"number": rope.number})
            for part in parts:
                values |= named_values(part, f"rope {rope.name}")
        return values

    def ropes(self, outputs: Collection[str] | None = None) -> Ropes:
        """Return the balance ropes, of which these ``outputs`` are recorded, as of ``OneRope``."""
        return ropes_of(
            find_case(self.header.hoist), self.pattern[0], self.fixed, self.level, outputs
        )

    @model_validator(mode="after")
    def _ropes_hang(self) -> Self:
        case = find_case(self.header.hoist)
        require_unbroken(case, "a hoist with a broken rope does not go on")
        if case.distinct_ropes:
            self.ropes()  # checks them
        return self

    @model_validator(mode="after")
    def _follow_one_another(self) -> Self:
        top = self.trip(1).hoist.shaft_travel
        for k in range(1, self.count + 1):
            winding = self.trip(k).winding
            end = self.landing(k)
            if not -HEIGHT_ROUNDING <= end <= top + HEIGHT_ROUNDING:
                raise ValueError(
                    f"trip {k}: winding.travel = {winding.travel:g} m leads to {end:g} m, which "
                    f"must be within 0 and hoist.shaft_travel = {top:g} m: shorten it, or let the "
                    "trips lead back"
                )
            if winding.emergency_at is not None:
                raise ValueError(
                    f"trip {k}: winding.emergency_at must be left out: a trip of a duty ends at a "
                    "landing"
                )
            if winding.settle == 0.0 and _payloads(self.trip(k)) != _payloads(self.trip(k + 1)):
                raise ValueError(
                    f"trip {k}: winding.settle = 0 s must be above 0, for the payload changes: "
                    "give the dwell's time"
                )
        return self


def read_schedule(path: Path, repeat: int | None = None) -> Schedule:
    """Return the schedule of a file; ``repeat`` replaces the file's.

    Raises FileError with all problems.
    """
    if repeat is None:
        return read(path, Schedule)
    return read(path, Schedule, over={"duty": {"repeat": repeat}})


def _payloads(run: RunData) -> tuple[float, float]:
    return run.hoist.payload_left, run.hoist.payload_right
