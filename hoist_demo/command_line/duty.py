"""The command `balance-rope duty`."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hoist_demo.command_line.support import (
    Commands,
    add_command,
    add_results,
    interruption,
    results_folder,
)
from hoist_demo.cosimulation.progress import progress_bar
from hoist_demo.parameters import ASSUMED_DATA
from hoist_demo.recording.exposure import STATION_SIGNALS, exposure, flatten, gather, together
from hoist_demo.recording.fidelity import remark
from hoist_demo.recording.incidents import circuit_stop
from hoist_demo.recording.ropes import computed, rope_signals
from hoist_demo.recording.time_series import TIME, Recording, write_csv
from hoist_demo.report.html.page import number
from hoist_demo.report.rows import OUTCOME, WARNING, SummaryRow, in_display_unit, render
from hoist_demo.report.summary import exposure_rows
from hoist_demo.report.verdict import outcome

if TYPE_CHECKING:
    from hoist_demo.cosimulation.run_state import Result
    from hoist_demo.duty.schedule import Schedule
    from hoist_demo.duty.wind import WoundTrip
    from hoist_demo.ropes.definition import Ropes

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


def add_duty(commands: Commands) -> None:
    """Add the subcommand `duty`."""
    text = "wind many trips as one run, each from where the last has left the rope"
    duty = add_command(commands, "duty", _duty, text, _DESCRIPTION, _EPILOG)
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


def _duty(options: argparse.Namespace) -> int:
    from hoist_demo.duty.schedule import read_schedule
    from hoist_demo.duty.table import READ
    from hoist_demo.report.rows import status_rows
    from hoist_demo.study.provenance import host_provenance, write_data
    from hoist_demo.study.run import contradictions
    from hoist_demo.uncertainty.spread import remarks_of

    schedule = read_schedule(options.schedule, options.repeat)
    if options.check:
        print(f"{options.schedule}: {schedule.count} trips, nothing wrong")
        return 0
    read = READ.union(STATION_SIGNALS if options.exposure else ())
    ropes = schedule.ropes(read)
    out = results_folder(options.out or Path("out") / "duty" / options.schedule.stem)
    with interruption() as interrupted:
        trips, last, of_trips = _wind(schedule, ropes, out / STATE, interrupted, options.exposure)
    if trips is None:
        print("balance-rope: interrupted before the first trip's end", file=sys.stderr)
        return 130
    exposed = {
        rope.prefix: table
        for rope in ropes.data()
        if (table := _exposed(trips, rope.prefix)) is not None
    }
    run, status, header = schedule.pattern[0], schedule.status_by_name, schedule.header
    data = [*host_provenance(run, status), *ropes.provenance(status)]
    written = [*_write(trips, exposed, out), write_data(data, out / "data.csv")]
    print(
        f"{header.title}: hoist {header.hoist}, level {schedule.level}, {trips['trip'].size} "
        "trips\n"
    )
    exposures = [
        row for prefix, table in exposed.items() for row in exposure_rows(prefix.rstrip("."), table)
    ]
    recording = _as_it_is(ropes) if last is None else last.result.recording
    remarks = [remark(rope_signals(recording, rope.name)) for rope in ropes.data()]
    counted = (
        f"{text} ({count} of {len(of_trips)} trips)" for text, count in remarks_of(of_trips).items()
    )
    drives = (
        ()
        if ropes.case.distinct_ropes
        else (contradictions(run.hoist, ropes.data()[0].parameters),)
    )
    warned = [*filter(None, dict.fromkeys((*drives, *remarks, *counted)))]
    print(
        render(
            [*_summary(trips, last, len(schedule.pattern), warned), *exposures, *status_rows(data)]
        )
    )
    print(f"\n{ASSUMED_DATA}\n")
    print("written: " + ", ".join(str(path) for path in written))
    if interrupted():
        print("balance-rope: interrupted; the same command goes on", file=sys.stderr)
        return 130
    if trips["trip"].size < schedule.count or (last is not None and last.result.end is None):
        cause = (
            ""
            if last is None
            else last.result.cause or _ended(last.result).removeprefix("completed; ")
        )
        print(
            f"balance-rope: the duty ends with trip {trips['trip'].size}: {cause}", file=sys.stderr
        )
        return 1
    return 0


def _wind(
    schedule: Schedule, ropes: Ropes, state: Path, interrupted: Callable[[], bool], counted: bool
) -> tuple[Recording | None, WoundTrip | None, list[list[str]]]:
    """Wind those left.

    Return the table of all trips, None for none, the last wound here, and warnings.
    """
    from hoist_demo.duty.table import landing_warnings, place_at_rest, trip_row, trip_table
    from hoist_demo.duty.wind import read_state, wind_duty, write_state
    from hoist_demo.study.slip import slip_warnings

    cycle = len(schedule.pattern)
    rope, identities = ropes.plant, ropes.data()
    rest = place_at_rest(schedule, rope, [one.name for one in identities])
    station = f"{identities[0].prefix}{_STATION}"
    rows, warned = list[dict[str, float]](), list[list[str]]()
    after = last = None
    if state.is_file():
        saved_rows, after = read_state(state, rope, schedule)
        rows = saved_rows[: schedule.count]
        if counted != (station in rows[0]):
            raise ValueError(
                f"'{state}' was begun {'without' if counted else 'with'} --exposure: go on so"
            )
        print(f"{len(rows)} of {schedule.count} trips are there already")
    with progress_bar() as bar:

        def progress(number: int) -> Callable[[float, float], bool]:
            return lambda part, t: (
                bar((number - 1 + part) / schedule.count, t) and not interrupted()
            )

        torque_free = {one.name: one.torque_free for one in identities}
        for trip in wind_duty(schedule, rope, torque_free, progress, after, len(rows)):
            if interrupted() and trip.result.end is None:
                break
            last = trip
            row = trip_row(trip, rest)
            for one in identities:
                if (
                    exposed := exposure(
                        rope_signals(trip.result.recording, one.name), one.parameters
                    )
                ) is not None:
                    row |= {
                        f"{one.prefix}{name}": value for name, value in flatten(exposed).items()
                    }
            rows.append(row)
            warned.append(
                [
                    *slip_warnings(trip.result, trip.data.hoist),
                    *landing_warnings(rows[-1], trip.data),
                ]
            )
            if trip.result.end is not None:
                write_state(state, trip_table(rows, cycle), trip.result.end, rope, schedule)
    return (trip_table(rows, cycle) if rows else None), last, warned


def _exposed(trips: Recording, prefix: str) -> Recording | None:
    """Return what each place in a rope went through in all trips; None if it was not counted."""
    from hoist_demo.duty.wind import table_rows

    if f"{prefix}{_STATION}" not in trips:
        return None
    own = [
        {
            key.removeprefix(prefix): value
            for key, value in row.items()
            if key.startswith(f"{prefix}station.")
        }
        for row in table_rows(trips)
    ]
    return together([gather(row) for row in own])


def _as_it_is(ropes: Ropes) -> Recording:
    """Return a recording of one row: the ropes' present signals, masked by their fidelities."""
    names = [*ropes.plant.units()]
    signals = {
        TIME: np.zeros(1),
        **dict(zip(names, ropes.plant.reader(names)()[:, None], strict=True)),
    }
    return computed(Recording(signals, {}), {rope.name: rope.torque_free for rope in ropes.data()})


def _ended(result: Result) -> str:
    """Return how a trip has ended, in words."""
    words, at = outcome(result.completed, result.recording), result.winding.emergency_at
    return words if at is None else f"{words}; {circuit_stop(result.recording, at)}"


def _summary(
    trips: Recording, last: WoundTrip | None, cycle: int, warned: Sequence[str]
) -> list[SummaryRow]:
    from hoist_demo.duty.table import STEADY, steady_from, unit_of, worst

    rows = []
    if last is not None:
        recording = last.result.recording
        rows += [
            SummaryRow(OUTCOME, "status of the last trip", _ended(last.result)),
            SummaryRow(OUTCOME, "simulated time", float(recording.time[-1]), "s"),
        ]
    rows += [SummaryRow(OUTCOME, WARNING, text) for text in warned]
    steady, count = steady_from(trips, cycle), trips["trip"].size
    group = f"Steady cycle: each trip as the one {cycle} before, within {100.0 * STEADY:g} %"
    rows.append(SummaryRow(group, "from trip", f"{steady}" if steady else f"none of {count}"))
    if math.isfinite(change := float(trips["difference"][-1])):
        rows.append(SummaryRow(group, "last trip's change", 100.0 * change, "%"))
    for one in worst(trips, cycle):
        (value, unit), (first, _) = (
            in_display_unit(x, unit_of(one.name)) for x in (one.value, one.first_cycle)
        )
        text = f"{number(value)} {unit}".rstrip() + f" in trip {one.trip} ({number(first)})"
        rows.append(SummaryRow("Worst trip (in the first cycle, from rest)", one.name, text))
    return rows


def _write(trips: Recording, exposed: Mapping[str, Recording], out: Path) -> list[Path]:
    """Write the tables and the figure.

    `exposed` has the table of each rope by the prefix of its names.
    """
    from hoist_demo.report.figures import write_duty_figure

    write_csv(trips, out / "trips.csv")
    written = [out / "trips.csv", write_duty_figure(trips, out / "duty.png")]
    for prefix, table in exposed.items():
        written.append(out / f"{prefix}exposure.csv")
        write_csv(table, written[-1])
    return written
