"""Outputs of a drive at one instant: names, places in a vector, and quantities derived from them."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields


@dataclass(frozen=True)
class PlantOutput:
    """Outputs of the drive at one instant."""

    y_left: float  # m
    y_right: float  # m
    v_left: float  # m/s
    v_right: float  # m/s
    a_left: float  # m/s^2
    a_right: float  # m/s^2
    angle: float  # rad, of the sheave
    rate: float  # rad/s
    torque: float  # N m, of the motor
    tension_left: float  # N, all head ropes, at the sheave
    tension_right: float  # N
    energy_kinetic: float  # J
    energy_potential: float  # J
    motor_rate: float = 0.0  # rad/s
    brake_torque: float = 0.0  # N m, on the sheave, positive against positive rotation
    static_tension_left: float = 0.0  # N, at the sheave, were everything at rest here
    static_tension_right: float = 0.0  # N
    x_left: float = 0.0  # m, of the conveyance from the middle of its guides, in the plane of the loop
    vx_left: float = 0.0  # m/s
    ax_left: float = 0.0  # m/s^2
    z_left: float = 0.0  # m, out of plane
    vz_left: float = 0.0  # m/s
    az_left: float = 0.0  # m/s^2
    yaw_left: float = 0.0  # rad, about the vertical
    yaw_rate_left: float = 0.0  # rad/s
    yaw_acceleration_left: float = 0.0  # rad/s^2
    x_right: float = 0.0
    vx_right: float = 0.0
    ax_right: float = 0.0
    z_right: float = 0.0
    vz_right: float = 0.0
    az_right: float = 0.0
    yaw_right: float = 0.0
    yaw_rate_right: float = 0.0
    yaw_acceleration_right: float = 0.0
    pull_left: float = 0.0  # N, of all head ropes on the conveyance, without their inertia; never negative
    pull_right: float = 0.0  # N
    slack_left: float = 0.0  # m, of the head ropes
    slack_right: float = 0.0  # m
    jam_left: float = 0.0  # N, of a jam on the conveyance, positive against upward motion
    jam_right: float = 0.0  # N

    @property
    def tension_ratio(self) -> float:
        """Ratio of the two tensions [-]."""
        return tension_ratio(self.tension_left, self.tension_right)

    @property
    def static_tension_ratio(self) -> float:
        """Ratio of the tensions if everything were at rest here [-]."""
        return tension_ratio(self.static_tension_left, self.static_tension_right)

    @property
    def power(self) -> float:
        """Mechanical power of the motor [W]."""
        return self.torque * self.motor_rate


def tension_ratio(one: float, other: float) -> float:
    """Larger tension over smaller one (Euler-Eytelwein), infinite when a side is slack [-]."""
    low, high = (one, other) if one < other else (other, one)
    return high / low if low > 0.0 else math.inf


SHOWN = {field.name: k for k, field in enumerate(fields(PlantOutput))}
"""Places of PlantOutput's numbers."""
