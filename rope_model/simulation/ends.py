"""The rope's two ends: how the conveyances move them, and how the swivels hold them.

An end is vertical (tangent -Y on the left, +Y on the right); its position and tangent direction are prescribed, only
the stretch |r'| is free.  theta is prescribed while the swivel holds and free while it slips:

    theta = offset + s yaw + b,   s = -1 on the left, +1 on the right

with the conveyance's yaw about Y, the swivel's relative angle b, and an offset that belongs to the frame: theta is
counted from the left end on along the rope (physics.frame), so the right end's changes as the rope turns in space.

Between two instants of the host each coordinate follows a quintic polynomial in time, so that position, speed and
acceleration are continuous whatever the host's step.  Where the last path ended beside the motion that the host now
gives (its extrapolation was wrong by j H^3 / 6 at a jerk j), a step h much shorter than the H before must not make that
good within h: that would take j H^3 / h^2.  So a path is aimed ahead by the time in which a small jerk would miss as
much, at most ``within`` seconds, and left where the step ends.  A path that misses nothing is aimed at its step's end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics import quintic
from ..parameter_table import numeric_bounds, parameter, parameters_of
from ..parameters import Swivel
from ..physics.elementary import atan2, larger, sqrt
from ..physics.swivel import friction_moment
from . import messages
from .rope_system import ANGLE, POSITION, Array

SIDES = ("left", "right")
#: sense of the conveyance's yaw in theta, left and right
YAW_SENSE = (-1.0, 1.0)
#: columns of an end's path
PATH = ("x", "y", "z", "yaw")
#: s: positions of 1e4 m are rounded by 2e-12 m; made good in this time that takes some .1 m/s^2, in 1e-8 s 1e5 m/s^2
SHORTEST_AIM = 1e-5
#: m/s^3 and rad/s^3: what the motion misses is made good at such a jerk, or at the one that made it miss
LEAST_JERK = 0.1
#: steps that differ by less than this part of themselves are alike
ALIKE = 1e-6


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
        states = zip(self.position, self.velocity, self.acceleration, strict=True)
        (x, vx), (y, vy), (z, vz) = (quintic.extrapolate(*state, h) for state in states)
        return replace(self, x=x, y=y, z=z, vx=vx, vy=vy, vz=vz, yaw=self.yaw + self.yaw_rate * h)

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
Quintic = tuple[float, ...]


class EndPath(NamedTuple):
    """A quintic in s = t - start for each of x, y, z and yaw, aimed at ``aim``; left, and held, at ``stop``."""

    start: float
    stop: float
    aim: float
    coefficients: tuple[Quintic, ...]

    @staticmethod
    def at_rest(t: float, at: EndMotion) -> EndPath:
        """No motion at all."""
        return EndPath(t, t, t, tuple((x, 0.0, 0.0, 0.0, 0.0, 0.0) for x in (*at.position, at.yaw)))

    def to(self, stop: float, target: EndMotion, within: float = 0.0) -> EndPath:
        """The path from this one's end to the motion that has ``target`` at ``stop``.

        It joins that motion at ``stop``, or later where this path's end misses it: at most ``within`` s from here or
        where this path was aimed.  Until then the motion goes on with the target's accelerations.
        """
        start, step = self.stop, stop - self.stop
        h = max(step, min(self._missing_time(target.extrapolate(-step)), max(self.aim - start, within)))
        if h <= step * (1.0 + ALIKE):
            h = step
        else:
            target = target.extrapolate(h - step)
        places, speeds = (*target.position, target.yaw), (*target.velocity, target.yaw_rate)
        # FMI gives no yaw acceleration: take the mean over the step
        yaw_rate = self.rates(start, 3)[1]
        accelerations = (*target.acceleration, (target.yaw_rate - yaw_rate) / h)
        quintics = []
        for axis, (x1, v1, a1) in enumerate(zip(places, speeds, accelerations, strict=True)):
            quintics.append(quintic.coefficients(h, *self.rates(start, axis), x1, v1, a1))
        return EndPath(start, stop, start + h, tuple(quintics))

    def _missing_time(self, motion: EndMotion) -> float:
        """The longest of what this path's end misses of ``motion``."""
        places, speeds = (*motion.position, motion.yaw), (*motion.velocity, motion.yaw_rate)
        ends = (self.rates(self.stop, axis) for axis in range(4))
        return float(max(missing_time(x - x0, v - v0) for x, v, (x0, v0, _) in zip(places, speeds, ends, strict=True)))

    def at_constant_acceleration(self, t: float) -> EndPath:
        """The motion at ``t`` with its accelerations kept, before and after."""
        motion = (self.rates(t, axis) for axis in range(4))
        return EndPath(t, math.inf, math.inf, tuple((x, v, 0.5 * a, 0.0, 0.0, 0.0) for x, v, a in motion))

    def rates(self, t: float, axis: int) -> tuple[float, float, float]:
        """Value, rate and acceleration of one coordinate at ``t``."""
        return quintic.rates(self.coefficients[axis], min(t, self.stop) - self.start)

    def height(self, t: float) -> float:
        """y at ``t``."""
        return self.rates(t, 1)[0]

    def __call__(self, t: float) -> Array:
        """Position, velocity and acceleration at ``t``, shape (3, 4)."""
        return np.array([self.rates(t, axis) for axis in range(4)]).T

    def peak_acceleration(self) -> list[float]:
        """Largest acceleration on the path, sampled: of x, y, z and yaw."""
        times = [part * (self.stop - self.start) for part in (0.0, 0.25, 0.5, 0.75, 1.0)]
        return [max(abs(quintic.acceleration(c, s)) for s in times) for c in self.coefficients]


class Phase(Enum):
    """What a swivel does."""

    LOCKED = 0
    STICK = 1
    SLIP = 2


class SwivelState(NamedTuple):
    """Phase; while it holds, the relative angle b (rad); while it slips, the sign of b_t."""

    phase: Phase
    angle: float
    sign: float


@dataclass(frozen=True)
class HangingEnds:
    """A rope_system.Boundary: both ends on their paths, each swivel in its phase.

    ``points`` are the nominal suspension points (2, 3), ``offsets`` those of theta (2,).
    """

    points: Array
    paths: tuple[EndPath, EndPath]
    swivels: tuple[Swivel, Swivel]
    states: tuple[SwivelState, SwivelState]
    offsets: tuple[float, float]

    def free(self, nodes: int) -> NDArray[np.bool_]:
        free = np.ones((nodes, 7), dtype=bool)
        free[[0, -1]] = False
        free[[0, -1], 4] = True
        for node, state in zip((0, -1), self.states, strict=True):
            free[node, ANGLE] = state.phase is Phase.SLIP
        return free

    def prescribed_motion(self, t: float, nodes: int) -> Array:
        motion = np.zeros((3, nodes, 7))
        for side, node in enumerate((0, -1)):
            x, y, z, yaw = (self.paths[side].rates(t, axis) for axis in range(4))
            rows = np.zeros((3, 7))
            rows[:, 0], rows[:, 1], rows[:, 2], rows[:, ANGLE] = x, y, z, yaw
            rows[:, ANGLE] *= YAW_SENSE[side]
            rows[0, POSITION] += self.points[side]
            rows[0, ANGLE] += self.offsets[side] + self.states[side].angle
            motion[:, node] = rows
        return motion

    def load(self, nodes: int) -> Array:
        return self._slip_moments(nodes, [x.seal_moment for x in self.swivels])

    def friction_load(self, nodes: int) -> Array:
        return self._slip_moments(
            nodes, [friction_moment(x.mu_kinetic, x.mean_diameter, 0.0, 1.0) for x in self.swivels]
        )

    def _slip_moments(self, nodes: int, moments: Sequence[float]) -> Array:
        """(nodes, 7): ``moments`` against the slip of the ends that slip."""
        load = np.zeros((nodes, 7))
        for node, state, swivel, moment in zip((0, -1), self.states, self.swivels, moments, strict=True):
            if state.phase is Phase.SLIP and swivel.mode != "free":
                load[node, ANGLE] = -state.sign * moment
        return load

    def friction(self, side: int, reaction: Array, kinetic: bool) -> float:
        """Moment (N m) the swivel's friction has, or at most has, at the end's present tension."""
        swivel = self.swivels[side]
        if swivel.mode == "free":
            return 0.0
        mu = swivel.mu_kinetic if kinetic else swivel.mu_static
        tension = float(reaction[0 if side == 0 else -1, 1])
        return float(friction_moment(mu, swivel.mean_diameter, swivel.seal_moment, tension))

    def moment(self, side: int, reaction: Array) -> float:
        """Moment (N m, about the tangent) of the conveyance on the rope's end."""
        state = self.states[side]
        if state.phase is Phase.SLIP:
            return -state.sign * self.friction(side, reaction, kinetic=True)
        return float(reaction[0 if side == 0 else -1, ANGLE])

    def relative(self, side: int, t: float, theta: float, theta_t: float) -> tuple[float, float]:
        """The swivel's angle b (rad) and rate b_t (rad/s)."""
        yaw, yaw_rate, _ = self.paths[side].rates(t, 3)
        return theta - self.offsets[side] - YAW_SENSE[side] * yaw, theta_t - YAW_SENSE[side] * yaw_rate


def nominal_points(spacing: float) -> Array:
    """(2, 3): the suspension points at height zero."""
    return np.array([[-0.5 * spacing, 0.0, 0.0], [0.5 * spacing, 0.0, 0.0]])


def right_offset(left: Any, right: Any) -> Any:
    """Offset (rad) of theta at the right end of an untwisted rope in the vertical plane of its ends at these points.

    Turning that plane by psi about Y turns the frame by psi at the left end, by -psi at the right.
    """
    return 2.0 * atan2(right[2] - left[2], right[0] - left[0])


#: largest size of each value of EndMotion
REACH = {name: float(numeric_bounds(EndMotion, name)[1] or 0.0) for name in parameters_of(EndMotion)}


def refusal(target: EndMotion, path: EndPath, side: str) -> str:
    """'' when an end can follow ``path`` to ``target``; otherwise what is wrong, with bound and cure."""
    for name, bound in REACH.items():
        value = getattr(target, name)
        if not math.isfinite(value):
            return messages.input_not_finite(side, name, value)
        if not -bound <= value <= bound:
            return messages.input_out_of_range(side, name, value, bound)
    peak = path.peak_acceleration()
    worst = max(range(4), key=peak.__getitem__)
    if not peak[worst] <= HARDEST:
        unit = "rad/s^2" if worst == 3 else "m/s^2"
        return messages.inputs_do_not_fit(side, PATH[worst], peak[worst], unit, HARDEST)
    return ""
