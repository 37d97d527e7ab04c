"""Cases: what is published is in the data, ropes fit their hoists, and every one winds within its limits."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hoist_at_rest import wind

from hoist_demo.cases.case import Case
from hoist_demo.cases.table import CASES
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data, rope_in_process
from hoist_demo.files.hoist_file import TAIL_SPARE
from hoist_demo.files.new import round_rope
from hoist_demo.parameters import require_trip_fits
from rope_model import EndMotion, Layout, Rope

INSTALLED = {name: case for name, case in CASES.items() if not name.startswith("rope-")}
cases = pytest.mark.parametrize("case", INSTALLED.values(), ids=INSTALLED.keys())

#: ropes must not slip: twice the friction at rest and a quarter more than the moving hoist asks for
STATIC_SAFETY, SAFETY = 1.75, 1.25


@cases
def test_the_balance_rope_is_that_of_the_hoist(case: Case) -> None:
    hoist = case.hoist
    assert case.rope["rope.length"] == hoist.tail_rope_length == hoist.shaft_travel + TAIL_SPARE
    assert case.rope["rope.mass_per_length"] == hoist.tail_rope_mass
    np.testing.assert_allclose(hoist.tail_mass / hoist.rope_mass, 1.0, rtol=1e-14)
    require_trip_fits(hoist, case.winding)


def test_the_known_rope_is_similar_to_itself() -> None:
    known = rope_data(round_rope(120.0, 8.0, 2.0, coupling=1.0))
    assert (known.rope, known.layout) == (Rope(), Layout())


@pytest.mark.parametrize(("name", "rpm"), [("kiruna-355", 64.7), ("kiruna-710", 100.0)])
def test_rope_speed_and_pulley_give_the_published_motor_speed(name: str, rpm: float) -> None:
    case = INSTALLED[name]
    found = case.winding.speed / case.hoist.sheave_radius * 30.0 / math.pi
    np.testing.assert_allclose(found, rpm, rtol=2e-3)  # the speed is published to two digits


def _assert_within_its_limits(run: dict[str, np.ndarray], case: Case) -> None:
    hoist, travel = case.hoist, case.winding.travel
    np.testing.assert_allclose(run["position"][-1], travel, rtol=0, atol=1e-3)
    assert np.max(np.abs(run["speed"])) < case.winding.speed + 0.05
    assert np.max(np.abs(run["torque"])) < hoist.torque_limit
    assert np.max(np.abs(run["power"])) < hoist.power_limit
    assert np.min(run["static_slip_safety"]) > STATIC_SAFETY
    assert np.min(run["slip_safety"]) > SAFETY
    # the integrator's 1e-9 on 1e9 J of energy that moves, over some thousand steps
    np.testing.assert_allclose(run["energy_residual"], 0.0, atol=1.0)


@cases
def test_a_short_trip_arrives_within_all_limits(case: Case) -> None:
    # from the upper landing: at the lower one the long ropes swing on for minutes
    winding = replace(case.winding, travel=-25.0, start_delay=0.0)
    run = wind(case.hoist, winding, case.gains, step=0.04)
    _assert_within_its_limits(run, replace(case, winding=winding))


@pytest.mark.slow
@cases
def test_the_whole_trip_arrives_within_all_limits(case: Case) -> None:
    _assert_within_its_limits(wind(case.hoist, case.winding, case.gains), case)


@pytest.mark.slow
def test_a_regulated_stop_from_full_speed_does_not_slip_and_the_full_torque_would() -> None:
    case, laws = INSTALLED["monopol-1000"], ("deceleration", "torque")
    trips = [replace(case.winding, emergency_at=40.0, emergency_law=law) for law in laws]
    regulated, sudden = (wind(case.hoist, trip, case.gains) for trip in trips)
    after = regulated["time"] > 40.0
    assert np.min(regulated["slip_safety"][after]) > 1.25
    assert np.min(sudden["slip_safety"][after]) < 1.0
    # 16 m/s and 2 m/s^2: v^2 / (2 a), and the dead time, lag and sampling before
    distance = regulated["position"][-1] - regulated["position"][after][0]
    np.testing.assert_allclose(distance, 16.0**2 / 4.0, rtol=0.05)


@pytest.mark.parametrize("name", INSTALLED)
def test_the_loop_does_not_turn_over_at_rest(name: str) -> None:
    rope = rope_in_process(name)
    assert rope.initialize(0.0, EndMotion(), EndMotion(y=INSTALLED[name].hoist.shaft_travel)).valid
    found = rope.reader(["loop.yaw"])().item()
    # the torque turns it one way, and by an angle at which the legs stay well apart
    assert 0.0 < found < math.radians(15.0)
