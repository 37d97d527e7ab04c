"""Shapers leave their mode at rest, a fit finds a given swing, the low-fidelity model is the plant, optima stay."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from drives import Plant, PlantInput

from hoist_demo.control.controller import Gains
from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.design.controllers import design_drive
from hoist_demo.design.low_fidelity import low_fidelity
from hoist_demo.design.optimal_trajectory import TrajectoryOptions, optimise
from hoist_demo.design.shaping import Shaper, impulses, shape
from hoist_demo.design.swing import fit_swing
from hoist_demo.design.tuning import Plan, Score, search
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.parameters.components import Brake, DriveShaft, Guides, Jam, Play, SheaveLining
from hoist_demo.run.data import build
from hoist_demo.run.metrics import measure

TRIP = Winding(travel=20.0, speed=3.0, jerk=2.0)
PLAN = Plan(sample=8, searches=2, steps=20, seed=1)
SHORT = Winding(travel=6.0, speed=2.0, jerk=2.0, start_delay=0.5)


def swing_after(trip: Trajectory, frequency: float, damping: float) -> float:
    """Amplitude that a damped oscillator, driven by the trip's acceleration, has left at its end."""
    w_d = 2 * math.pi * frequency
    pole = complex(-damping * w_d / math.sqrt(1 - damping**2), w_d)
    times = np.linspace(0.0, trip.duration, 40_001)
    a = trip.sample(times)[:, 2]
    return float(abs(np.trapezoid(a * np.exp(pole * (trip.duration - times)), times)))


@pytest.mark.parametrize("kind", ["ZV", "ZVD"])
def test_shaped_trip_leaves_the_mode_at_rest(kind: str) -> None:
    plain = s_curve(TRIP)
    shaper = Shaper(kind, frequency=0.9, damping=0.1)
    # what is left is the quadrature's error
    assert swing_after(shape(plain, shaper), 0.9, 0.1) < 1e-6 * swing_after(plain, 0.9, 0.1)


def test_shaped_trip_is_the_convolution_at_any_time() -> None:
    plain = s_curve(TRIP)
    shaper = Shaper("ZVD", 1.3, 0.05)
    shaped = shape(plain, shaper)
    for t in np.linspace(0.0, shaped.duration + 0.5, 301):
        expected = sum(
            weight * plain.at(float(t) - delay).position for delay, weight in impulses(shaper)
        )
        assert shaped.at(float(t)).position == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("frequency", "damping"), [(1.5, 0.03), (1.6, 0.15), (3.0, 0.0)])
def test_fitted_swing_is_the_given_one(frequency: float, damping: float) -> None:
    t = np.arange(0.0, 5.0, 0.01)
    decay = damping * 2 * math.pi * frequency / math.sqrt(1 - damping**2)
    found = fit_swing(
        t, 0.3 + 1e-3 * t + 2e-3 * np.exp(-decay * t) * np.cos(2 * math.pi * frequency * t + 0.4)
    )
    assert (found.frequency, found.damping) == pytest.approx((frequency, damping), abs=1e-4)
    assert found.amplitude == pytest.approx(2e-3, rel=1e-3)


def test_low_fidelity_without_balance_rope_accelerates_as_the_plant() -> None:
    hoist = Hoist(tail_rope_mass=0.0)
    gains = Gains(feed_forward=0.0)
    model = low_fidelity(hoist, gains, 0.0, 90.0)
    plant = Plant(hoist)
    state = plant.equilibrium(0.0, 90.0, 0.0, 0.0)
    R = hoist.sheave_radius
    moved = np.array([1.0e4, 3.0 / R, 3.01, 87.005, 1.5 / R, 1.51, -1.49])
    x = np.array([3.0, 1.5, 0.0, 3.0, 3.01, -2.995, 1.5, 1.51, -1.49, 1.0e4 / R, 0.0])
    rates = plant.rates(
        type(state)(moved, state.work_totals[:5], state.free_lengths), PlantInput(0.0, 0.0, 0.0)
    )
    found = np.asarray(model.rates(x, 0.0)).ravel()
    np.testing.assert_allclose(found[6:9], rates[4:7] * np.array([R, 1.0, 1.0]), rtol=1e-9)


EVERYTHING = Hoist(
    head_rope_modes=1,
    drive_shaft=DriveShaft(),
    brake=Brake(),
    lining=SheaveLining(),
    guides=Guides(),
    play=Play(),
    jam_left=Jam(),
    jam_right=Jam(),
    power_limit=1e6,
)


@pytest.mark.parametrize("hoist", [Hoist(), EVERYTHING], ids=["plain", "everything"])
def test_low_fidelity_stays_at_rest_whatever_parts_the_hoist_has(hoist: Hoist) -> None:
    left_out = {name for name, part in vars(EVERYTHING).items() if part is None}
    assert left_out == {"conveyance_mass_right", "slack_tension"}, (
        "a part that is new belongs into EVERYTHING"
    )
    model = low_fidelity(hoist, Gains(), 0.0, 90.0)
    assert np.max(np.abs(np.asarray(model.rates(model.start, 0.0)))) < 1e-9


def test_optimised_trip_keeps_the_limits_and_arrives() -> None:
    trip = optimise(Hoist(), SHORT, Gains(), TrajectoryOptions(intervals=60))
    assert trip.starts[0] == SHORT.start_delay
    rows = trip.sample(np.linspace(0.0, trip.duration - 1e-9, 2001))
    bounds = np.array([SHORT.speed, SHORT.acceleration, SHORT.jerk])
    # between the intervals' ends the speed may pass its bound by j dt^2 / 8 = 0.3 mm/s
    assert np.all(
        np.max(np.abs(rows[:, 1:]), axis=0) <= bounds * (1 + 1e-6) + np.array([2e-3, 0.0, 0.0])
    )
    # the solver's tolerance, on the scaled states
    assert rows[-1, :3] == pytest.approx([SHORT.travel, 0.0, 0.0], abs=1e-4)


def bowl(x: np.ndarray) -> float:
    return float(np.sum((x - [0.3, 0.8]) ** 2))


@pytest.mark.parametrize(
    ("judge", "best", "kept"),
    [
        pytest.param(
            lambda x: Score(math.inf if x[0] > 0.9 else bowl(x)),
            [0.3, 0.8],
            True,
            id="past failing points",
        ),
        pytest.param(
            lambda x: Score(bowl(x), (2.0 * (float(x[1]) - 0.5),)),
            [0.3, 0.5],
            True,
            id="within a bound",
        ),
        pytest.param(
            lambda x: Score(float(x[0]), (1.5 - float(x[0]),)),
            [1.0],
            False,
            id="nearest to its bounds",
        ),
    ],
)
def test_search_finds_the_minimum(
    judge: Callable[[np.ndarray], Score], best: list[float], kept: bool
) -> None:
    found = search(lambda points: [judge(x) for x in points], len(best), PLAN)
    assert len(found.points) <= PLAN.sample + PLAN.searches * PLAN.steps
    assert found.scores[found.best].feasible == kept
    assert found.points[found.best] == pytest.approx(best, abs=1e-2)


def test_shaper_takes_the_swing_that_a_trip_leaves() -> None:
    run = build("rope-120", {"winding.jerk": 3.0, "controller": "input-shaping"})
    rope = InProcessRope(rope_scene(run.rope_values, "draft"))
    result = Host(rope, run.hoist, run.winding, run.coupling, run.gains).run()
    metrics = measure(result, run.hoist, run.arrival).metrics
    # a guard may stop what a file may not
    stopped = replace(run, winding=replace(run.winding, emergency_at=1.0))
    assert design_drive(stopped)
    # friction at the rim is viscous only far below its speed of 20 mm/s: it is less in a swing of some mm
    assert run.shaper.frequency == pytest.approx(metrics["swing_frequency"], rel=0.06)
    assert run.shaper.damping == pytest.approx(metrics["swing_damping"], rel=0.15)
