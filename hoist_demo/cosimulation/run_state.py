"""State of a run: its parts, its sampling, its checkpoints, and its result."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hoist_demo.control.controller import Command
from hoist_demo.control.trajectory import Course, Trajectory
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.participants.hoist_partner import HoistPartner
from hoist_demo.cosimulation.schemes.interface import (
    CoupledSystem,
    Reader,
    SchemeState,
    Stopwatch,
    Vector,
)
from hoist_demo.drive.plant import PlantState
from hoist_demo.parameters import Winding
from hoist_demo.recording.time_series import Recorder, Recording


@dataclass(frozen=True)
class TripEnd:
    """Drive and coupling where a trip has ended, for the trip after it.

    The rope keeps its own state.
    """

    t: float  # s
    landing: float  # m, at which the left conveyance was to arrive
    plant: PlantState
    input: Vector  # that acts on the drive, in the order of INPUT_NAMES
    scheme_state: SchemeState

    def with_zeroed_totals(self) -> TripEnd:
        """Return the state with work and exchanges counted anew."""
        slip_state = self.plant.slip_state._replace(slid_distance=0.0)
        plant = self.plant._replace(
            work_totals=np.zeros_like(self.plant.work_totals), slip_state=slip_state
        )
        scheme_state = self.scheme_state._replace(exchanges=0, taken_back=0, residual=0.0)
        return replace(self, plant=plant, scheme_state=scheme_state)


@dataclass(frozen=True)
class RopeReaders:
    """Functions that read the rope at a sample, and places of its guard's signals among them."""

    signals: Reader  # signals of the record
    side_forces: Reader  # SIDE_FORCES
    guard_tripped: int | None  # place in `signals`; None for a rope without a guard
    guard_time: int | None


class SavedState(NamedTuple):
    """State of a run at a sample."""

    sample: int
    partners: tuple[Any, Any]  # snapshots of drive and rope
    controller: Any
    scheme_state: SchemeState
    emergency_at: float | None  # s after the start: emergency stop that has begun or is planned


@dataclass
class RunState:
    """States at the latest communication point, and at the latest sample that was saved."""

    drive: HoistPartner
    coupled: CoupledSystem  # drive and rope, for the scheme
    scheme_state: SchemeState
    holding_torque: float  # N m, of the motor at rest where the trip starts
    recorder: Recorder
    readers: RopeReaders
    course: Course
    controller: Any = None  # the controller's state
    #: Commands since the latest recorded communication point.
    commands: list[Command] = field(default_factory=list)
    first: int = 0  # sample from which it goes on
    steps: int = 0  # communication steps done
    saved: SavedState | None = None


@dataclass(frozen=True)
class Result:
    """Record, outcome and clocks of one run."""

    recording: Recording
    completed: bool
    cause: str  # "" when completed
    steps: int  # communication steps done
    trajectory: Trajectory
    winding: Winding  # trip as wound, with a guard's emergency stop
    drive_clock: Stopwatch  # time of the drive's steps
    rope_clock: Stopwatch  # time of the rope's steps, reading its outputs included
    start_clock: Stopwatch  # time of the rope's initialization
    warning: str = ""  # warning about the coupling's stability
    checkpoint: Checkpoint | None = None  # last saved state of a run that stopped later
    saved: Path | None = None  # file of the checkpoint
    #: Start of the next trip; None unless completed without a guard's emergency stop.
    end: TripEnd | None = None
