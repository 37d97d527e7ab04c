"""Trips in order: rope and drive go on from the state at the end of the trip before.

Yaw, swing, swivel angles and all that moves are carried over, nothing is laid to rest; the
controller begins each trip anew, with the torque that holds the hoist and its present payload.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.host import Progress
from hoist_demo.cosimulation.participants.identity import differences
from hoist_demo.cosimulation.run_state import Result, TripEnd
from hoist_demo.cosimulation.schemes.interface import RopePlant
from hoist_demo.cosimulation.trip_plan import NeighbouringTrips
from hoist_demo.design.controllers import design_drive
from hoist_demo.duty.schedule import HEIGHT_ROUNDING, Schedule
from hoist_demo.recording.incidents import guard_trip, jams
from hoist_demo.recording.ropes import computed
from hoist_demo.recording.time_series import Recording
from hoist_demo.run.data import RunData
from hoist_demo.run.wind import wind_run


@dataclass(frozen=True)
class WoundTrip:
    """Trip of a duty that was wound, with its result."""

    number: int  # 1 for the first
    data: RunData
    result: Result


def wind_duty(
    schedule: Schedule,
    rope: RopePlant,
    torque_free: Mapping[str, bool],
    progress: Callable[[int], Progress] | None = None,
    after: TripEnd | None = None,
    done: int = 0,
) -> Iterator[WoundTrip]:
    """Wind the trips after the first ``done``, from the drive and coupling of ``after``.

    The rope begins as it is.

    ``torque_free`` says of each rope by its name whether it carries no torque; ``progress`` gives
    each trip whom to tell. The last trip is one that does not end, or in which the safety circuit
    opens or a conveyance jams, where there is such a one.
    """
    drives = [design_drive(run) for run in schedule.pattern]
    closed = abs(schedule.landing(len(drives)) - schedule.landing(0)) < HEIGHT_ROUNDING
    for number in range(done + 1, schedule.count + 1):
        run = schedule.trip(number)
        is_designed = closed or number <= len(drives)
        if is_designed:
            drive = drives[(number - 1) % len(drives)]
        else:
            drive = design_drive(run)
        result = wind_run(
            run,
            rope,
            progress=None if progress is None else progress(number),
            drive=drive,
            neighbours=NeighbouringTrips(after, schedule.trip(number + 1).hoist),
        )
        if guard_trip(result.recording) is not None or jams(result.recording):
            # a hoist with an open safety circuit does not start again
            result = replace(result, end=None)
        result = replace(result, recording=computed(result.recording, torque_free))
        yield WoundTrip(number, run, result)
        after = result.end
        if after is None:
            return


def write_state(
    path: Path, trips: Recording, end: TripEnd, rope: RopePlant, schedule: Schedule
) -> None:
    """Write the state after the last row of ``trips``, whole or not at all."""
    checkpoint = Checkpoint(
        sample=trips["trip"].size,
        t=end.t,
        plant=end.plant,
        controller=None,
        input=end.input,
        scheme_state=end.scheme_state,
        rope=rope.to_bytes(rope.save()),
        recording=trips,
        identity=schedule.identity,
        cause="",
    )
    checkpoint.write(path)


def read_state(
    path: Path, rope: RopePlant, schedule: Schedule
) -> tuple[list[dict[str, float]], TripEnd]:
    """Read rows and the last trip's end, and put the rope into its state.

    Raise ValueError for another duty's file.
    """
    try:
        last = Checkpoint.read(path)
    except ValueError as error:
        raise ValueError(
            f"{error}; or delete {path}: the trips are then wound again from the first"
        ) from error
    changes = differences(last.identity, schedule.identity)
    if changes:
        raise ValueError(f"'{path}' must be of this schedule, but {changes}: give another --out")
    try:
        rope.restore(rope.from_bytes(last.rope))
    except ValueError as error:
        raise ValueError(
            f"'{path}' must have the rope's state, but: {error}; delete it: the trips are then "
            "wound again from the first"
        ) from error
    end = TripEnd(last.t, schedule.landing(last.sample), last.plant, last.input, last.scheme_state)
    return table_rows(last.recording), end


def table_rows(trips: Recording) -> list[dict[str, float]]:
    """Return the rows of a table of trips."""
    rows = []
    for k in range(trips["trip"].size):
        rows.append({name: float(values[k]) for name, values in trips.signals.items()})
    return rows
