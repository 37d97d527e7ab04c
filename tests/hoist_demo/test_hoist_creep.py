"""A trip with creep keeps its limits, creeps where and as fast as asked, and lands exactly."""

import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding

LANDING = Winding(creep_distance=3.0, creep_speed=0.5)
BOTH = Winding(
    travel=-60.0, speed=4.0, creep_distance=2.0, departure_creep_distance=1.5, creep_speed=0.6
)
SHORT = Winding(travel=5.0, creep_distance=3.0, creep_speed=0.5)
# hardly faster than its creep, where the ramp's length is steep in the speed
NEAR = Winding(
    0.01104854446708835, 0.5, 1.0, 1.0, creep_speed=0.03125, creep_distance=0.005524271733544175
)


#: of the speed limit, the acceleration limit and the jerk some are reached and others are not
PLAIN = [
    Winding(),
    Winding(speed=4.0),
    Winding(travel=10.0, speed=0.5, acceleration=2.0),
    Winding(travel=20.0),
]
PLAIN += [
    Winding(travel=1.0),
    Winding(travel=1e-3),
    Winding(travel=-37.0),
    Winding(travel=5.0, start_delay=0.0),
]


def _ramp_length(u: float, v: float, a: float, j: float) -> float:
    """Length of a jerk-limited change of speed: mean speed times duration [m]."""
    change = abs(v - u)
    duration = 2 * math.sqrt(change / j)
    if change >= a * a / j:
        duration = change / a + a / j
    return (u + v) / 2 * duration


@st.composite
def windings(draw: st.DrawFn) -> Winding:
    """Trips with creep at the landing, at the departure or at both that fit in."""
    number = {name: draw(st.floats(low, high)) for name, (low, high) in _RANGES.items()}
    c = number["creep_speed"] * number["speed"]
    # the shortest creep there is, clear of rounding
    stop = _ramp_length(0.0, c, number["acceleration"], number["jerk"]) * (1 + 1e-9)
    ends = draw(st.sampled_from([(True, False), (False, True), (True, True)]))
    creeps = []
    for end in ends:
        if end:
            creeps.append(stop + draw(st.floats(0.0, 5.0)))
        else:
            creeps.append(0.0)
    least = sum(creeps) + stop * (2 - sum(ends))
    assume(least > 1e-3)
    return Winding(
        travel=draw(st.sampled_from([1.0, -1.0])) * (least + draw(st.floats(0.0, 200.0)) + 1e-9),
        creep_distance=creeps[0],
        departure_creep_distance=creeps[1],
        emergency_deceleration=5.0,
        **(number | {"creep_speed": c}),
    )


_RANGES = {
    "speed": (0.5, 18.0),
    "acceleration": (0.1, 2.0),
    "jerk": (0.1, 5.0),
    "creep_speed": (0.05, 1.0),
}

few = settings(max_examples=150, deadline=None)


def trips(test: Any) -> Any:
    """Random trips with creep, and those at which some limit is just reached or not."""
    for winding in (LANDING, BOTH, SHORT, NEAR, *PLAIN):
        test = example(winding)(test)
    return few(given(windings())(test))


@trips
def test_limits_are_kept_and_the_trip_never_reverses(winding: Winding) -> None:
    trajectory = s_curve(winding)
    times = np.unique(
        np.concatenate([np.linspace(0.0, trajectory.duration + 1.0, 1001), trajectory.starts])
    )
    _, v, a, j = trajectory.sample(times).T
    # relative: rounding of some 20 segments; absolute: of the sums that cancel at the end
    for values, most in ((v, winding.speed), (a, winding.acceleration), (j, winding.jerk)):
        assert np.max(np.abs(values)) <= most * (1 + 1e-11)
    assert np.min(math.copysign(1.0, winding.travel) * v) >= -1e-11 * winding.speed


@trips
def test_segments_join_without_a_jump_and_land_exactly(winding: Winding) -> None:
    trajectory = s_curve(winding)
    # rounding of the speed grows with the time over which it is held
    scale = 1e-13 * (1.0 + abs(winding.travel)) * (1.0 + trajectory.duration)
    for k, (start, end) in enumerate(itertools.pairwise(trajectory.starts)):
        joined = trajectory.points[k].after(end - start), trajectory.points[k + 1]
        before, after = ((p.position, p.speed, p.acceleration) for p in joined)
        np.testing.assert_allclose(before, after, rtol=0, atol=scale)
    end = trajectory.at(trajectory.duration)
    assert (end.position, end.speed, end.acceleration, end.jerk) == (winding.travel, 0.0, 0.0, 0.0)


@trips
def test_creep_speed_is_held_over_the_creeps_less_their_ramps(winding: Winding) -> None:
    trajectory = s_curve(winding)
    travel = abs(winding.travel)
    c = winding.creep_speed
    ramp = _ramp_length(0.0, c, winding.acceleration, winding.jerk)
    creeps = (
        (ramp, winding.departure_creep_distance),
        (travel - winding.creep_distance, travel - ramp),
    )
    for at_start, at_end in creeps:
        if at_end - at_start < 1e-6:  # no creep here, or no more than its ramps
            continue
        for place in np.linspace(at_start, at_end, 5):
            # the time at which the place is passed, between two segments' ends
            k = max(
                i for i, p in enumerate(trajectory.points[:-1]) if abs(p.position) <= place + 1e-9
            )
            t = trajectory.starts[k] + max(0.0, place - abs(trajectory.points[k].position)) / c
            assert abs(trajectory.at(t).speed) == pytest.approx(c, rel=1e-6, abs=1e-6)


@trips
def test_peak_is_the_speed_limit_or_the_highest_for_which_the_ramps_fit(winding: Winding) -> None:
    peak = max(abs(point.speed) for point in s_curve(winding).points)
    c = winding.creep_speed
    between = abs(winding.travel) - winding.creep_distance - winding.departure_creep_distance
    distances = (winding.departure_creep_distance, winding.creep_distance)
    ends = [c * (distance > 0.0) for distance in distances]

    def needed(v: float) -> float:
        return sum(_ramp_length(u, v, winding.acceleration, winding.jerk) for u in ends)

    assert max(ends) * (1 - 1e-12) <= peak <= winding.speed * (1 + 1e-12)
    assert needed(max(*ends, peak * (1 - 1e-9))) <= between * (1 + 1e-9)
    assert peak >= winding.speed * (1 - 1e-12) or needed(peak * (1 + 1e-6)) > between


@few
@given(windings(), st.floats(0.0, 0.999))
@example(LANDING, 0.95)
@example(BOTH, 0.05)
def test_emergency_stop_out_of_every_phase_comes_to_rest_within_its_limits(
    winding: Winding, share: float
) -> None:
    trip = s_curve(winding)
    at = share * trip.duration
    stopped = replace(winding, emergency_at=at)
    trajectory = s_curve(stopped)
    t = np.linspace(at, trajectory.duration, 301)
    s, v, a, j = trajectory.sample(t).T
    sign = math.copysign(1.0, winding.travel)
    # rounding of the segment sums, over sqrt where little speed is left
    assert np.min(sign * v) >= -1e-7
    assert np.max(np.abs(a)) <= stopped.emergency_deceleration * (1 + 1e-9)
    assert np.max(np.abs(j)) <= stopped.emergency_jerk * (1 + 1e-9)
    assert (v[-1], a[-1]) == (0.0, 0.0)
    assert abs(s[-1]) <= abs(winding.travel) * (1 + 1e-9)
    if at > 0.0:
        assert trajectory.at(0.999 * at) == trip.at(0.999 * at)


@trips
def test_each_derivative_is_the_difference_quotient_of_the_one_before(winding: Winding) -> None:
    trajectory = s_curve(winding)
    t = np.random.default_rng(1).uniform(0.0, trajectory.duration, 200)
    d = 1e-5 * trajectory.duration
    # central differences are off by d^2/6 times the third derivative, and only by rounding inside a segment
    distances = np.abs(t[:, None] - np.array(trajectory.starts))
    inside = (distances > 2 * d).all(axis=1)
    low, mid, high = (trajectory.sample(t[inside] + shift) for shift in (-d, 0.0, d))
    atol = d * d * winding.jerk / 6 + 1e-15 * (1.0 + abs(winding.travel)) / d * 20
    np.testing.assert_allclose((high[:, :3] - low[:, :3]) / (2 * d), mid[:, 1:], rtol=0, atol=atol)


#: v (v/a + a/j) = 90 m
PEAK = 0.375 * (math.sqrt(1.5**2 + 4 * 90 / 0.75) - 1.5)
# up to 4 m/s and down to 0.5 m/s with a / j = 1.5 s, stop from 0.5 m/s in two ramps of 1 s
UP = 4.0 / 0.75 + 1.5
DOWN = 3.5 / 0.75 + 1.5
CREPT = UP + (90.0 - 3.0 - 4.0 / 2 * UP - 4.5 / 2 * DOWN) / 4.0 + DOWN + (3.0 - 0.5) / 0.5 + 2.0


@pytest.mark.parametrize(
    ("winding", "peak", "duration"),
    [
        pytest.param(Winding(), PEAK, 1.0 + 2 * (PEAK / 0.75 + 1.5), id="90 m"),
        pytest.param(
            Winding(speed=4.0, start_delay=0.0, creep_distance=3.0, creep_speed=0.5),
            4.0,
            CREPT,
            id="creep",
        ),
        # v / d + d / j: constant deceleration with one ramp on either side
        pytest.param(
            Winding(speed=4.0, emergency_at=12.0), 4.0, 12.0 + 4.0 / 5.0 + 5.0 / 50.0, id="stop"
        ),
        # four jerk ramps of 1 s
        pytest.param(Winding(travel=1.0, start_delay=0.0), 0.5, 4.0, id="shortest"),
    ],
)
def test_a_trip_peaks_and_ends_as_in_the_textbook(
    winding: Winding, peak: float, duration: float
) -> None:
    trajectory = s_curve(winding)
    found = max(point.speed for point in trajectory.points)
    np.testing.assert_allclose([found, trajectory.duration], [peak, duration], rtol=1e-13)
