"""How the conveyances move the rope's ends.

Between two instants of the host each coordinate follows a quintic polynomial in time, so that position, speed and
acceleration are continuous whatever the host's step.  Where the last path ended beside the motion that the host now
gives (its extrapolation was wrong by j H^3 / 6 at a jerk j), a step h much shorter than the H before must not make that
good within h: that would take j H^3 / h^2.  So a path is aimed ahead by the time in which a small jerk would miss as
much, at most ``within`` seconds, and left where the step ends.  A path that misses nothing is aimed at its step's end.
Works on numbers and CasADi expressions: C has its structures and formulas from here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import chain
from typing import Any, NamedTuple

from ..numerics import quintic
from ..numerics.program import Program
from ..parameter_table import numeric_bounds, parameter, parameters_of
from ..physics.elementary import larger, smaller, sqrt, where

SIDES = ("left", "right")
#: columns of an end's path
PATH = ("x", "y", "z", "yaw")
#: s: positions of 1e4 m are rounded by 2e-12 m; made good in this time that takes some .1 m/s^2, in 1e-8 s 1e5 m/s^2
SHORTEST_AIM = 1e-5
#: m/s^3 and rad/s^3: what the motion misses is made good at such a jerk, or at the one that made it miss
LEAST_JERK = 0.1
#: steps that differ by less than this part of themselves are alike
ALIKE = 1e-6

#: m/s and rad/s: an end that moves no faster is at rest
RESTS_BELOW = 1e-6

#: m and rad, m/s and rad/s, m/s^2 and rad/s^2: motions beyond are refused
FARTHEST, FASTEST, HARDEST = 1e4, 60.0, 100.0


def _motion(unit: str, description: str, reach: float) -> float:
    """A field of EndMotion; {side} stands for left or right."""
    return parameter(0.0, unit, description, lower=-reach, upper=reach)


@dataclass(frozen=True)
class EndMotion:
    """Motion of a conveyance's suspension point; x and z from the nominal point, y the height in the shaft.

    Metres, seconds, radians; yaw about Y (up).
    """

    x: float = _motion("m", "position of the {side} suspension point, in plane, from the nominal point", FARTHEST)
    y: float = _motion("m", "position of the {side} suspension point, up", FARTHEST)
    z: float = _motion("m", "position of the {side} suspension point, out of plane", FARTHEST)
    vx: float = _motion("m/s", "speed of the {side} suspension point, in plane", FASTEST)
    vy: float = _motion("m/s", "speed of the {side} suspension point, up", FASTEST)
    vz: float = _motion("m/s", "speed of the {side} suspension point, out of plane", FASTEST)
    ax: float = _motion("m/s2", "acceleration of the {side} suspension point, in plane", HARDEST)
    ay: float = _motion("m/s2", "acceleration of the {side} suspension point, up", HARDEST)
    az: float = _motion("m/s2", "acceleration of the {side} suspension point, out of plane", HARDEST)
    yaw: float = _motion("rad", "yaw of the {side} conveyance about Y", FARTHEST)
    yaw_rate: float = _motion("rad/s", "rate of {side}.yaw", FASTEST)

    def extrapolate(self, h: float) -> EndMotion:
        """The motion ``h`` seconds later if the accelerations stay as they are."""
        x, vx = quintic.extrapolate(self.x, self.vx, self.ax, h)
        y, vy = quintic.extrapolate(self.y, self.vy, self.ay, h)
        z, vz = quintic.extrapolate(self.z, self.vz, self.az, h)
        return EndMotion(x, y, z, vx, vy, vz, *self.acceleration, self.yaw + self.yaw_rate * h, self.yaw_rate)

    def on_the_way(self, to: EndMotion, h: float, after: float) -> EndMotion:
        """The motion ``after`` so many seconds, on quintics to a motion ``h`` seconds later."""
        starts = *zip(self.position, self.velocity, self.acceleration, strict=True), (self.yaw, self.yaw_rate, 0.0)
        stops = *zip(to.position, to.velocity, to.acceleration, strict=True), (to.yaw, to.yaw_rate, 0.0)
        motions = [
            quintic.rates(quintic.coefficients(h, *start, *stop), after)
            for start, stop in zip(starts, stops, strict=True)
        ]
        (x, vx, ax), (y, vy, ay), (z, vz, az), (yaw, yaw_rate, _) = motions
        return EndMotion(x, y, z, vx, vy, vz, ax, ay, az, yaw, yaw_rate)

    @property
    def position(self) -> tuple[float, float, float]:
        """x, y, z, m."""
        return self.x, self.y, self.z

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Rates of x, y, z, m/s."""
        return self.vx, self.vy, self.vz

    @property
    def acceleration(self) -> tuple[float, float, float]:
        """Second rates of x, y, z, m/s^2."""
        return self.ax, self.ay, self.az


def missing_time(x: Any, v: Any) -> Any:
    """s: extrapolated for so long, a motion of LEAST_JERK is missed by ``x`` (m) or by ``v`` (m/s).

    At least SHORTEST_AIM: rounding may hide what is missed.
    """
    time = larger((6.0 * abs(x) / LEAST_JERK) ** (1.0 / 3.0), sqrt(2.0 * abs(v) / LEAST_JERK))
    return larger(time, SHORTEST_AIM)


#: coefficients of 1, s, s^2 ... of one coordinate
Quintic = tuple[float, float, float, float, float, float]
#: of x, y, z and yaw
OfAxes = tuple[Any, Any, Any, Any]


class EndPath(NamedTuple):
    """A quintic in s = t - start for each of x, y, z and yaw, aimed at ``aim``; left, and held, at ``stop``."""

    start: float
    stop: float
    aim: float
    coefficients: tuple[Quintic, Quintic, Quintic, Quintic]

    @staticmethod
    def at_rest(t: float, at: EndMotion) -> EndPath:
        """No motion at all."""
        x, y, z, yaw = ((place, 0.0, 0.0, 0.0, 0.0, 0.0) for place in (*at.position, at.yaw))
        return EndPath(t, t, t, (x, y, z, yaw))

    def to(self, stop: float, target: EndMotion, within: float = 0.0) -> EndPath:
        """The path from this one's end to the motion that has ``target`` at ``stop``.

        It joins that motion at ``stop``, or later where this path's end misses it: at most ``within`` s from here or
        where this path was aimed.  Until then the motion goes on with the target's accelerations.
        """
        start, step = self.stop, stop - self.stop
        now = self.motion(start)
        missing = _missing_time(now, target.extrapolate(-step))
        h = larger(step, smaller(missing, larger(self.aim - start, within)))
        h = where(h <= step * (1.0 + ALIKE), step, h)
        target = target.extrapolate(h - step)
        # FMI gives no yaw acceleration: take the mean over the step
        then = (*target.position, target.yaw), (*target.velocity, target.yaw_rate), target.acceleration
        accelerations = (*then[2], (target.yaw_rate - now[1][3]) / h)
        x, y, z, yaw = (quintic.coefficients(h, *axis) for axis in zip(*now, *then[:2], accelerations, strict=True))
        return EndPath(start, stop, start + h, (x, y, z, yaw))

    def at_constant_acceleration(self, t: float) -> EndPath:
        """The motion at ``t`` with its accelerations kept, before and after."""
        x, y, z, yaw = ((x, v, 0.5 * a, 0.0, 0.0, 0.0) for x, v, a in zip(*self.motion(t), strict=True))
        return EndPath(t, math.inf, math.inf, (x, y, z, yaw))

    def height(self, t: float) -> Any:
        """y at ``t``."""
        return quintic.value(self.coefficients[1], smaller(t, self.stop) - self.start)

    def yaw(self, t: float) -> tuple[Any, Any]:
        """Yaw and its rate at ``t``."""
        return quintic.rates(self.coefficients[3], smaller(t, self.stop) - self.start)[:2]

    def motion(self, t: float) -> tuple[OfAxes, OfAxes, OfAxes]:
        """Position, velocity and acceleration at ``t``."""
        s = smaller(t, self.stop) - self.start
        (x, vx, ax), (y, vy, ay), (z, vz, az), (yaw, yaw_t, yaw_tt) = [quintic.rates(c, s) for c in self.coefficients]
        return (x, y, z, yaw), (vx, vy, vz, yaw_t), (ax, ay, az, yaw_tt)

    def at(self, t: float) -> EndMotion:
        """The motion at ``t``."""
        (x, y, z, yaw), (vx, vy, vz, yaw_rate), (ax, ay, az, _) = self.motion(t)
        return EndMotion(x, y, z, vx, vy, vz, ax, ay, az, yaw, yaw_rate)

    def peak_accelerations(self) -> OfAxes:
        """Largest accelerations on the path, sampled; NaN where the first sample is."""
        times = [part * (self.stop - self.start) for part in (0.0, 0.25, 0.5, 0.75, 1.0)]
        x, y, z, yaw = (reduce(larger, (abs(quintic.acceleration(c, s)) for s in times)) for c in self.coefficients)
        return x, y, z, yaw


class Aimed(NamedTuple):
    """A path from where another ended, and its peak_accelerations."""

    path: EndPath
    peaks: OfAxes


def path_program() -> Program:
    """EndPath.to in CasADi's virtual machine, for ``aim``."""
    return Program(_aimed, 29 + len(EndMotion.__dataclass_fields__))


def aim(program: Program, path: EndPath, stop: float, target: EndMotion, within: float) -> Aimed:
    """``path.to(stop, target, within)``."""
    found = program(*path[:3], *chain(*path.coefficients), stop, within, *vars(target).values())
    return Aimed(_path(found[:27]), (found[27], found[28], found[29], found[30]))


def _aimed(numbers: Sequence[Any]) -> tuple[Any, ...]:
    path = _path(numbers[:27]).to(numbers[27], EndMotion(*numbers[29:]), numbers[28])
    return (*path[:3], *chain(*path.coefficients), *path.peak_accelerations())


def _path(x: Sequence[Any]) -> EndPath:
    """The path of these 27 numbers."""
    return EndPath(x[0], x[1], x[2], (tuple(x[3:9]), tuple(x[9:15]), tuple(x[15:21]), tuple(x[21:27])))


def _missing_time(now: tuple[OfAxes, OfAxes, OfAxes], motion: EndMotion) -> Any:
    """The longest of what a path's end, with its motion ``now``, misses of another."""
    places, speeds, _ = now
    missed = zip((*motion.position, motion.yaw), (*motion.velocity, motion.yaw_rate), places, speeds, strict=True)
    x, y, z, yaw = (missing_time(x - x0, v - v0) for x, v, x0, v0 in missed)
    return larger(larger(yaw, x), larger(y, z))


def ends_at(paths: tuple[EndPath, EndPath], t: float) -> tuple[EndMotion, EndMotion]:
    """The motions of both ends at ``t``."""
    return paths[0].at(t), paths[1].at(t)


#: largest size of each value of EndMotion
REACH = {name: float(numeric_bounds(EndMotion, name)[1] or 0.0) for name in parameters_of(EndMotion)}
