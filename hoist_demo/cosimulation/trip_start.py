"""The start of a run: at rest, or behind another trip."""

import numpy as np

from hoist_demo.cosimulation.drive_signals import DRIVE_UNITS, ROW
from hoist_demo.cosimulation.participants.hoist_partner import HoistPartner
from hoist_demo.cosimulation.run_state import RopeReaders, RunState
from hoist_demo.cosimulation.schemes import interface
from hoist_demo.cosimulation.schemes.interface import CoupledSystem, Vector
from hoist_demo.cosimulation.trip_plan import TripPlan
from hoist_demo.drive.coordinates import FORCES, INPUT_NAMES, TORQUE, TORQUE_COMMAND
from hoist_demo.drive.plant import SIDE_FORCES, HoistPlant
from hoist_demo.recording.time_series import Recorder
from rope_model import EndMotion

_GUARD_TRIPPED = "guard.tripped"
_GUARD_TIME = "guard.time"


class StartFailed(Exception):
    """The rope does not hang at the start of a run."""


def start_run(plan: TripPlan) -> RunState:
    """Return the run at rest, or behind another trip; StartFailed if the rope does not hang."""
    before = plan.before
    read = plan.rope.reader(interface.ROPE_FORCES)
    forces = _hanging_forces(plan, read) if before is None else read()
    plant = HoistPlant(plan.hoist)
    rest = plant.equilibrium(*plan.start_heights, *forces[:2].tolist())
    state = rest
    applied_input = np.zeros(len(INPUT_NAMES))
    applied_input[TORQUE_COMMAND] = rest.x[TORQUE]
    applied_input[list(FORCES)] = forces[:2]
    if before is not None:
        state = before.plant
        applied_input = before.input
    drive = HoistPartner(plant, state, applied_input, plan.clocks.drive, plan.coupling.per_step)
    coupled = CoupledSystem(drive, plan.rope, plan.clocks.rope)
    if before is not None:
        scheme_state = before.scheme_state
    else:
        scheme_state = coupled.start(plan.coupling.start)
    names = [name for name in plan.rope.units() if name not in DRIVE_UNITS]
    return RunState(
        drive=drive,
        coupled=coupled,
        scheme_state=scheme_state,
        holding_torque=rest.x.item(0),
        recorder=_recorder(plan, names),
        readers=_readers(plan, names),
        course=plan.course,
    )


def _hanging_forces(plan: TripPlan, read: interface.Reader) -> Vector:
    """Let the rope hang at rest; return its ROPE_FORCES, or raise StartFailed."""
    left, right = (EndMotion(y=height) for height in plan.start_heights)
    with plan.clocks.start:
        status = plan.rope.initialize(plan.coupling.start, left, right)
        response = interface.read_response(status, read)
    if response.forces is None:
        raise StartFailed(f"rope, at the start: {response.status.message}")
    return response.forces


def _recorder(plan: TripPlan, names: list[str]) -> Recorder:
    """Return a recorder of all signals; ``names`` are those of the rope that the drive lacks."""
    units = plan.rope.units() | DRIVE_UNITS
    return Recorder([*ROW, *names], units, plan.sample_count + 1)


def _readers(plan: TripPlan, names: list[str]) -> RopeReaders:
    """Return readers of the rope's signals; ``names`` are those that are recorded."""
    return RopeReaders(
        signals=plan.rope.reader(names),
        side_forces=plan.rope.reader(SIDE_FORCES),
        guard_tripped=names.index(_GUARD_TRIPPED) if _GUARD_TRIPPED in names else None,
        guard_time=names.index(_GUARD_TIME) if _GUARD_TIME in names else None,
    )
