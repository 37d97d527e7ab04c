"""Result of a run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from hoist_demo.control.trajectory import Trajectory
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.run_state import TripEnd
from hoist_demo.cosimulation.schemes.interface import Stopwatch
from hoist_demo.parameters import Winding
from hoist_demo.recording.time_series import Recording


@dataclass(frozen=True)
class Result:
    """Record, outcome and clocks of one run."""

    recording: Recording
    completed: bool
    cause: str  # "" when completed
    steps: int  # communication steps done
    trajectory: Trajectory
    winding: Winding  # with the emergency stop that a guard of the rope asked for
    drive_clock: Stopwatch  # of the drive's steps
    rope_clock: Stopwatch  # of the rope's steps, reading its outputs included
    start_clock: Stopwatch  # of the rope's initialization
    warning: str = ""  # of the coupling, before the start
    checkpoint: Checkpoint | None = None  # the last state that was kept, when the run stopped after its first sample
    saved: Path | None = None  # where it was written
    end: TripEnd | None = None  # for the trip after this one, when completed without an emergency stop by a guard
