"""Reference motion of the hoist: an S-curve with or without creep, and the emergency stop.

Jerk, acceleration and speed are limited. All are chains of segments of constant jerk, in closed
form,

    a = a0 + j t,   v = v0 + a0 t + j t^2 / 2,   s = s0 + v0 t + a0 t^2 / 2 + j t^3 / 6.

The S-curve has seven segments (jerk +, 0, -, 0, -, 0, +); those that a short trip does not reach
have no duration. With creep the speed changes between rest, creep speed and the trip's own in ramps
(jerk +, 0, - or -, 0, +) of

    (u + v) / 2 (|v - u| / a + a / j) metres, or (u + v) sqrt(|v - u| / j) where the limit a is not
    reached.

Source: L. Biagiotti and C. Melchiorri, Trajectory Planning for Automatic Machines and Robots, 2008,
section 3.4.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hoist_demo.parameters import EmergencyLaw, Winding

_ROUNDING = 1e-9  #: Rounding of speeds and accelerations at the end of a chain of segments.
_SPEED_ERROR = 1e-15  #: Error of the speed that fits between two creeps [m/s, and relative].
_SPEED_MARGIN = 3e-15  #: Part of 1 m/s + the speed by which it is lower, for the ramps to fit.


@dataclass(frozen=True)
class Braking:
    """Emergency stop with the brake, under way."""

    law: EmergencyLaw
    elapsed: float  # s, since the trip
    deceleration: float  # m/s^2, that a regulated brake shall keep


class TrajectoryPoint(NamedTuple):
    """Motion of the left conveyance asked for at one instant, counted from its start position."""

    position: float  # m
    speed: float  # m/s
    acceleration: float  # m/s^2
    jerk: float  # m/s^3
    braking: Braking | None = None  # None: the drive follows the reference

    def after(self, dt: float) -> TrajectoryPoint:
        """Return the point dt [s] later under the same jerk."""
        s, v, a, j, _ = self
        position = s + dt * (v + dt * (a / 2.0 + dt * j / 6.0))
        return TrajectoryPoint(position, v + dt * (a + dt * j / 2.0), a + dt * j, j)


@dataclass(frozen=True)
class Trajectory:
    """Chain of constant-jerk segments; before the first and after the last the reference rests."""

    starts: tuple[float, ...]  # s, ascending, one per segment, the last is where rest begins
    points: tuple[TrajectoryPoint, ...]  # motion at each start
    #: Emergency stop with the brake; its ``elapsed`` is that at time 0: minus the time of the trip.
    trip: Braking | None = None

    @property
    def duration(self) -> float:
        """Time at which the reference has come to rest for good [s], from before the wait on."""
        return self.starts[-1]

    def cruise_times(self, speed: float) -> tuple[float, ...]:
        """Times [s] from which the given magnitude of speed [m/s] is held."""
        times = []
        for t, point in zip(self.starts, self.points, strict=True):
            difference = abs(abs(point.speed) - speed) + abs(point.acceleration)
            if point.jerk == 0.0 and difference < _ROUNDING:
                times.append(t)
        return tuple(times)

    def at(self, t: float) -> TrajectoryPoint:
        """Return the reference at time t [s]."""
        k = bisect_right(self.starts, t) - 1
        if k < 0:
            return rest(self.points[0].position)
        point = self.points[k].after(t - self.starts[k])
        if self.trip is None or t + self.trip.elapsed < 0.0:
            return point
        return point._replace(braking=replace(self.trip, elapsed=t + self.trip.elapsed))

    def sample(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Position, speed, acceleration and jerk as columns, one row per time."""
        k = np.searchsorted(self.starts, times, side="right") - 1
        begun = np.array([point[:4] for point in self.points])[np.maximum(k, 0)]
        rows = np.column_stack(
            TrajectoryPoint(*begun.T).after(times - np.array(self.starts)[k])[:4]
        )
        rows[k < 0] = rest(self.points[0].position)[:4]
        return rows


def s_curve(winding: Winding) -> Trajectory:
    """Return the trip of ``winding`` from rest to rest, with its emergency stop if it has one."""
    j = math.copysign(winding.jerk, winding.travel)
    if winding.creeps:
        signs, times = _creep_profile(winding)
        jerks = tuple(s * j for s in signs)
    else:
        (t_jerk, t_constant), t_cruise = _phases(
            abs(winding.travel), winding.speed, winding.acceleration, winding.jerk
        )
        jerks = (j, 0.0, -j, 0.0, -j, 0.0, j)
        times = (t_jerk, t_constant, t_jerk, t_cruise, t_jerk, t_constant, t_jerk)
    trip = chain(winding.start_delay, rest(0.0), jerks, times, end=winding.travel)
    if winding.emergency_at is None:
        return trip
    if winding.emergency_at >= trip.duration:
        raise ValueError(
            f"emergency_at = {winding.emergency_at:g} s must be below {trip.duration:.3g} s, "
            "where the trip has ended: stop earlier"
        )
    return with_emergency_stop(trip, winding.emergency_at, winding)


def with_emergency_stop(trip: Trajectory, at: float, winding: Winding) -> Trajectory:
    """``trip`` with an emergency stop from time ``at`` [s] on, by the law of ``winding``."""
    stop = emergency_stop(trip, at, winding.emergency_deceleration, winding.emergency_jerk)
    if winding.emergency_law == "drive":
        return stop
    return replace(stop, trip=Braking(winding.emergency_law, -at, winding.emergency_deceleration))


def emergency_stop(trip: Trajectory, at: float, deceleration: float, jerk: float) -> Trajectory:
    """Return ``trip`` up to time ``at`` [s], then braked to standstill within these limits.

    They are in m/s^2 and m/s^3.
    """
    point = trip.at(at)
    if point.speed == 0.0:
        return _cut(trip, at, Trajectory((at,), (rest(point.position),)))
    sign = math.copysign(1.0, point.speed)
    v = abs(point.speed)
    a = sign * point.acceleration
    # the area under the two ramps alone, from a to -peak and back to 0, is the speed of a short
    # stop
    peak = min(deceleration, math.sqrt(jerk * v + a * a / 2.0))
    if peak < -a:
        raise ValueError(
            f"emergency jerk = {jerk!r} m/s^3 must be above {a * a / (2.0 * v):g} m/s^3 "
            f"to stop from {v:g} m/s: shorten the brake's ramp"
        )
    t_on = (a + peak) / jerk
    t_off = peak / jerk
    t_hold = max(0.0, (v + (a * a - 2.0 * peak * peak) / (2.0 * jerk)) / peak)
    start = TrajectoryPoint(point.position, point.speed, point.acceleration, 0.0)
    brake = chain(at, start, (-sign * jerk, 0.0, sign * jerk), (t_on, t_hold, t_off), end=None)
    return _cut(trip, at, brake)


class _Ramp(NamedTuple):
    """Durations of a change of speed."""

    jerk: float  # s, of either jerk ramp
    constant: float  # s, of the constant acceleration


class _Phases(NamedTuple):
    """Durations of a trip without creep."""

    ramp: _Ramp
    cruise: float  # s


def _phases(distance: float, speed: float, acceleration: float, jerk: float) -> _Phases:
    """Return the durations of a trip of ``distance`` [m]."""
    ramp = _ramp(speed, acceleration, jerk)
    distance_to_speed = speed * (2.0 * ramp.jerk + ramp.constant)
    if distance >= distance_to_speed:
        return _Phases(ramp, cruise=(distance - distance_to_speed) / speed)
    if distance >= 2.0 * acceleration**3 / jerk**2:
        # speed limit not reached: distance = v (v / a + a / j)
        t_jerk = acceleration / jerk
        v = acceleration / 2.0 * (math.sqrt(t_jerk**2 + 4.0 * distance / acceleration) - t_jerk)
        return _Phases(_Ramp(t_jerk, max(0.0, v / acceleration - t_jerk)), cruise=0.0)
    # neither limit reached: distance = 2 j t_jerk^3
    return _Phases(_Ramp(math.cbrt(distance / (2.0 * jerk)), 0.0), cruise=0.0)


def _ramp(change: float, acceleration: float, jerk: float) -> _Ramp:
    """Return the durations of a ``change`` of speed [m/s]."""
    if change * jerk >= acceleration**2:
        t_jerk = acceleration / jerk
        return _Ramp(t_jerk, change / acceleration - t_jerk)
    return _Ramp(math.sqrt(change / jerk), 0.0)


def _ramp_length(u: float, v: float, winding: Winding) -> float:
    """Return the distance of the ramp from the speed u to v [m/s] in m."""
    ramp = _ramp(abs(v - u), winding.acceleration, winding.jerk)
    return (u + v) / 2.0 * (2.0 * ramp.jerk + ramp.constant)


class _HeldSpeed(NamedTuple):
    """Speed that a trip holds between two ramps."""

    speed: float  # m/s
    distance: float  # m


def _creep_profile(winding: Winding) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the signs of the jerk and the durations [s] of all segments of a trip with creep."""
    signs: list[float] = []
    times: list[float] = []
    speed = 0.0
    for held in _held_speeds(winding):
        ramp = _ramp(abs(held.speed - speed), winding.acceleration, winding.jerk)
        up = math.copysign(1.0, held.speed - speed)
        duration = 0.0
        if held.speed > 0.0:
            duration = held.distance / held.speed
        signs += [up, 0.0, -up, 0.0]
        times += [ramp.jerk, ramp.constant, ramp.jerk, duration]
        speed = held.speed
    return tuple(signs), tuple(times)


def _held_speeds(winding: Winding) -> list[_HeldSpeed]:
    """Return the speeds that a trip with creep holds, the final rest included."""
    travel = abs(winding.travel)
    c = winding.creep_speed
    first = winding.departure_creep_distance
    last = winding.creep_distance
    stop = _ramp_length(c, 0.0, winding)
    for name, distance in (("departure_creep_distance", first), ("creep_distance", last)):
        if 0.0 < distance < stop:
            raise ValueError(
                f"{name} = {distance:g} m must be at least {stop:.6g} m, the ramp between rest and "
                f"creep_speed = {c:g} m/s: creep farther or more slowly"
            )

    between = travel - first - last
    before = c if first > 0.0 else 0.0
    after = c if last > 0.0 else 0.0

    def ramps(v: float) -> float:
        return _ramp_length(before, v, winding) + _ramp_length(v, after, winding)

    if between < ramps(c):
        raise ValueError(
            f"departure_creep_distance + creep_distance = {first + last:g} m must be at most "
            f"{travel - ramps(c):.6g} m of the travel of {travel:g} m: "
            "shorten the creep or creep more slowly"
        )
    v = _highest_speed(winding, between, ramps)
    held = [_HeldSpeed(v, between - ramps(v))]
    if first > 0.0:
        held.insert(0, _HeldSpeed(c, first - stop))
    if last > 0.0:
        held.append(_HeldSpeed(c, last - stop))
    return [*held, _HeldSpeed(0.0, 0.0)]


def _highest_speed(winding: Winding, between: float, ramps: Callable[[float], float]) -> float:
    """Return the highest speed [m/s] whose two ``ramps`` [m] fit ``between`` the creeps [m].

    The length of the ramps grows with the speed.
    """
    if ramps(winding.speed) <= between:
        return winding.speed
    from scipy.optimize import brentq  # slow to load: for this case alone

    c = winding.creep_speed
    v = float(
        brentq(lambda v: ramps(v) - between, c, winding.speed, xtol=_SPEED_ERROR, rtol=_SPEED_ERROR)
    )
    # take the side on which the ramps fit, as their length is steep near c; v takes up the rounding
    return max(c, v - _SPEED_MARGIN * (1.0 + v))


def rest(position: float) -> TrajectoryPoint:
    """Return the reference at rest at this position [m]."""
    return TrajectoryPoint(position, 0.0, 0.0, 0.0)


def chain(
    t: float,
    point: TrajectoryPoint,
    jerks: Sequence[float],
    times: Sequence[float],
    end: float | None,
) -> Trajectory:
    """Return segments of given jerk and duration from ``point`` at t [s], then rest at ``end`` [m].

    None for ``end`` stands for where the segments lead.
    """
    starts: list[float] = []
    points: list[TrajectoryPoint] = []
    for j, dt in zip(jerks, times, strict=True):
        if dt > 0.0:
            begin = TrajectoryPoint(point.position, point.speed, point.acceleration, j)
            starts.append(t)
            points.append(begin)
            point = begin.after(dt)
            t += dt
    starts.append(t)
    if end is None:
        end = point.position
    points.append(rest(end))
    return Trajectory(tuple(starts), tuple(points))


def _cut(trip: Trajectory, at: float, continuation: Trajectory) -> Trajectory:
    """Join ``trip`` before time ``at`` [s] and ``continuation`` from it on."""
    before = bisect_left(trip.starts, at)
    return Trajectory(
        trip.starts[:before] + continuation.starts, trip.points[:before] + continuation.points
    )


@dataclass(frozen=True)
class Course:
    """The trip as it is wound: its reference, and its data with the stop that there was.

    The safety circuit stops the hoist by the law of its winding. A guard of the balance rope's loop
    opens it, or head ropes whose pull on a conveyance is below ``Hoist.slack_tension``. The stop
    begins at the first sample that sees the trip. One that is under way already stays as it is, and
    a reference that has come to rest needs none.
    """

    trajectory: Trajectory
    winding: Winding

    def with_emergency_stop(self, at: float) -> Course:
        """Return the course with an emergency stop from ``at`` [s] on, if none has begun before."""
        begun = self.winding.emergency_at
        if at >= self.trajectory.duration or (begun is not None and begun <= at):
            return self
        return Course(
            with_emergency_stop(self.trajectory, at, self.winding),
            replace(self.winding, emergency_at=at),
        )
