"""Paths of the rope's ends between two instants of the host.

Each coordinate follows a quintic polynomial in time, so that position, speed and acceleration are
continuous whatever the host's step.  boundary.input_filter determines where a path leads.  Works on
numbers and CasADi expressions:  C has its structures and formulas from here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import reduce
from typing import Any, NamedTuple

from rope_model.boundary import quintic
from rope_model.boundary.quintic import Quintic
from rope_model.parameter_table import Bounds, numeric_bounds, parameter, parameters_of
from rope_model.physics.elementary import Scalar, maximum, minimum

PATH = ("x", "y", "z", "yaw")  #: coordinates of an end's path
LEANS = ("lean", "lean_z")  #: leans of a clamp, which have paths of their own
RESTS_BELOW = 1e-6  #: m/s and rad/s, speed below which an end is at rest
# bounds of accepted motions: absolute, several times what mine hoists do (20 m/s, 5 m/s^2), to
# reveal wrong units
MAX_POSITION = 1e4  #: m and rad
MAX_SPEED = 60.0  #: m/s and rad/s
MAX_ACCELERATION = 100.0  #: m/s^2 and rad/s^2


def _motion(unit: str, description: str, reach: float) -> float:
    """Return a field of EndMotion; {side} stands for left or right."""
    return parameter(0.0, unit, description, Bounds(-reach, reach))


@dataclass(frozen=True)
class EndMotion:
    """Motion of a conveyance's suspension point; x and z from the nominal point, y the height in the shaft.

    Metres, seconds, radians; yaw about Y (up).  A clamp yaws first, then leans; as it leans on, it
    spins by yaw.
    """

    x: float = _motion(
        "m",
        "position of the {side} suspension point, in plane, from the nominal point",
        MAX_POSITION,
    )
    y: float = _motion("m", "position of the {side} suspension point, up", MAX_POSITION)
    z: float = _motion("m", "position of the {side} suspension point, out of plane", MAX_POSITION)
    vx: float = _motion("m/s", "speed of the {side} suspension point, in plane", MAX_SPEED)
    vy: float = _motion("m/s", "speed of the {side} suspension point, up", MAX_SPEED)
    vz: float = _motion("m/s", "speed of the {side} suspension point, out of plane", MAX_SPEED)
    ax: float = _motion(
        "m/s2", "acceleration of the {side} suspension point, in plane", MAX_ACCELERATION
    )
    ay: float = _motion("m/s2", "acceleration of the {side} suspension point, up", MAX_ACCELERATION)
    az: float = _motion(
        "m/s2", "acceleration of the {side} suspension point, out of plane", MAX_ACCELERATION
    )
    yaw: float = _motion("rad", "yaw of the {side} conveyance about Y", MAX_POSITION)
    yaw_rate: float = _motion("rad/s", "rate of {side}.yaw", MAX_SPEED)
    lean: float = _motion(
        "rad", "lean of the {side} end from plumb, in plane; of a clamp alone", math.pi
    )
    lean_z: float = _motion(
        "rad", "lean of the {side} end from plumb, out of plane; of a clamp alone", math.pi
    )

    def on_the_way(self, to: EndMotion, h: float, after: float) -> EndMotion:
        """Return the motion ``after`` (s) from here, on quintics to the motion ``to``, ``h`` (s) from here."""
        starts = (
            *zip(self.position, self.velocity, self.acceleration, strict=True),
            (self.yaw, self.yaw_rate, 0.0),
        )
        stops = (
            *zip(to.position, to.velocity, to.acceleration, strict=True),
            (to.yaw, to.yaw_rate, 0.0),
        )
        motions = [
            quintic.rates(quintic.coefficients(h, start, stop), after)
            for start, stop in zip(starts, stops, strict=True)
        ]
        (x, vx, ax), (y, vy, ay), (z, vz, az), (yaw, yaw_rate, _) = motions
        lean, lean_z = (
            x + after / h * (y - x) for x, y in ((self.lean, to.lean), (self.lean_z, to.lean_z))
        )
        return EndMotion(x, y, z, vx, vy, vz, ax, ay, az, yaw, yaw_rate, lean, lean_z)

    @property
    def position(self) -> tuple[float, float, float]:
        """Coordinates x, y, z, m."""
        return self.x, self.y, self.z

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Rates of x, y, z, m/s."""
        return self.vx, self.vy, self.vz

    @property
    def acceleration(self) -> tuple[float, float, float]:
        """Second rates of x, y, z, m/s^2."""
        return self.ax, self.ay, self.az


#: value, rate and acceleration of one coordinate
OfCoordinate = tuple[Any, Any, Any]
#: values of x, y, z and yaw
OfAxes = tuple[Any, Any, Any, Any]


class EndPath(NamedTuple):
    """Quintics in s = t - start for x, y, z, yaw and for the leans, which end at ``stop``."""

    start: float
    stop: float
    coefficients: tuple[Quintic, Quintic, Quintic, Quintic]
    leans: tuple[Quintic, Quintic] = ((0.0,) * 6,) * 2

    @staticmethod
    def at_rest(t: float, motion: EndMotion) -> EndPath:
        """Return a path without motion."""
        coordinates = (*motion.position, motion.yaw, motion.lean, motion.lean_z)
        x, y, z, yaw, *leans = ((x0, 0.0, 0.0, 0.0, 0.0, 0.0) for x0 in coordinates)
        return EndPath(t, t, (x, y, z, yaw), (leans[0], leans[1]))

    def at_constant_acceleration(self, t: float) -> EndPath:
        """Return the motion at ``t`` continued with its accelerations, before and after."""
        rates = (*zip(*self.motion(t), strict=True), *self.lean_motion(t))
        x, y, z, yaw, *leans = ((x, v, 0.5 * a, 0.0, 0.0, 0.0) for x, v, a in rates)
        return EndPath(t, math.inf, (x, y, z, yaw), (leans[0], leans[1]))

    def height(self, t: float) -> Scalar:
        """Return y at ``t``."""
        return quintic.value(self.coefficients[1], minimum(t, self.stop) - self.start)

    def yaw(self, t: float) -> tuple[Scalar, Scalar]:
        """Return yaw and its rate at ``t``."""
        return quintic.rates(self.coefficients[3], minimum(t, self.stop) - self.start)[:2]

    def lean_motion(self, t: float) -> tuple[OfCoordinate, OfCoordinate]:
        """Return the leans and their rates at ``t``."""
        s = minimum(t, self.stop) - self.start
        return quintic.rates(self.leans[0], s), quintic.rates(self.leans[1], s)

    def motion(self, t: float) -> tuple[OfAxes, OfAxes, OfAxes]:
        """Return position, velocity and acceleration at ``t``."""
        s = minimum(t, self.stop) - self.start
        (x, vx, ax), (y, vy, ay), (z, vz, az), (yaw, yaw_t, yaw_tt) = [
            quintic.rates(c, s) for c in self.coefficients
        ]
        return (x, y, z, yaw), (vx, vy, vz, yaw_t), (ax, ay, az, yaw_tt)

    def at(self, t: float) -> EndMotion:
        """Return the motion at ``t``."""
        (x, y, z, yaw), (vx, vy, vz, yaw_rate), (ax, ay, az, _) = self.motion(t)
        (lean, _, _), (lean_z, _, _) = self.lean_motion(t)
        return EndMotion(x, y, z, vx, vy, vz, ax, ay, az, yaw, yaw_rate, lean, lean_z)

    def peak_accelerations(self) -> tuple[Any, ...]:
        """Return the largest sampled accelerations of PATH and LEANS; NaN where the first sample is."""
        times = [fraction * (self.stop - self.start) for fraction in (0.0, 0.25, 0.5, 0.75, 1.0)]
        every = (*self.coefficients, *self.leans)
        return tuple(
            reduce(maximum, (abs(quintic.acceleration(c, s)) for s in times)) for c in every
        )


def ends_at(paths: tuple[EndPath, EndPath], t: float) -> tuple[EndMotion, EndMotion]:
    """Return the motions of both ends at ``t``."""
    return paths[0].at(t), paths[1].at(t)


#: bound of each value of EndMotion
MOTION_BOUNDS = {
    name: float(numeric_bounds(EndMotion, name)[1] or 0.0) for name in parameters_of(EndMotion)
}
