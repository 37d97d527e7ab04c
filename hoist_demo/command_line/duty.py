"""The command ``balance-rope duty``."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hoist_demo.command_line.support import (
    CHECKED,
    HOIST_UNCHECKED,
    INTERRUPTED,
    add_results,
    describe,
    interruption,
    results_folder,
)
from hoist_demo.cosimulation.progress import progress_bar
from hoist_demo.parameters import ASSUMED_DATA
from hoist_demo.recording.exposure import (
    STATION_SIGNALS,
    exposure,
    flatten,
    gather,
    joined_exposure,
)
from hoist_demo.recording.fidelity import remark
from hoist_demo.recording.incidents import circuit_stop
from hoist_demo.recording.ropes import computed, rope_signals
from hoist_demo.recording.time_series import TIME, Recording, write_csv
from hoist_demo.report.formatting import number
from hoist_demo.report.rows import OUTCOME, WARNING, SummaryRow, in_display_unit, render
from hoist_demo.report.summary import exposure_rows
from hoist_demo.report.verdict import outcome

if TYPE_CHECKING:
    from hoist_demo.cosimulation.participants.rope_data import RopeData
    from hoist_demo.cosimulation.run_state import Result
    from hoist_demo.duty.schedule import Schedule
    from hoist_demo.duty.wind import WoundTrip
    from hoist_demo.run.ropes import Ropes

_STATION = "station.s[1]"  #: Column of a duty's state that shows that exposure was counted.
#: File in the output folder with the state after the last trip that is wound.
STATE = "last_trip.npz"

_DESCRIPTION = """\
Wind the trips of a schedule one after the other with the rope in this process: yaw, swing and swivel angles go on from
trip to trip. After every trip the state is kept: start the same command again to go on after an interruption."""

_EPILOG = """\
examples:
  balance-rope duty examples/duties/day.toml
  balance-rope duty SCHEDULE.toml --repeat 3    wind the trips of the file three times

Results in --out: trips.csv, one row per trip, data.csv, where each number comes from, and duty.png; with --exposure
also exposure.csv. The file is explained in docs/reference/files.md.
exit code: 0 all trips wound to the end, 1 rope, drive or a guard stopped one, 2 wrong schedule or arguments, 130
interrupted.
"""


def add_duty(duty: argparse.ArgumentParser) -> None:
    """Add description and options of the command ``duty``."""
    describe(duty, _duty_command, _DESCRIPTION, _EPILOG)
    duty.add_argument(
        "schedule",
        type=Path,
        metavar="SCHEDULE.toml",
        help="the trips, see docs/reference/files.md",
    )
    duty.add_argument(
        "--repeat", type=int, metavar="N", help="how often they are wound, instead of the file's"
    )
    text = "also count what each place in the rope goes through: exposure.csv"
    duty.add_argument("--exposure", action="store_true", help=text)
    add_results(duty, "duty")


class _WoundDuty(NamedTuple):
    """Trips of a duty: those of earlier runs of the command, and those that were wound now."""

    trips: Recording | None  # table of all of them; None for none
    last: WoundTrip | None  # that was wound now
    warnings: Sequence[Sequence[str]]  # of each trip that was wound now


def _duty_command(options: argparse.Namespace) -> int:
    """Read the schedule, wind the trips that are left, and write and print what is found."""
    from hoist_demo.duty.schedule import read_schedule
    from hoist_demo.duty.table import READ
    from hoist_demo.report.rows import status_rows
    from hoist_demo.run.provenance import host_provenance, write_data

    schedule = read_schedule(options.schedule, options.repeat)
    if options.check:
        print(f"{options.schedule}: {schedule.count} trips; {CHECKED}; {HOIST_UNCHECKED}")
        return 0
    ropes = schedule.ropes(READ.union(STATION_SIGNALS if options.exposure else ()))
    out = results_folder(options.out or Path("out") / "duty" / options.schedule.stem)
    with interruption() as interrupted:
        wound = _wind_left(schedule, ropes, out / STATE, interrupted, options.exposure)
    trips = wound.trips
    if trips is None:
        print("balance-rope: interrupted before the first trip's end", file=sys.stderr)
        return INTERRUPTED
    exposures = _exposures(trips, ropes)
    data = [
        *host_provenance(schedule.pattern[0], schedule.status_by_name),
        *ropes.provenance(schedule.status_by_name),
    ]
    written = [*_write(trips, exposures, out), write_data(data, out / "data.csv")]
    rows = _summary(trips, wound.last, len(schedule.pattern), _warnings(schedule, ropes, wound))
    for prefix, table in exposures.items():
        rows += exposure_rows(prefix.rstrip("."), table)
    _print(schedule, trips, [*rows, *status_rows(data)], written)
    if interrupted():
        print("balance-rope: interrupted; the same command goes on", file=sys.stderr)
        return INTERRUPTED
    return _exit_code(schedule, trips, wound.last)


def _wind_left(
    schedule: Schedule, ropes: Ropes, state: Path, interrupted: Callable[[], bool], counted: bool
) -> _WoundDuty:
    """Wind the trips that are left, and save the state after each; ``counted``: with exposure."""
    from hoist_demo.duty.table import landing_warnings, place_at_rest, trip_row, trip_table
    from hoist_demo.duty.wind import read_state, wind_duty, write_state
    from hoist_demo.run.slip import slip_warnings

    cycle = len(schedule.pattern)
    rope = ropes.plant
    identities = ropes.data()
    rest = place_at_rest(schedule, rope, [one.name for one in identities])
    station = f"{identities[0].prefix}{_STATION}"
    rows: list[dict[str, float]] = []
    warnings: list[list[str]] = []
    after = last = None
    if state.is_file():
        saved_rows, after = read_state(state, rope, schedule)
        rows = saved_rows[: schedule.count]
        _require_same_columns(state, station in rows[0], counted)
        print(f"{len(rows)} of {schedule.count} trips are there already")
    with progress_bar() as bar:

        def progress(trip_number: int) -> Callable[[float, float], bool]:
            return lambda part, t: (
                bar((trip_number - 1 + part) / schedule.count, t) and not interrupted()
            )

        torque_free = {one.name: one.torque_free for one in identities}
        for trip in wind_duty(schedule, rope, torque_free, progress, after, len(rows)):
            if interrupted() and trip.result.end is None:
                break
            last = trip
            row = trip_row(trip, rest) | _exposure_columns(trip, identities)
            rows.append(row)
            slip = slip_warnings(trip.result, trip.data.hoist)
            warnings.append([*slip, *landing_warnings(row, trip.data)])
            if trip.result.end is not None:
                write_state(state, trip_table(rows, cycle), trip.result.end, rope, schedule)
    trips = None
    if rows:
        trips = trip_table(rows, cycle)
    return _WoundDuty(trips, last, warnings)


def _require_same_columns(state: Path, was_counted: bool, counted: bool) -> None:
    """Raise ValueError if the trips that are there have the load history, and those left do not."""
    if counted != was_counted:
        earlier = "without" if counted else "with"
        raise ValueError(f"'{state}' was begun {earlier} --exposure: go on so")


def _exposure_columns(trip: WoundTrip, ropes: Sequence[RopeData]) -> dict[str, float]:
    """Return the load history of each place in the ropes in one trip, as columns of its row."""
    columns: dict[str, float] = {}
    for rope in ropes:
        table = exposure(rope_signals(trip.result.recording, rope.name), rope.parameters)
        if table is not None:
            for name, value in flatten(table).items():
                columns[f"{rope.prefix}{name}"] = value
    return columns


def _exposures(trips: Recording, ropes: Ropes) -> dict[str, Recording]:
    """Return the load histories of the ropes in all trips, by the prefix of each rope's names."""
    exposures: dict[str, Recording] = {}
    for rope in ropes.data():
        table = _exposure_of_trips(trips, rope.prefix)
        if table is not None:
            exposures[rope.prefix] = table
    return exposures


def _warnings(schedule: Schedule, ropes: Ropes, wound: _WoundDuty) -> list[str]:
    """Return the warnings of a duty, each once: on its data, on its ropes, and on its trips."""
    from hoist_demo.run.data import contradictions
    from hoist_demo.uncertainty.spread import remarks_of

    warnings: list[str] = []
    if not ropes.case.distinct_ropes:
        hoist = schedule.pattern[0].hoist
        warnings.append(contradictions(hoist, ropes.data()[0].parameters))
    if wound.last is None:
        recording = _present_signals(ropes)
    else:
        recording = wound.last.result.recording
    for rope in ropes.data():
        warnings.append(remark(rope_signals(recording, rope.name)))
    for text, count in remarks_of(wound.warnings).items():
        warnings.append(f"{text} ({count} of {len(wound.warnings)} trips)")
    return [*filter(None, dict.fromkeys(warnings))]


def _print(
    schedule: Schedule, trips: Recording, rows: Sequence[SummaryRow], written: Sequence[Path]
) -> None:
    """Print the title, the rows of the summary, and the files."""
    header = schedule.header
    print(
        f"{header.title}: hoist {header.hoist}, level {schedule.level}, {trips['trip'].size} "
        "trips\n"
    )
    print(render(rows))
    print(f"\n{ASSUMED_DATA}\n")
    print("written: " + ", ".join(str(path) for path in written))


def _exit_code(schedule: Schedule, trips: Recording, last: WoundTrip | None) -> int:
    """Return 0 if all trips were wound to their end, else 1, and print why the last one was not."""
    count = trips["trip"].size
    if count == schedule.count and (last is None or last.result.end is not None):
        return 0
    cause = ""
    if last is not None:
        cause = last.result.cause or _ended(last.result).removeprefix("completed; ")
    print(f"balance-rope: the duty ends with trip {count}: {cause}", file=sys.stderr)
    return 1


def _exposure_of_trips(trips: Recording, prefix: str) -> Recording | None:
    """Return the load history of each place in a rope in all trips; None if not counted."""
    from hoist_demo.duty.wind import table_rows

    if f"{prefix}{_STATION}" not in trips:
        return None
    parts = []
    for row in table_rows(trips):
        of_rope = {
            key.removeprefix(prefix): value
            for key, value in row.items()
            if key.startswith(f"{prefix}station.")
        }
        parts.append(gather(of_rope))
    return joined_exposure(parts)


def _present_signals(ropes: Ropes) -> Recording:
    """Return a recording of one row: the ropes' present signals, masked by their fidelities."""
    names = [*ropes.plant.units()]
    values = ropes.plant.reader(names)()[:, None]
    signals = {TIME: np.zeros(1), **dict(zip(names, values, strict=True))}
    return computed(Recording(signals, {}), {rope.name: rope.torque_free for rope in ropes.data()})


def _ended(result: Result) -> str:
    """Return how a trip has ended, in words."""
    words = outcome(result.completed, result.recording)
    stopped_at = result.winding.emergency_at
    if stopped_at is None:
        return words
    return f"{words}; {circuit_stop(result.recording, stopped_at)}"


def _summary(
    trips: Recording, last: WoundTrip | None, cycle: int, warnings: Sequence[str]
) -> list[SummaryRow]:
    from hoist_demo.duty.table import STEADY, steady_from, unit_of, worst

    rows = []
    if last is not None:
        recording = last.result.recording
        rows += [
            SummaryRow(OUTCOME, "status of the last trip", _ended(last.result)),
            SummaryRow(OUTCOME, "simulated time", float(recording.time[-1]), "s"),
        ]
    rows += [SummaryRow(OUTCOME, WARNING, text) for text in warnings]
    steady = steady_from(trips, cycle)
    group = f"Steady cycle: each trip as the one {cycle} before, within {100.0 * STEADY:g} %"
    text = f"{steady}" if steady else f"none of {trips['trip'].size}"
    rows.append(SummaryRow(group, "from trip", text))
    change = float(trips["difference"][-1])
    if math.isfinite(change):
        rows.append(SummaryRow(group, "last trip's change", 100.0 * change, "%"))
    for one in worst(trips, cycle):
        value, unit = in_display_unit(one.value, unit_of(one.name))
        first, _ = in_display_unit(one.first_cycle, unit_of(one.name))
        text = f"{number(value)} {unit}".rstrip() + f" in trip {one.trip} ({number(first)})"
        rows.append(SummaryRow("Worst trip (in the first cycle, from rest)", one.name, text))
    return rows


def _write(trips: Recording, exposures: Mapping[str, Recording], out: Path) -> list[Path]:
    """Write the tables and the figure.

    ``exposures`` has the table of each rope by the prefix of its names.
    """
    from hoist_demo.report.figures import write_duty_figure

    write_csv(trips, out / "trips.csv")
    written = [out / "trips.csv", write_duty_figure(trips, out / "duty.png")]
    for prefix, table in exposures.items():
        written.append(out / f"{prefix}exposure.csv")
        write_csv(table, written[-1])
    return written
