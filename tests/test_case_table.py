"""The table of cases: every one starts and winds, its rope is the one that it names, and users are told the names."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fmu_src.interface import case_with, variables
from hoist_demo.cases.table import CASES
from hoist_demo.cosimulation.drive_signals import exchange_energy
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data, rope_in_process
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import GRAVITY, Coupling
from rope_model import Scene, parameters, rope_120
from rope_model.scene_names import with_values

every_scene = pytest.mark.parametrize("name", CASES)


@every_scene
def test_the_fmu_reads_the_case_s_parameters_as_the_rope_in_process_does(name: str) -> None:
    values = {v.name: v.start for v in variables(rope_120()) if v.causality == "parameter" and v.start is not None}
    assert CASES[name].rope.keys() <= values.keys()
    del values["inputs_at_step_end"]
    assert with_values(Scene(), {**values, **CASES[name].rope}) == rope_data(CASES[name].rope)


@every_scene
@pytest.mark.parametrize("level", ["draft", "standard"])
def test_an_export_of_a_case_starts_with_its_rope_and_its_travel(name: str, level: parameters.Level) -> None:
    case = CASES[name]
    exported = case_with("rope-120", level, {**case.rope, "right.y": abs(case.winding.travel)})
    assert exported.scene == rope_data(case.rope, level)
    starts = {v.name: v.start for v in variables(exported)}
    assert starts["right.y"] == abs(case.winding.travel)
    assert {key: starts[key] for key in case.rope} == pytest.approx(dict(case.rope))


@cache
def start(name: str) -> tuple[Host, Result]:
    """A host and its run over 50 steps of the case's trip, which begins at once."""
    case, rope = CASES[name], rope_in_process(name, level="draft")
    host = Host(rope, case.hoist, replace(case.winding, start_delay=0.0), Coupling(), case.gains)
    return host, host.run(lambda fraction, t: t < 0.495)


@every_scene
def test_every_case_starts_with_the_weight_of_its_rope_and_makes_fifty_steps(name: str) -> None:
    host, result = start(name)
    assert result.steps == 50
    assert result.cause.endswith("stopped by the user")
    assert result.warning == ""
    r, hoist = result.recording, host.hoist
    left, right, weight = r["left.fy"][0], r["right.fy"][0], GRAVITY * hoist.tail_rope_mass
    assert_allclose(left + right, -weight * hoist.tail_rope_length, rtol=1e-6)
    # the legs differ by the height, but for the strain (1e-4) and the slant of legs that meet in a loop
    assert_allclose(left - right, weight * hoist.shaft_travel, rtol=2e-3)
    # the rim follows the reference, jerk t^3 / 6, within what the swinging ropes turn it back and forth
    asked = host.winding.jerk * r.time[-1] ** 3 / 6.0
    assert_allclose(hoist.sheave_radius * (r["drive.angle"][-1] - r["drive.angle"][0]), asked, atol=5e-3)


def test_slip_safety_and_motor_power_are_recorded() -> None:
    host, result = start("rope-120")
    r, limit = result.recording, host.hoist.tension_ratio_limit
    assert_allclose(r["drive.slip_safety"], (limit - 1.0) / (r["drive.tension_ratio"] - 1.0), rtol=1e-12)
    # of a rigid shaft
    assert_allclose(r["drive.motor_power"], r["drive.torque"] * r["drive.rate"], rtol=1e-12)
    assert not np.any(r["drive.brake_torque"])


def test_what_the_hoist_gives_is_what_all_its_balance_ropes_get() -> None:
    host, result = start("kiruna-355")
    assert host.hoist.tail_rope_number == 3
    work = result.recording["drive.work_from_balance_rope"]
    assert np.max(np.abs(work)) > 1e3
    # the exchange makes up 4e-5 of it; with the work on one rope only, two thirds would be missing
    assert_allclose(exchange_energy(result.recording, host.hoist), 0.0, atol=1e-3 * np.max(np.abs(work)))
