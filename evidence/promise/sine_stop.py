"""An emergency stop whose deceleration is half a wave: a(t) = a0 cos^2(pi t / 2 T) - A sin(pi t / T) over T seconds.

The speed ends at 0 after T = v0 / (2 A / pi - a0 / 2).
"""

import math
from dataclasses import dataclass, replace

from hoist_demo.control.trajectory import Trajectory, TrajectoryPoint, s_curve
from hoist_demo.parameters import Winding as Trip


@dataclass(frozen=True)
class SineStop:
    """``trip`` until ``begin`` (s), then braked to rest in ``lasts`` (s) by at most ``brake`` (m/s^2)."""

    trip: Trajectory
    begin: float
    lasts: float
    brake: float

    @property
    def duration(self) -> float:
        """When the ends rest, s."""
        return self.begin + self.lasts

    def at(self, t: float) -> TrajectoryPoint:
        """The left end at ``t``."""
        if t < self.begin:
            return self.trip.at(t)
        start = self.trip.at(self.begin)
        k = math.pi / self.lasts
        s = start.position
        v = start.speed
        a = start.acceleration
        b = self.brake
        t = min(t - self.begin, self.lasts)
        c = math.cos(k * t)
        sine = math.sin(k * t)
        at_rest = t >= self.lasts
        position = s + v * t + a * (0.25 * t * t + 0.5 * (1 - c) / (k * k)) - b / k * (t - sine / k)
        speed = v + a * (0.5 * t + 0.5 * sine / k) - b * (1 - c) / k
        acceleration = 0.5 * a * (1 + c) - b * sine
        jerk = -k * (0.5 * a * sine + b * c)
        return TrajectoryPoint(position, *((0.0,) * 3 if at_rest else (speed, acceleration, jerk)))


def sine_stop(trip: Trip) -> SineStop:
    """The stop of ``trip`` by a sine instead of by its jerk."""
    assert trip.emergency_at is not None
    before = s_curve(replace(trip, emergency_at=None))
    start = before.at(trip.emergency_at)
    lasts = start.speed / (2 * trip.emergency_deceleration / math.pi - 0.5 * start.acceleration)
    return SineStop(before, trip.emergency_at, lasts, trip.emergency_deceleration)
