"""Motion of one end of a balance rope, as the drive gives it."""

from __future__ import annotations

from typing import NamedTuple


class EndMotion(NamedTuple):
    """Motion of one suspension: x, z from the nominal hanging point, y the height in the shaft."""

    x: float = 0.0  # m
    y: float = 0.0  # m
    z: float = 0.0  # m
    vx: float = 0.0  # m/s
    vy: float = 0.0  # m/s
    vz: float = 0.0  # m/s
    ax: float = 0.0  # m/s^2
    ay: float = 0.0  # m/s^2
    az: float = 0.0  # m/s^2
    yaw: float = 0.0  # rad
    yaw_rate: float = 0.0  # rad/s
