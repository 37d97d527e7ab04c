"""Cases: published data, ropes that fit their hoists and are the exported ones, windings within the limits."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from drives import wind
from numpy.testing import assert_allclose
from rope_groups import rope_in_process

from fmu_src.interface import case_with, variables
from hoist_demo.cases.case import HOISTS, Case
from hoist_demo.cases.rules import TAIL_SPARE
from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import GRAVITY, Coupling, require_trip_fits
from hoist_demo.run.metrics import exchange_energy
from rope_model import EndMotion, Level

INSTALLED = {name: find_case(name) for name in HOISTS if not name.startswith("rope-")}
every_scene = pytest.mark.parametrize("name", HOISTS)
cases = pytest.mark.parametrize("case", INSTALLED.values(), ids=INSTALLED.keys())

#: ropes must not slip: twice the friction at rest and a quarter more than the moving hoist asks for
STATIC_SAFETY = 1.75
SAFETY = 1.25


@cases
def test_the_balance_rope_is_that_of_the_hoist(case: Case) -> None:
    hoist = case.hoist
    assert case.rope["rope.length"] == hoist.tail_rope_length == hoist.shaft_travel + TAIL_SPARE
    assert case.rope["rope.mass_per_length"] == hoist.tail_rope_mass
    assert_allclose(hoist.tail_mass / hoist.rope_mass, 1.0, rtol=1e-14)
    require_trip_fits(hoist, case.winding)


@pytest.mark.parametrize(("name", "rpm"), [("kiruna-355", 64.7), ("kiruna-710", 100.0)])
def test_rope_speed_and_pulley_give_the_published_motor_speed(name: str, rpm: float) -> None:
    case = INSTALLED[name]
    found = case.winding.speed / case.hoist.sheave_radius * 30.0 / math.pi
    assert_allclose(found, rpm, rtol=2e-3)  # the speed is published to two digits


# the short one from the upper landing: at the lower one the long ropes swing on for minutes
@pytest.mark.parametrize("short", [True, pytest.param(False, marks=pytest.mark.slow)])
@cases
def test_a_trip_arrives_within_all_limits(case: Case, short: bool) -> None:
    hoist = case.hoist
    winding = case.winding
    step = 0.02
    if short:
        winding = replace(winding, travel=-25.0, start_delay=0.0)
        step = 0.04
    run = wind(hoist, winding, case.gains, step=step)
    assert_allclose(run["position"][-1], winding.travel, rtol=0, atol=1e-3)
    assert np.max(np.abs(run["speed"])) < case.winding.speed + 0.05
    assert np.max(np.abs(run["torque"])) < hoist.torque_limit
    assert np.max(np.abs(run["power"])) < hoist.power_limit
    assert np.min(run["static_slip_safety"]) > STATIC_SAFETY
    assert np.min(run["slip_safety"]) > SAFETY
    # steps mostly err by far less than their bound of 1e-8, here of 1e9 J that moves
    assert_allclose(run["energy_residual"], 0.0, atol=1.0)


@pytest.mark.slow
def test_a_regulated_stop_from_full_speed_does_not_slip_and_the_full_torque_would() -> None:
    case = INSTALLED["monopol-1000"]
    laws = ("deceleration", "torque")
    trips = [replace(case.winding, emergency_at=40.0, emergency_law=law) for law in laws]
    regulated, sudden = (wind(case.hoist, trip, case.gains) for trip in trips)
    after = regulated["time"] > 40.0
    assert np.min(regulated["slip_safety"][after]) > 1.25
    assert np.min(sudden["slip_safety"][after]) < 1.0
    # 16 m/s and 2 m/s^2: v^2 / (2 a), and the dead time, lag and sampling before
    assert_allclose(
        regulated["position"][-1] - regulated["position"][after][0], 16.0**2 / 4.0, rtol=0.05
    )


@pytest.mark.parametrize("name", INSTALLED)
def test_the_loop_does_not_turn_over_at_rest(name: str) -> None:
    rope = rope_in_process(name)
    assert rope.initialize(0.0, EndMotion(), EndMotion(y=INSTALLED[name].hoist.shaft_travel)).valid
    found = rope.reader(["loop.yaw"])().item()
    # the torque turns it one way, and by an angle at which the legs stay well apart
    assert 0.0 < found < math.radians(15.0)


@every_scene
@pytest.mark.parametrize("level", ["draft", "standard"])
def test_an_export_of_a_case_starts_with_its_rope_and_its_travel(name: str, level: Level) -> None:
    case = find_case(name)
    exported = case_with("rope-120", level, {**case.rope, "right.y": abs(case.winding.travel)})
    assert exported.scene == rope_scene(case.rope, level)
    starts = {v.name: v.start for v in variables(exported)}
    assert starts["right.y"] == abs(case.winding.travel)
    assert {key: starts[key] for key in case.rope} == pytest.approx(dict(case.rope))


@cache
def start(name: str) -> tuple[Host, Result]:
    """A host and its run over 50 steps of the case's trip, which begins at once."""
    case = find_case(name)
    rope = rope_in_process(name, level="draft")
    host = Host(rope, case.hoist, replace(case.winding, start_delay=0.0), Coupling(), case.gains)
    return host, host.run(lambda fraction, t: t < 0.495)


@every_scene
def test_every_case_starts_with_the_weight_of_its_rope_and_makes_fifty_steps(name: str) -> None:
    host, result = start(name)
    assert (result.steps, result.warning) == (50, "")
    assert result.cause.endswith("stopped by the user")
    r = result.recording
    hoist = host.plan.hoist
    left = r["left.fy"][0]
    right = r["right.fy"][0]
    weight = GRAVITY * hoist.tail_rope_mass
    assert_allclose(left + right, -weight * hoist.tail_rope_length, rtol=1e-6)
    # the legs differ by the height, but for the strain (1e-4) and the slant of legs that meet in a loop
    assert_allclose(left - right, weight * hoist.shaft_travel, rtol=2e-3)
    # the rim follows the reference, jerk t^3 / 6, within what the swinging ropes turn it back and forth
    asked = host.plan.winding.jerk * r.time[-1] ** 3 / 6.0
    assert_allclose(
        hoist.sheave_radius * (r["drive.angle"][-1] - r["drive.angle"][0]), asked, atol=5e-3
    )


def test_slip_safety_and_motor_power_are_recorded() -> None:
    host, result = start("rope-120")
    r = result.recording
    limit = host.plan.hoist.tension_ratio_limit
    assert_allclose(
        r["drive.slip_safety"], (limit - 1.0) / (r["drive.tension_ratio"] - 1.0), rtol=1e-12
    )
    # of a rigid shaft
    assert_allclose(r["drive.motor_power"], r["drive.torque"] * r["drive.rate"], rtol=1e-12)
    assert not np.any(r["drive.brake_torque"])


def test_what_the_hoist_gives_is_what_all_its_balance_ropes_get() -> None:
    host, result = start("kiruna-355")
    assert host.plan.hoist.tail_rope_number == 3
    work = result.recording["drive.work_from_balance_rope"]
    assert np.max(np.abs(work)) > 1e3
    # the exchange makes up 4e-5 of it; with the work on one rope only, two thirds would be missing
    assert_allclose(
        exchange_energy(result.recording, host.plan.hoist), 0.0, atol=1e-3 * np.max(np.abs(work))
    )
