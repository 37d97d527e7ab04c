"""State of a run: its parts, its sampling, its checkpoints, and what comes of it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from hoist_demo.control.controller import Command
from hoist_demo.control.trajectory import Course, Trajectory
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.participants.hoist_partner import HoistPartner
from hoist_demo.cosimulation.schemes.interface import CoupledSystem, SchemeState, Stopwatch, Vector
from hoist_demo.drive.plant import PlantState
from hoist_demo.parameters import Winding
from hoist_demo.recording.time_series import Recorder, Recording


@dataclass(frozen=True)
class TripEnd:
    """Drive and coupling where a trip has ended, for the trip after it; the rope keeps its own state."""

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


@dataclass
class RunState:
    """States at the latest communication point, and at the latest sample that was saved."""

    drive: HoistPartner
    coupled: CoupledSystem  # drive and rope, for the scheme
    scheme_state: SchemeState
    holding_torque: float  # N m, of the motor at rest where the trip starts
    recorder: Recorder
    course: Course
    controller: Any = None  # the controller's state
    commands: list[Command] = field(
        default_factory=list
    )  # commands since the latest recorded communication point
    first: int = 0  # sample from which it goes on
    steps: int = 0  # communication steps done
    #: latest sample that is kept, states of drive and rope, the controller's, the scheme's
    saved: tuple[int, tuple[Any, Any], Any, SchemeState] | None = None


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
    checkpoint: Checkpoint | None = (
        None  # the last state that was kept, when the run stopped after its first sample
    )
    saved: Path | None = None  # file of the checkpoint
    end: TripEnd | None = (
        None  # start of the next trip, when completed without a guard's emergency stop
    )
