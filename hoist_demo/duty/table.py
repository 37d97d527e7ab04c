"""Table of the trips of a duty, the worst of all, and the trip from which on they repeat.

A trip repeats the one a cycle before when none of REPEATING has changed by more than STEADY of its
largest value in the duty; what is below its unit's NEGLIGIBLE counts as nothing. The cycle is as
many trips as the schedule lists.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hoist_demo.cosimulation.schemes.interface import RopePlant
from hoist_demo.duty.schedule import Schedule
from hoist_demo.duty.wind import WoundTrip
from hoist_demo.recording.ropes import as_only_rope
from hoist_demo.recording.time_series import Array, Recording
from hoist_demo.run.data import RunData
from hoist_demo.run.metrics import (
    METRICS,
    ROPE_METRICS,
    ROPE_SIGNALS,
    measure_ropes,
    name_without_rope,
)
from rope_model import EndMotion

READ = ROPE_SIGNALS | {"loop.turns"}  #: Outputs of the rope that the table is made of.

#: Metrics of a study; sway is from where the loop hung at rest before the first trip.
_MEASURED = (
    "rope_force_ripple",
    "rope_force_peak",
    "rope_force_range",
    "bending_stress",
    "sway",
    "sway_across",
    "loop_yaw",
    "clearance",
    "left_swivel_torque",
    "right_swivel_torque",
    "left_slip",
    "right_slip",
    "slip_safety",
    "position_error",
    "torque_rms",
    "motor_energy_drawn",
)

#: Columns of the table, each with unit and meaning.
COLUMNS = {
    "trip": ("1", "number, from 1"),
    "start": ("s", "time at which it begins, waiting included"),
    "landing": ("m", "height of the left conveyance where it ends"),
    "yaw_start": ("rad", "of the loop as it begins: what the trip before has left"),
    "yaw_end": ("rad", "as it ends, after its dwell"),
    "yaw_dwelling": ("rad", "largest magnitude after the reference's arrival"),
    "yaw_dwelling_at": ("s", "after the arrival"),
    "turns": ("1", "of one side of the rope about the other, largest magnitude"),
    **{name: METRICS[name] for name in _MEASURED},
}

#: Columns that each of several ropes has of its own, under its name.
_ROPE_COLUMNS = ROPE_METRICS | {"yaw_start", "yaw_end", "yaw_dwelling", "yaw_dwelling_at", "turns"}
_UNITS = {name: unit for name, (unit, _) in COLUMNS.items()} | {"difference": "1"}
_SMALLEST_IS_WORST = ("clearance", "slip_safety")
#: Columns of which the worst trip is reported.
REPORTED = (
    "rope_force_ripple",
    "rope_force_range",
    "sway",
    "sway_across",
    "loop_yaw",
    "turns",
    "clearance",
    "left_swivel_torque",
    "right_swivel_torque",
    "slip_safety",
    "position_error",
)
REPEATING = (
    "rope_force_ripple",
    "sway",
    "sway_across",
    "loop_yaw",
    "yaw_start",
    "left_swivel_torque",
)
STEADY = 0.01
NEGLIGIBLE = {"N": 1.0, "m": 1e-3, "rad": 1e-3, "N.m": 0.1}


@dataclass(frozen=True)
class Worst:
    """Worst trip by one column, and the worst of the first cycle, which begins at rest."""

    name: str
    value: float
    trip: int
    first_cycle: float


@dataclass(frozen=True)
class RestPlace:
    """Place of a loop's lowest point at rest [m]."""

    x: float
    z: float


def unit_of(column: str) -> str:
    """Return the unit of a column, of a rope's own too.

    "" for one that the table does not state.
    """
    return _UNITS.get(name_without_rope(column), "")


def place_at_rest(
    schedule: Schedule, rope: RopePlant, names: Sequence[str] = ("",)
) -> dict[str, RestPlace]:
    """Return the place of each rope's loop at rest before the first trip, by its name.

    NaN if it does not hang.
    """
    left = schedule.landing(0)
    rope.initialize(0.0, EndMotion(y=left), EndMotion(y=schedule.trip(1).hoist.shaft_travel - left))
    places: dict[str, RestPlace] = {}
    for name in names:
        prefix = f"{name}." if name else ""
        x, z = rope.reader([f"{prefix}loop.x", f"{prefix}loop.z"])().tolist()
        places[name] = RestPlace(x, z)
    return places


def trip_row(trip: WoundTrip, rest: Mapping[str, RestPlace]) -> dict[str, float]:
    """Return the row of a trip.

    ``rest`` has the place of each rope's loop at rest, by the rope's name.
    """
    recording = trip.result.recording
    measured = measure_ropes(trip.result, trip.data.hoist, trip.data.arrival, [*rest])
    measured["trip"] = float(trip.number)
    measured["start"] = float(recording.time[0])
    if trip.result.end is not None:
        measured["landing"] = trip.result.end.landing
    arrived = trip.result.trajectory.duration
    for name, place in rest.items():
        prefix = f"{name}." if name else ""
        for key, value in _rope_columns(as_only_rope(recording, name), place, arrived).items():
            measured[f"{prefix}{key}"] = value
    return {column: measured.get(column, math.nan) for column in _columns([*rest])}


def _columns(ropes: Sequence[str]) -> Iterator[str]:
    """Yield the names of the columns, those of each of several ropes with its name."""
    for column in COLUMNS:
        if column in _ROPE_COLUMNS and tuple(ropes) != ("",):
            yield from (f"{rope}.{column}" for rope in ropes)
        else:
            yield column


def _rope_columns(recording: Recording, rest: RestPlace, arrived: float) -> dict[str, float]:
    """Return what a trip shows of one rope beside its metrics."""
    columns = {
        "sway": float(np.max(np.abs(recording["loop.x"] - rest.x))),
        "sway_across": float(np.max(np.abs(recording["loop.z"] - rest.z))),
        "turns": float(np.max(np.abs(recording["loop.turns"]))),
    }
    return columns | _yaw(recording, arrived)


def landing_warnings(row: Mapping[str, float], data: RunData) -> list[str]:
    """Warn of a trip whose dwell ends far from the landing.

    The drive alone holds the hoist while it is loaded.
    """
    error = abs(row["position_error"])
    band = data.arrival.position_band
    if not error > band:
        return []
    return [
        f"the left conveyance ends its dwell {error:.3g} m from the landing, not within "
        f"arrival.position_band = {band:g} m: the drive alone holds it while payloads change; "
        "lengthen winding.settle, or raise gains.position"
    ]


def _yaw(recording: Recording, arrived: float) -> dict[str, float]:
    yaw = recording["loop.yaw"]
    t = recording.time - recording.time[0] - arrived
    columns = {"yaw_start": float(yaw[0]), "yaw_end": float(yaw[-1])}
    dwelling = np.flatnonzero(t >= 0.0)
    if dwelling.size and np.isfinite(yaw).all():
        largest = dwelling[np.argmax(np.abs(yaw[dwelling]))]
        columns["yaw_dwelling"] = float(abs(yaw[largest]))
        columns["yaw_dwelling_at"] = float(t[largest])
    return columns


def trip_table(rows: Sequence[Mapping[str, float]], cycle: int) -> Recording:
    """Return all rows as columns, with the change from the trip a cycle before."""
    columns: dict[str, Array] = {}
    for name in rows[-1]:
        columns[name] = np.array([row[name] for row in rows])
    columns["difference"] = differences(columns, cycle)
    return Recording(columns, {name: unit_of(name) for name in columns})


def differences(columns: Mapping[str, Array], cycle: int) -> Array:
    """Return the largest change of REPEATING against the trip a cycle before.

    It is a part of the column's largest value, NaN in the first cycle.
    """
    changes = np.full(columns["trip"].size, math.nan)
    if changes.size <= cycle:
        return changes
    changes[cycle:] = 0.0
    for name, values in columns.items():
        if name_without_rope(name) in REPEATING and np.isfinite(values).all():
            largest = max(float(np.max(np.abs(values))), NEGLIGIBLE[unit_of(name)] / STEADY)
            change = np.abs(values[cycle:] - values[:-cycle]) / largest
            changes[cycle:] = np.maximum(changes[cycle:], change)
    return changes


def steady_from(trips: Recording, cycle: int) -> int | None:
    """Return the first trip from which on each repeats the one a cycle before; else None.

    At least the trips of one cycle must repeat.
    """
    unlike = np.flatnonzero(~(trips["difference"] <= STEADY))
    first = int(unlike[-1]) + 1 if unlike.size else 0
    if first + cycle > trips["trip"].size:
        return None
    return int(trips["trip"][first])


def worst(trips: Recording, cycle: int) -> list[Worst]:
    """Return the worst trip by each column of JUDGED that the rope's fidelity shows."""
    worst_trips = []
    for reported in REPORTED:
        for name, values in trips.signals.items():
            if name_without_rope(name) == reported and np.isfinite(values).all():
                worst_trips.append(_worst(name, values, trips["trip"], cycle))
    return worst_trips


def _worst(name: str, values: Array, numbers: Array, cycle: int) -> Worst:
    """Return the worst trip by the ``values`` of a column, with its number."""
    if name_without_rope(name) in _SMALLEST_IS_WORST:
        k = int(np.argmin(values))
        return Worst(name, float(values[k]), int(numbers[k]), float(np.min(values[:cycle])))
    sizes = np.abs(values)
    k = int(np.argmax(sizes))
    return Worst(name, float(sizes[k]), int(numbers[k]), float(np.max(sizes[:cycle])))
