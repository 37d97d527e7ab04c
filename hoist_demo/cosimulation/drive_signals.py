"""Record of drive and exchange at each sample: names, units and values.

A row keeps the numbers as they come; signals that follow from them are computed once, for all rows,
when the run has ended.
"""

from itertools import product

from hoist_demo.control.controller import Command
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.cosimulation.participants.hoist_partner import HoistPartner
from hoist_demo.cosimulation.schemes.interface import SchemeState
from hoist_demo.drive.coordinates import LOSS_NAMES, WORK_NAMES
from hoist_demo.drive.outputs import OUTPUT_INDEX, tension_ratio
from hoist_demo.parameters import SIDES, Hoist
from hoist_demo.recording.time_series import TIME, Recording

_REFERENCE = {"position": "m", "speed": "m/s", "acceleration": "m/s2", "jerk": "m/s3"}
_MOTION = {"y": "m", "vy": "m/s", "ay": "m/s2"}
_LEGS = {"pull": "N", "slack": "m", "jam": "N"}  #: Numbers of each side, by name.
DRIVE_UNITS = {
    TIME: "s",
    **{f"reference.{name}": unit for name, unit in _REFERENCE.items()},
    **{f"conveyance.{side}.{name}": _MOTION[name] for side, name in product(SIDES, _MOTION)},
    "drive.angle": "rad",
    "drive.rate": "rad/s",
    "drive.torque_command": "N.m",
    "drive.torque": "N.m",
    "drive.torque_limited": "1",
    "drive.motor_power": "W",
    "drive.brake_torque": "N.m",
    **{f"drive.tension_{side}": "N" for side in SIDES},
    "drive.tension_ratio": "1",
    "drive.static_tension_ratio": "1",
    "drive.slip_safety": "1",
    "drive.slip": "m",
    "drive.slip_speed": "m/s",
    **{f"drive.{name}_{side}": _LEGS[name] for name, side in product(_LEGS, SIDES)},
    "drive.work_motor": "J",
    "drive.work_losses": "J",
    "drive.work_slip": "J",
    "drive.work_rope_damping": "J",
    "drive.work_from_balance_rope": "J",
    "drive.energy_kinetic": "J",
    "drive.energy_potential": "J",
    "drive.energy_residual": "J",
    "coupling.energy": "J",
    "coupling.exchanges": "1",
}

_MOTION_NAMES = {"y": "y", "v": "vy", "a": "ay"}  #: Of a conveyance, by its name in OUTPUTS.
_SIDE_OUTPUTS = ("tension", "pull", "slack", "jam")
_OTHER_OUTPUTS = (
    "angle",
    "rate",
    "torque",
    "brake_torque",
    "energy_kinetic",
    "energy_potential",
)
#: Signals that are numbers of OUTPUTS, by the names there.
_SIGNAL_OF_OUTPUT = {
    **{
        f"{name}_{side}": f"conveyance.{side}.{_MOTION_NAMES[name]}"
        for side, name in product(SIDES, _MOTION_NAMES)
    },
    **{f"{name}_{side}": f"drive.{name}_{side}" for side, name in product(SIDES, _SIDE_OUTPUTS)},
    **{name: f"drive.{name}" for name in _OTHER_OUTPUTS},
}
#: Before the names of a row's columns that are no signals; checkpoints have them.
_INTERNAL = "beside."
OUTPUT_COLUMNS = tuple(_SIGNAL_OF_OUTPUT.get(name, _INTERNAL + name) for name in OUTPUT_INDEX)
WORK_COLUMNS = (
    *(f"{_INTERNAL}work_{name}" for name in WORK_NAMES),
    *(f"{_INTERNAL}losses_{name}" for name in LOSS_NAMES),
)
#: Columns of the drive's record at a sample.
ROW = (
    TIME,
    *(f"reference.{name}" for name in _REFERENCE),
    "drive.torque_command",
    "drive.torque_limited",
    "drive.slip",
    "drive.slip_speed",
    "coupling.energy",
    "coupling.exchanges",
    *OUTPUT_COLUMNS,
    *WORK_COLUMNS,
)


def numbers_of_exchange(
    t: float,
    reference: TrajectoryPoint,
    command: Command,
    drive: HoistPartner,
    scheme_state: SchemeState,
) -> tuple[float, ...]:
    """Return the numbers of control, slip and exchange in a row, those of ROW before OUTPUT_COLUMNS."""
    slip_state = drive.state.slip_state
    return (
        t,
        reference.position,
        reference.speed,
        reference.acceleration,
        reference.jerk,
        command.torque,
        command.limited,
        slip_state.slid_distance,
        slip_state.speed,
        scheme_state.residual,
        scheme_state.exchanges,
    )


def with_drive_signals(rows: Recording, hoist: Hoist) -> Recording:
    """Compute DRIVE_UNITS from a table of ROW, and pass on the rope's signals."""
    recorded = rows.signals
    motor, losses, ropes, left, right = (recorded[f"{_INTERNAL}work_{name}"] for name in WORK_NAMES)
    ratio = tension_ratio(recorded["drive.tension_left"], recorded["drive.tension_right"])
    kinetic = recorded["drive.energy_kinetic"]
    potential = recorded["drive.energy_potential"]
    gained = kinetic + potential - kinetic[:1] - potential[:1]
    computed = {
        "drive.motor_power": recorded["drive.torque"] * recorded[f"{_INTERNAL}motor_rate"],
        "drive.tension_ratio": ratio,
        "drive.static_tension_ratio": tension_ratio(
            recorded[f"{_INTERNAL}static_tension_left"],
            recorded[f"{_INTERNAL}static_tension_right"],
        ),
        "drive.slip_safety": hoist.slip_safety(ratio),
        "drive.work_motor": motor,
        "drive.work_losses": losses,
        "drive.work_slip": recorded[f"{_INTERNAL}losses_lining"],
        "drive.work_rope_damping": ropes,
        "drive.work_from_balance_rope": left + right,
        "drive.energy_residual": motor + left + right - losses - ropes - gained,
    }
    available = {**recorded, **computed}
    drive = {name: available[name] for name in DRIVE_UNITS}
    rope = {name: values for name, values in recorded.items() if name not in ROW}
    signals = drive | rope
    units = {**rows.units, **DRIVE_UNITS}
    return Recording(signals, {name: units[name] for name in signals})
