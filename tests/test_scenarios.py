"""What goes wrong in a shaft, by name: each scenario shows what it is named for, by one number."""

from __future__ import annotations

import argparse
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from hoist_demo.cases.scenarios import SCENARIOS
from hoist_demo.cases.table import CASES, find_case
from hoist_demo.command_line.demo import _winding, add_demo
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import rope_in_process
from hoist_demo.cosimulation.result import Result
from hoist_demo.parameters import GRAVITY, Coupling
from hoist_demo.parameters.components import Jam, Lining
from hoist_demo.recording.jams import jams, slack_ropes
from hoist_demo.recording.passages import passages
from hoist_demo.recording.slip import slip
from hoist_demo.recording.time_series import Recording
from hoist_demo.report.events import marks
from hoist_demo.report.rows import WARNING
from hoist_demo.report.summary import summarize


@cache
def wound(name: str) -> Result:
    case = find_case(name)
    result = Host(rope_in_process(name), case.hoist, case.winding, Coupling(), case.gains).run()
    assert result.completed, result.cause
    return result


def recorded(name: str) -> Recording:
    return wound(name).recording


def test_no_scenario_takes_the_name_of_a_case() -> None:
    assert not SCENARIOS.keys() & CASES.keys()
    with pytest.raises(ValueError, match=r"must be one of rope-120, .*caught-rope"):
        find_case("jam")


@pytest.mark.parametrize("name", ["rope-120", *SCENARIOS])
def test_a_quick_run_leaves_a_scenario_its_trip(name: str) -> None:
    parser = argparse.ArgumentParser()
    add_demo(parser.add_subparsers(), Path())
    asked = _winding(parser.parse_args(["demo", "--quick", "--case", name]))
    assert asked["winding.settle"] == 2.0
    assert asked.get("winding.travel") == (None if name in SCENARIOS else 10.0)


def test_an_overwound_loop_comes_within_4_m_of_the_end() -> None:
    run, rope = recorded("overwind"), find_case("overwind").rope["rope.length"]
    left, right = (run[f"conveyance.{side}.y"][-1] for side in ("left", "right"))
    # arc length of the lowest point by the heights of the ends
    assert rope - 0.5 * (rope + left - right) == pytest.approx(4.0, abs=0.05)
    # down there hangs little more than that leg, and half of the loop's width
    assert -run["right.fy"][-1] < 5.0 * 8.0 * 9.81


@pytest.mark.slow
def test_a_rope_braked_harder_than_gravity_goes_slack() -> None:
    run = recorded("slack-rope")
    assert np.min(run["conveyance.left.ay"]) < -9.81
    assert np.max(run["left.fy"]) > 0.0  # it pushes where it should hang
    hanging = -run["left.fy"][0]
    assert np.max(-run["left.fy"]) > 3.0 * hanging  # the jerk when it falls back
    # slack legs bend between the places that the clearance looks at: what presses is told all the same
    pressed = int(np.argmax(run["contact.rope"] > 0.0))
    assert pressed > 0
    assert run["loop.overlap"][-1] > 0.0
    assert run["loop.touched_at"][-1] <= run.time[pressed]
    assert passages(run).startswith("the rope struck its other leg (from t = ")


@pytest.mark.slow
def test_head_ropes_that_slip_keep_the_rope_taut_under_the_same_brake() -> None:
    case = find_case("slack-rope")
    hoist = replace(case.hoist, lining=Lining())
    run = Host(rope_in_process("slack-rope"), hoist, case.winding, Coupling(), case.gains).run().recording
    slid = slip(run)
    assert slid is not None
    assert slid.way == pytest.approx(2.0, abs=0.05)
    assert np.min(run["conveyance.left.ay"]) > -GRAVITY
    assert max(np.max(run["left.fy"]), np.max(run["right.fy"])) < 0.0
    assert not slack_ropes(run)
    assert passages(run) == ""


@pytest.mark.slow
def test_a_seized_swivel_holds_the_torque_that_a_healthy_one_lets_go() -> None:
    seized = recorded("seized-swivel")
    assert np.max(np.abs(np.diff(seized["left.swivel.angle"]))) == 0.0
    assert np.ptp(seized["right.swivel.angle"]) > 1.0


@pytest.mark.slow
def test_a_rope_is_caught_by_a_divider_and_released() -> None:
    run = recorded("caught-rope")
    assert passages(run).startswith("the rope struck a divider")
    assert np.max(run["contact.divider"]) > 1000.0
    assert np.all(run["contact.divider"][-100:] == 0.0)


@pytest.mark.slow
def test_a_jammed_conveyance_opens_the_safety_circuit_by_its_slack_head_ropes() -> None:
    case, run = find_case("jammed-conveyance"), recorded("jammed-conveyance")
    (jam,) = jams(run)
    assert (jam.side, jam.way is not None) == ("right", True)
    assert jam.way is not None
    assert jam.way < Jam().distance
    assert case.hoist.jam_right is not None
    stuck = run["conveyance.right.y"]
    behind = (run.time > jam.t + 0.5) & (run.time < jam.t + 1.5)
    assert stuck[behind] == pytest.approx(jam.height - jam.way, abs=case.hoist.jam_right.travel)
    # the other one falls back into its ropes, whose jerk pulls it up, but not out
    assert np.max(run["drive.pull_right"]) > 2.0 * case.hoist.mass_right * GRAVITY
    assert stuck[-1] < case.hoist.jam_right.height + Jam().distance
    # its ropes go slack by what the other conveyance rises until it stops
    low = run["drive.pull_right"] < case.hoist.slack_tension
    seen = int(np.argmax(low))
    assert jam.t < run.time[seen] < jam.t + 0.2
    rises = run["conveyance.left.y"][seen:] - run["conveyance.left.y"][seen]
    assert np.max(run["drive.slack_right"]) == pytest.approx(np.max(rises), rel=0.3)
    assert np.min(run["drive.pull_right"]) == 0.0
    assert run["drive.brake_torque"][seen] == 0.0
    assert abs(run["drive.rate"][-1]) < 0.01
    # the rope's end stops hard
    assert np.max(-run["right.fy"]) > 4.0 * -run["right.fy"][seen - 20]
    assert np.max(np.abs(run["drive.energy_residual"])) < 1e-3
    # without friction's limit the ratio reaches 170
    assert np.max(run["drive.tension_ratio"]) < case.hoist.tension_ratio_limit
    slid = slip(run)
    assert slid is not None
    assert run.time[seen] - 0.2 < slid.t < run.time[seen]
    assert slid.way > np.max(rises)


@pytest.mark.slow
def test_summary_and_report_tell_how_a_conveyance_jammed() -> None:
    case, run = find_case("jammed-conveyance"), wound("jammed-conveyance")
    rows = {(row.group, row.quantity): row for row in summarize(run, case.hoist, run.winding, Coupling())}
    told, jam, slack = rows["Outcome", "status"].text, jams(run.recording)[0], slack_ropes(run.recording)[0]
    assert f"; the right conveyance jammed at t = {jam.t:.4g} s; " in told
    assert f"; the head ropes of the right conveyance were slack from t = {slack.t:.4g} s on" in told
    assert "; the head ropes slipped " in told
    # slack legs fall against each other, and do not pass through each other
    assert "but the rope struck its other leg (from t = " in told
    assert "passed" not in told
    seen = float(rows["Slack head ropes", "seen by the safety circuit at"].value)
    assert seen == pytest.approx(run.winding.emergency_at)
    assert ("After the jam, 10 s", "largest pull on a conveyance") in rows
    push = float(rows["Balance rope", "slack, it pushes the right conveyance up by (a real one gives way)"].value)
    assert push == pytest.approx(1e-3 * np.max(run.recording["right.fy"]))
    marked = marks(run, run.winding)
    labels, times = [mark.label for mark in marked], [mark.t for mark in marked]
    assert labels[:4] == ["right conveyance jams", "head ropes slip", "emergency stop", "right head ropes slack"]
    assert ("Head ropes that slipped", "way on the sheave") in rows
    assert not [row for row in rows if row[1] == WARNING and "slip" in rows[row].text]
    assert times == sorted(times)
