"""What goes wrong in a shaft, by name: each scenario shows what it is named for, by one number."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from hoist_demo.cases.scenarios import SCENARIOS
from hoist_demo.cases.table import CASES, find_case
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import rope_in_process
from hoist_demo.parameters import Coupling
from hoist_demo.recording.passages import passages
from hoist_demo.recording.time_series import Recording


@cache
def recorded(name: str) -> Recording:
    case = find_case(name)
    result = Host(rope_in_process(name), case.hoist, case.winding, Coupling(), case.gains).run()
    assert result.completed, result.cause
    return result.recording


def test_no_scenario_takes_the_name_of_a_case() -> None:
    assert not SCENARIOS.keys() & CASES.keys()
    with pytest.raises(ValueError, match=r"must be one of rope-120, .*caught-rope"):
        find_case("jam")


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


@pytest.mark.slow
def test_a_seized_swivel_holds_the_torque_that_a_healthy_one_lets_go() -> None:
    seized = recorded("seized-swivel")
    assert np.max(np.abs(np.diff(seized["left.swivel.angle"]))) == 0.0
    assert np.ptp(seized["right.swivel.angle"]) > 1.0


def test_a_rope_is_caught_by_a_divider_and_released() -> None:
    run = recorded("caught-rope")
    assert passages(run).startswith("the rope struck a divider")
    assert np.max(run["contact.divider"]) > 1000.0
    assert np.all(run["contact.divider"][-100:] == 0.0)
