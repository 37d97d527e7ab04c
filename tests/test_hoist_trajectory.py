"""The reference keeps its limits, ends where it must and is consistent with its own derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.parameters import Winding

TRIPS = {
    "default, speed limit not reached": Winding(),
    "speed and acceleration limits reached": Winding(travel=90.0, speed=4.0),
    "speed limit reached before the acceleration limit": Winding(travel=10.0, speed=0.5, acceleration=2.0),
    "acceleration limit reached, speed limit not": Winding(travel=20.0),
    "no limit but jerk reached": Winding(travel=1.0),
    "very short": Winding(travel=1e-3),
    "lowering": Winding(travel=-37.0),
    "no delay": Winding(travel=5.0, start_delay=0.0),
    "creep before the landing": Winding(creep_distance=3.0, creep_speed=0.5),
    "creep at both ends": Winding(-60.0, 4.0, creep_distance=2.0, departure_creep_distance=1.5, creep_speed=0.6),
}
trips = pytest.mark.parametrize("winding", TRIPS.values(), ids=TRIPS.keys())


def _grid(trajectory: Trajectory) -> np.ndarray:
    return np.unique(np.concatenate([np.linspace(0.0, trajectory.duration + 1.0, 4001), trajectory.starts]))


@trips
def test_limits_of_speed_acceleration_and_jerk_are_kept(winding: Winding) -> None:
    trajectory = s_curve(winding)
    _, v, a, j = trajectory.sample(_grid(trajectory)).T
    # 1e-12 relative: a few hundred rounding errors of double precision
    assert np.max(np.abs(v)) <= winding.speed * (1 + 1e-12)
    assert np.max(np.abs(a)) <= winding.acceleration * (1 + 1e-12)
    assert np.max(np.abs(j)) <= winding.jerk * (1 + 1e-12)


@trips
def test_segments_join_without_a_jump_and_reach_the_travel(winding: Winding) -> None:
    trajectory = s_curve(winding)
    for k in range(len(trajectory.starts) - 1):
        before = trajectory.points[k].after(trajectory.starts[k + 1] - trajectory.starts[k])
        after = trajectory.points[k + 1]
        # closed form against closed form: rounding only, scaled by the largest term that cancels
        scale = 1e-13 * (1.0 + abs(winding.travel)) * (1.0 + trajectory.duration)
        np.testing.assert_allclose(before.position, after.position, rtol=0, atol=scale)
        np.testing.assert_allclose(before.speed, after.speed, rtol=0, atol=scale)
        np.testing.assert_allclose(before.acceleration, after.acceleration, rtol=0, atol=scale)


@trips
def test_final_position_is_exactly_the_travel(winding: Winding) -> None:
    trajectory = s_curve(winding)
    end = trajectory.at(trajectory.duration)
    assert (end.position, end.speed, end.acceleration, end.jerk) == (winding.travel, 0.0, 0.0, 0.0)
    assert trajectory.at(-1.0).position == 0.0


@trips
def test_each_derivative_is_the_difference_quotient_of_the_one_before(winding: Winding) -> None:
    trajectory = s_curve(winding)
    t = np.random.default_rng(1).uniform(0.0, trajectory.duration, 200)
    d = 1e-5 * trajectory.duration
    # central differences are off by d^2/6 times the third derivative, and only by rounding inside a segment
    inside = np.array([all(abs(x - s) > 2 * d for s in trajectory.starts) for x in t])
    low, mid, high = (trajectory.sample(t[inside] + shift) for shift in (-d, 0.0, d))
    quotient = (high[:, :3] - low[:, :3]) / (2 * d)
    atol = d * d * winding.jerk / 6 + 1e-15 * (1.0 + abs(winding.travel)) / d * 10
    np.testing.assert_allclose(quotient, mid[:, 1:], rtol=0, atol=atol)


def test_the_90_m_winding_peaks_where_the_quadratic_says() -> None:
    # v (v/a + a/j) = 90 m
    v = 0.375 * (math.sqrt(1.5**2 + 4 * 90 / 0.75) - 1.5)
    trajectory = s_curve(Winding())
    np.testing.assert_allclose(trajectory.peak_speed, v, rtol=1e-13)
    np.testing.assert_allclose(trajectory.duration, 1.0 + 2 * (v / 0.75 + 1.5), rtol=1e-13)


def test_shortest_trip_lasts_four_jerk_ramps() -> None:
    trajectory = s_curve(Winding(travel=1.0, start_delay=0.0))
    np.testing.assert_allclose(trajectory.duration, 4 * (1.0 / (2 * 0.5)) ** (1 / 3), rtol=1e-13)


@pytest.mark.parametrize("at", [0.5, 1.0, 1.2, 3.0, 8.0, 12.0, 14.0, 20.0, 24.4])
@pytest.mark.parametrize("travel", [90.0, -90.0])
def test_emergency_stop_comes_to_rest_within_its_limits_and_never_reverses(at: float, travel: float) -> None:
    winding = Winding(travel=travel, emergency_at=at)
    trip, trajectory = s_curve(Winding(travel=travel)), s_curve(winding)
    t = np.linspace(0.0, trajectory.duration + 1.0, 8001)
    s, v, a, j = trajectory.sample(t).T
    # rounding of the segment sums only
    assert np.min(math.copysign(1.0, travel) * v) >= -1e-12
    assert np.max(np.abs(a)) <= winding.emergency_deceleration * (1 + 1e-12)
    assert np.max(np.abs(j)) <= winding.emergency_jerk * (1 + 1e-12)
    assert trajectory.at(trajectory.duration).speed == 0.0
    before = t < at
    np.testing.assert_array_equal(trajectory.sample(t[before]), trip.sample(t[before]))
    # position is the integral of the speed: trapezoidal rule, error <= dt^2/12 max|a'| T, largest at the brake's jerk
    dt = t[1] - t[0]
    bound = dt * dt / 12 * winding.emergency_jerk * trajectory.duration
    np.testing.assert_allclose(s[-1], np.trapezoid(v, t), rtol=0, atol=bound)


def test_emergency_stop_after_the_trip_is_refused() -> None:
    with pytest.raises(ValueError, match=r"emergency_at = 30 s must be below 24\.5 s"):
        s_curve(Winding(emergency_at=30.0))


def test_emergency_stop_from_full_speed_takes_the_textbook_time() -> None:
    winding = Winding(travel=90.0, speed=4.0, emergency_at=12.0)
    trajectory = s_curve(winding)
    # v / d + d / j: constant deceleration with one ramp on either side
    np.testing.assert_allclose(trajectory.duration - 12.0, 4.0 / 5.0 + 5.0 / 50.0, rtol=1e-12)


@pytest.mark.parametrize(
    ("field", "value"), [("travel", 0.0), ("speed", -1.0), ("jerk", math.nan), ("emergency_deceleration", 0.1)]
)
def test_a_bad_value_is_named_with_bound_and_cure(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf"{field} = .* must be .*: "):
        Winding(**{field: value})
