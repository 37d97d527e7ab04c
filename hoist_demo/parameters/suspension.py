"""Suspension of a balance rope on its conveyances, and what follows from it.

A rope hangs from a point p = (x, z) of either conveyance, counted from its centre. There the
conveyance, turned by its yaw psi, moves the rope's end by its own motion and by

    p' = R(psi) p ,    v = psi' e_Y x p' ,    a = psi'' e_Y x p' - psi'^2 p' ,

and the rope's force f and moment m act on it, about its centre, as f and m + p' x f. The functions
take numbers and CasADi expressions alike.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from hoist_demo.parameters.quantity import UNBOUNDED, parameter
from rope_model.physics.elementary import cos, sin

#: Components of a point's motion across the shaft: place, velocity, acceleration.
MOVED = ("x", "z", "vx", "vz", "ax", "az")


@dataclass(frozen=True)
class SuspensionOffset:
    """Offset of a rope's suspension from the centres of the conveyances."""

    x_left: float = parameter(
        0.0,
        "m",
        "distance to the right from the left conveyance's centre to where the rope hangs",
        UNBOUNDED,
    )
    x_right: float = parameter(
        0.0,
        "m",
        "distance to the right from the right conveyance's centre to where the rope hangs",
        UNBOUNDED,
    )
    z: float = parameter(
        0.0,
        "m",
        "distance out of the conveyances' plane from their centres to where the rope hangs",
        UNBOUNDED,
    )

    @property
    def origin(self) -> tuple[float, float, float]:
        """Origin of the rope's places, x from half-way between the conveyances' centres [m]."""
        return 0.5 * (self.x_left + self.x_right), 0.0, self.z

    def end_distance(self, spacing: float) -> float:
        """Return the distance of the rope's ends [m] where conveyances are ``spacing`` apart."""
        return spacing + self.x_right - self.x_left

    def at(self, end: str) -> tuple[float, float]:
        """Return x and z of an end [m]."""
        if end == "left":
            return self.x_left, self.z
        return self.x_right, self.z


def motion_at(
    offset: tuple[Any, Any], centre: Sequence[Any], yaw: Any, yaw_rate: Any, yaw_acceleration: Any
) -> tuple[Any, ...]:
    """Return MOVED of a conveyance's point, from its nominal place.

    ``centre`` is MOVED of the conveyance's centre.
    """
    cx, cz, cvx, cvz, cax, caz = centre
    x, z = _turned(offset, yaw)
    return (
        cx + x - offset[0],
        cz + z - offset[1],
        cvx + yaw_rate * z,
        cvz - yaw_rate * x,
        cax + yaw_acceleration * z - yaw_rate**2 * x,
        caz - yaw_acceleration * x - yaw_rate**2 * z,
    )


def moment_at(offset: tuple[Any, Any], yaw: Any, force: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Return the moment of a force at a point of a conveyance, about its centre, p' x f."""
    x, z = _turned(offset, yaw)
    fx, fy, fz = force
    return -z * fy, z * fx - x * fz, x * fy


def _turned(offset: tuple[Any, Any], yaw: Any) -> tuple[Any, Any]:
    """x and z of a point of the conveyance, from its centre, where it is turned about Y."""
    x, z = offset
    return x * cos(yaw) + z * sin(yaw), z * cos(yaw) - x * sin(yaw)
