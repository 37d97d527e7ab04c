"""What is recorded of drive and exchange at each sample: names, units and values."""

from __future__ import annotations

from hoist_demo.control.controller import Command
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.cosimulation.participants.partners import HoistParticipant
from hoist_demo.cosimulation.schemes.interface import Memory
from hoist_demo.drive.plant import PlantOutput, energy_residual
from hoist_demo.recording.time_series import TIME

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
    "drive.work_motor": "J",
    "drive.work_losses": "J",
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
) -> dict[str, float]:
    """The drive's part of a row; `at_rest` is what it showed at the start."""
    shown, work = drive.output(), drive.state.work
    motor, losses, ropes, left, right = (float(value) for value in work)
    values = (
        t,
        reference.position,
        reference.speed,
        reference.acceleration,
        reference.jerk,
        shown.y_left,
        shown.v_left,
        shown.a_left,
        shown.y_right,
        shown.v_right,
        shown.a_right,
        shown.angle,
        shown.rate,
        command.torque,
        shown.torque,
        float(command.limited),
        shown.power,
        shown.brake_torque,
        shown.tension_left,
        shown.tension_right,
        shown.tension_ratio,
        drive.plant.hoist.slip_safety(shown.tension_ratio),
        motor,
        losses,
        ropes,
        left + right,
        shown.energy_kinetic,
        shown.energy_potential,
        energy_residual(at_rest, shown, work),
        memory.residual,
        float(memory.exchanges),
    )
    return dict(zip(DRIVE_UNITS, values, strict=True))
