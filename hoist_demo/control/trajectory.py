"""Reference motion of the hoist: an S-curve with limited jerk, acceleration and speed, creep, and the emergency stop.

All are chains of segments of constant jerk, in closed form,

    a = a0 + j t,   v = v0 + a0 t + j t^2 / 2,   s = s0 + v0 t + a0 t^2 / 2 + j t^3 / 6.

The S-curve has seven segments (jerk +, 0, -, 0, -, 0, +); those that a short trip does not reach have no duration. With
creep the speed changes between rest, creep speed and the trip's own in ramps (jerk +, 0, - or -, 0, +) of

    (u + v) / 2 (|v - u| / a + a / j) metres, or (u + v) sqrt(|v - u| / j) where the limit a is not reached.

Source: L. Biagiotti and C. Melchiorri, Trajectory Planning for Automatic Machines and Robots, 2008, section 3.4.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hoist_demo.parameters import EmergencyLaw, Winding


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
    trip: Braking | None = (
        None  # emergency stop with the brake, its `elapsed` counted at time 0: minus the trip's time
    )

    @property
    def duration(self) -> float:
        """Time at which the reference has come to rest for good, waiting before the start included [s]."""
        return self.starts[-1]

    def cruise_times(self, speed: float) -> tuple[float, ...]:
        """Times [s] from which the given magnitude of speed [m/s] is held."""
        pairs = zip(self.starts, self.points, strict=True)
        # rounding of the segments before
        return tuple(
            t
            for t, p in pairs
            if p.jerk == 0.0 and abs(abs(p.speed) - speed) + abs(p.acceleration) < 1e-9
        )

    def at(self, t: float) -> TrajectoryPoint:
        """Return the reference at time t [s]."""
        k = bisect_right(self.starts, t) - 1
        if k < 0:
            return self.points[0] if self.starts[0] == t else rest(self.points[0].position)
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
    """Return the trip of `winding` from rest to rest, with its emergency stop if it has one."""
    j = math.copysign(winding.jerk, winding.travel)
    if winding.creeps:
        signs, times = _creep_profile(winding)
        jerks = tuple(s * j for s in signs)
    else:
        t_jerk, t_constant, t_cruise = _phases(
            abs(winding.travel), winding.speed, winding.acceleration, winding.jerk
        )
        jerks = (j, 0.0, -j, 0.0, -j, 0.0, j)
        times = (t_jerk, t_constant, t_jerk, t_cruise, t_jerk, t_constant, t_jerk)
    trip = chain(winding.start_delay, rest(0.0), jerks, times, end=winding.travel)
    if winding.emergency_at is None:
        return trip
    if winding.emergency_at >= trip.duration:
        raise ValueError(
            f"emergency_at = {winding.emergency_at:g} s must be below {trip.duration:.3g} s, where the trip has ended: "
            "stop earlier"
        )
    return with_emergency_stop(trip, winding.emergency_at, winding)


def with_emergency_stop(trip: Trajectory, at: float, winding: Winding) -> Trajectory:
    """`trip` with an emergency stop from time `at` [s] on, by the law of `winding`."""
    stop = emergency_stop(trip, at, winding.emergency_deceleration, winding.emergency_jerk)
    if winding.emergency_law == "drive":
        return stop
    return replace(stop, trip=Braking(winding.emergency_law, -at, winding.emergency_deceleration))


def emergency_stop(trip: Trajectory, at: float, deceleration: float, jerk: float) -> Trajectory:
    """`trip` up to time `at` [s], then braked to standstill with the given limits [m/s^2], [m/s^3]."""
    point = trip.at(at)
    if point.speed == 0.0:
        return _cut(trip, at, Trajectory((at,), (rest(point.position),)))
    sign = math.copysign(1.0, point.speed)
    v, a = abs(point.speed), sign * point.acceleration
    # area under the two ramps alone, from a down to -peak and back to zero, fixes the peak of a short stop
    peak = min(deceleration, math.sqrt(jerk * v + a * a / 2.0))
    if peak < -a:
        raise ValueError(
            f"emergency jerk = {jerk!r} m/s^3 must be above {a * a / (2.0 * v):g} m/s^3 to stop from {v:g} m/s: "
            "shorten the brake's ramp"
        )
    t_on, t_off = (a + peak) / jerk, peak / jerk
    t_hold = max(0.0, (v + (a * a - 2.0 * peak * peak) / (2.0 * jerk)) / peak)
    start = TrajectoryPoint(point.position, point.speed, point.acceleration, 0.0)
    brake = chain(at, start, (-sign * jerk, 0.0, sign * jerk), (t_on, t_hold, t_off), end=None)
    return _cut(trip, at, brake)


def _phases(
    distance: float, speed: float, acceleration: float, jerk: float
) -> tuple[float, float, float]:
    """Durations [s] of one jerk ramp, of the constant acceleration and of the cruise, for a trip of `distance` [m]."""
    t_jerk, t_constant = _ramp(speed, acceleration, jerk)
    distance_to_speed = speed * (2.0 * t_jerk + t_constant)
    if distance >= distance_to_speed:
        return t_jerk, t_constant, (distance - distance_to_speed) / speed
    if distance >= 2.0 * acceleration**3 / jerk**2:
        # speed limit not reached: distance = v (v / a + a / j)
        t_jerk = acceleration / jerk
        v = acceleration / 2.0 * (math.sqrt(t_jerk**2 + 4.0 * distance / acceleration) - t_jerk)
        return t_jerk, max(0.0, v / acceleration - t_jerk), 0.0
    # neither limit reached: distance = 2 j t_jerk^3
    return math.cbrt(distance / (2.0 * jerk)), 0.0, 0.0


def _ramp(change: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """Durations [s] of either jerk ramp and of the constant acceleration of a `change` of speed [m/s]."""
    if change * jerk >= acceleration**2:
        t_jerk = acceleration / jerk
        return t_jerk, change / acceleration - t_jerk
    return math.sqrt(change / jerk), 0.0


def _creep_profile(winding: Winding) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Signs of the jerk and durations [s] of a trip with creep: of the ramps, and of the speeds held between them."""
    travel, c, a, j = abs(winding.travel), winding.creep_speed, winding.acceleration, winding.jerk
    first, last = winding.departure_creep_distance, winding.creep_distance

    def length(u: float, v: float) -> float:
        t_jerk, t_constant = _ramp(abs(v - u), a, j)
        return (u + v) / 2.0 * (2.0 * t_jerk + t_constant)

    stop = length(c, 0.0)
    for name, distance in (("departure_creep_distance", first), ("creep_distance", last)):
        if 0.0 < distance < stop:
            raise ValueError(
                f"{name} = {distance:g} m must be at least {stop:.6g} m, the ramp between rest and "
                f"creep_speed = {c:g} m/s: creep farther or more slowly"
            )

    # highest speed for which both ramps fit between the creeps; their length grows with it
    between = travel - first - last
    before, after = (c if first > 0.0 else 0.0), (c if last > 0.0 else 0.0)

    def ramps(v: float) -> float:
        return length(before, v) + length(v, after)

    if between < ramps(c):
        raise ValueError(
            f"departure_creep_distance + creep_distance = {first + last:g} m must be at most {travel - ramps(c):.6g} m "
            f"of the travel of {travel:g} m: shorten the creep or creep more slowly"
        )
    if ramps(winding.speed) <= between:
        v = winding.speed
    else:
        from scipy.optimize import brentq  # slow to load: for this case alone

        # take the side on which the ramps fit, as their length is steep near c; v takes up the rounding that is left
        v = float(brentq(lambda v: ramps(v) - between, c, winding.speed, xtol=1e-15, rtol=1e-15))
        v = max(c, v - 3e-15 * (1.0 + v))

    departure = [(c, first - stop)] if first > 0.0 else []
    arrival = [(c, last - stop)] if last > 0.0 else []
    signs: list[float] = []
    times: list[float] = []
    speed = 0.0
    for following, distance in [*departure, (v, between - ramps(v)), *arrival, (0.0, 0.0)]:
        t_jerk, t_constant = _ramp(abs(following - speed), a, j)
        up = math.copysign(1.0, following - speed)
        signs += [up, 0.0, -up, 0.0]
        times += [t_jerk, t_constant, t_jerk, distance / following if following > 0.0 else 0.0]
        speed = following
    return tuple(signs), tuple(times)


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
    """Segments of given jerk and duration from `point` at t, then rest at `end` (None: where they lead)."""
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
    points.append(rest(point.position if end is None else end))
    return Trajectory(tuple(starts), tuple(points))


def _cut(trip: Trajectory, at: float, then: Trajectory) -> Trajectory:
    """Join `trip` before time `at` [s] and `then` from it on."""
    before = [(t, p) for t, p in zip(trip.starts, trip.points, strict=True) if t < at]
    return Trajectory(
        tuple(t for t, _ in before) + then.starts, tuple(p for _, p in before) + then.points
    )


@dataclass(frozen=True)
class Course:
    """The trip as it is wound: its reference, and its data with the stop that there was.

    The safety circuit stops the hoist by the law of its winding. A guard of the balance rope's loop opens it, or head
    ropes whose pull on a conveyance is below `Hoist.slack_tension`. The stop begins at the first sample that sees the
    trip. One that is under way already stays as it is, and a reference that has come to rest needs none.
    """

    trajectory: Trajectory
    winding: Winding

    def with_emergency_stop(self, at: float) -> Course:
        """Return the course with an emergency stop from `at` [s] on, if none has begun before."""
        begun = self.winding.emergency_at
        if at >= self.trajectory.duration or (begun is not None and begun <= at):
            return self
        return Course(
            with_emergency_stop(self.trajectory, at, self.winding),
            replace(self.winding, emergency_at=at),
        )
