"""State of a duty between two trips, in a file from which it continues with the same bits."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from hoist_demo.cosimulation.checkpoint import Checkpoint, differences
from hoist_demo.cosimulation.run_state import TripEnd
from hoist_demo.cosimulation.schemes.interface import RopePlant
from hoist_demo.duty.schedule import Schedule
from hoist_demo.recording.time_series import Recording


def write_state(path: Path, trips: Recording, end: TripEnd, rope: RopePlant, schedule: Schedule) -> None:
    """Write the state after the last row of `trips`, whole or not at all."""
    checkpoint = Checkpoint(
        sample=trips["trip"].size,
        t=end.t,
        plant=end.plant,
        controller=None,
        input=end.input,
        memory=end.memory,
        rope=rope.to_bytes(rope.save()),
        recording=trips,
        data=schedule.data,
        cause="",
    )
    part = path.with_suffix(".part")
    checkpoint.write(part)
    part.replace(path)


def read_state(path: Path, rope: RopePlant, schedule: Schedule) -> tuple[list[dict[str, float]], TripEnd]:
    """Read rows and the last trip's end, and put the rope into its state; raise ValueError for another duty's file."""
    checkpoint = Checkpoint.read(path)
    if checkpoint.data != schedule.data:
        found = differences(checkpoint.data, schedule.data)
        raise ValueError(f"'{path}' must be of this schedule, but {found}: give another --out")
    rope.restore(rope.from_bytes(checkpoint.rope))
    end = TripEnd(
        checkpoint.t, schedule.landing(checkpoint.sample), checkpoint.plant, checkpoint.input, checkpoint.memory
    )
    return rows_of(checkpoint.recording), end


def rows_of(trips: Recording) -> list[dict[str, float]]:
    """The rows of a table."""
    columns: Mapping[str, np.ndarray] = trips.signals
    return [{name: float(values[k]) for name, values in columns.items()} for k in range(trips["trip"].size)]
