"""What is recorded of drive and exchange at each sample: names, units and values."""

from __future__ import annotations

from operator import itemgetter

from hoist_demo.control.controller import Command
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.cosimulation.participants.partners import HoistParticipant
from hoist_demo.cosimulation.schemes.interface import Memory
from hoist_demo.drive.equations import LOSS_NAMES
from hoist_demo.drive.outputs import SHOWN, PlantOutput, tension_ratio
from hoist_demo.parameters import Hoist
from hoist_demo.recording.time_series import TIME, Array, Recording

DRIVE_UNITS = {
    TIME: "s",
    "reference.position": "m",
    "reference.speed": "m/s",
    "reference.acceleration": "m/s2",
    "reference.jerk": "m/s3",
    "conveyance.left.y": "m",
    "conveyance.left.vy": "m/s",
    "conveyance.left.ay": "m/s2",
    "conveyance.right.y": "m",
    "conveyance.right.vy": "m/s",
    "conveyance.right.ay": "m/s2",
    "drive.angle": "rad",
    "drive.rate": "rad/s",
    "drive.torque_command": "N.m",
    "drive.torque": "N.m",
    "drive.torque_limited": "1",
    "drive.motor_power": "W",
    "drive.brake_torque": "N.m",
    "drive.tension_left": "N",
    "drive.tension_right": "N",
    "drive.tension_ratio": "1",
    "drive.slip_safety": "1",
    "drive.slip": "m",
    "drive.slip_speed": "m/s",
    "drive.pull_left": "N",
    "drive.pull_right": "N",
    "drive.slack_left": "m",
    "drive.slack_right": "m",
    "drive.jam_left": "N",
    "drive.jam_right": "N",
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


def drive_signals(
    t: float,
    reference: TrajectoryPoint,
    command: Command,
    drive: HoistParticipant,
    at_rest: PlantOutput,
    memory: Memory,
) -> list[float]:
    """The drive's part of a row, in the order of DRIVE_UNITS; `at_rest` is what it showed at the start."""
    shown = drive.outputs.tolist()
    motor, losses, ropes, left, right = drive.state.work.tolist()
    tensions, torque = (shown[_LEFT], shown[_RIGHT]), shown[_TORQUE]
    ratio = tension_ratio(*tensions)
    gained = shown[_KINETIC] + shown[_POTENTIAL] - at_rest.energy_kinetic - at_rest.energy_potential
    return [
        t,
        reference.position,
        reference.speed,
        reference.acceleration,
        reference.jerk,
        *_motion_of(shown),
        command.torque,
        torque,
        float(command.limited),
        torque * shown[_MOTOR_RATE],
        shown[_BRAKE],
        *tensions,
        ratio,
        drive.plant.hoist.slip_safety(ratio),
        drive.state.slide.way,
        drive.state.slide.speed,
        *shown[_HEAD_ROPES],
        motor,
        losses,
        drive.state.losses.item(_LINING),
        ropes,
        left + right,
        shown[_KINETIC],
        shown[_POTENTIAL],
        motor + left + right - losses - ropes - gained,
        memory.residual,
        float(memory.exchanges),
    ]


_MOTION = [f"{name}_{side}" for side in ("left", "right") for name in "yva"]
_motion_of = itemgetter(*(SHOWN[name] for name in (*_MOTION, "angle", "rate")))
_LINING = LOSS_NAMES.index("lining")
_HEAD_ROPES = slice(SHOWN["pull_left"], SHOWN["jam_right"] + 1)
_TORQUE, _MOTOR_RATE, _BRAKE, _LEFT, _RIGHT, _KINETIC, _POTENTIAL = (
    SHOWN[name]
    for name in (
        "torque",
        "motor_rate",
        "brake_torque",
        "tension_left",
        "tension_right",
        "energy_kinetic",
        "energy_potential",
    )
)


def exchange_energy(recording: Recording, hoist: Hoist) -> Array:
    """Energy that the exchange has made up since the start [J]: work on the hoist and on all its balance ropes."""
    ends = recording["energy.work_ends"] - recording["energy.work_ends"][0]
    total: Array = recording["drive.work_from_balance_rope"] + hoist.tail_rope_number * ends
    return total
