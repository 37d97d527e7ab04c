"""What goes wrong in a shaft, by name; and a guard of the loop that trips stops the hoist by the law of its winding."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from rope_groups import rope_in_process

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import GRAVITY, Coupling, EmergencyLaw, Hoist, Winding
from hoist_demo.parameters.components import Brake, Jam
from hoist_demo.recording.incidents import guard_trip, jams, slip
from hoist_demo.recording.passages import passages
from hoist_demo.recording.time_series import Recording


@cache
def recorded(name: str) -> Recording:
    case = find_case(name)
    result = Host(rope_in_process(name), case.hoist, case.winding, Coupling(), case.gains).run()
    assert result.completed, result.cause
    return result.recording


def test_an_overwound_loop_comes_within_4_m_of_the_end() -> None:
    run = recorded("overwind")
    rope = find_case("overwind").rope["rope.length"]
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
    assert np.max(-run["left.fy"]) > 3.0 * -run["left.fy"][0]  # the jerk when it falls back
    # slack legs bend between the places that the clearance looks at: what presses is told all the same
    pressed = int(np.argmax(run["contact.rope"] > 0.0))
    assert pressed > 0
    assert run["loop.overlap"][-1] > 0.0
    assert run["loop.touched_at"][-1] <= run.time[pressed]
    assert passages(run).startswith("the rope struck its other leg (from t = ")


@pytest.mark.slow
def test_a_rope_is_caught_by_a_divider_and_released() -> None:
    run = recorded("caught-rope")
    assert passages(run).startswith("the rope struck a divider")
    assert np.max(run["contact.divider"]) > 1000.0
    assert np.all(run["contact.divider"][-100:] == 0.0)


@pytest.mark.slow
def test_a_jammed_conveyance_opens_the_safety_circuit_by_its_slack_head_ropes() -> None:
    case = find_case("jammed-conveyance")
    run = recorded("jammed-conveyance")
    (jam,) = jams(run)
    assert jam.side == "right"
    assert jam.stopping_distance is not None
    assert jam.stopping_distance < Jam().distance
    assert case.hoist.jam_right is not None
    stuck = run["conveyance.right.y"]
    behind = (run.time > jam.t + 0.5) & (run.time < jam.t + 1.5)
    assert stuck[behind] == pytest.approx(
        jam.height - jam.stopping_distance, abs=case.hoist.jam_right.travel
    )
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
    assert slid.slid_distance > np.max(rises)


WINDING = Winding(travel=20.0, settle=1.0)
BRAKED = Hoist(brake=Brake(torque=3e5))
#: m, as far as the loop of this trip is aside at about full speed
WINDOW = 0.6


def host(law: EmergencyLaw = "drive", window: float = WINDOW) -> Host:
    rope = rope_in_process(
        "rope-120", level="draft", parameters={"guard.window": window, "model.fidelity": 1}
    )
    return Host(rope, BRAKED, replace(WINDING, emergency_law=law), Coupling(step=0.02))


@cache
def wound(law: EmergencyLaw = "drive", window: float = WINDOW) -> Result:
    return host(law, window).run()


@pytest.mark.parametrize("law", ["drive", "torque"])
def test_the_hoist_stops_from_the_first_sample_that_sees_the_trip(law: EmergencyLaw) -> None:
    result = wound(law)
    trip = guard_trip(result.recording)
    assert result.completed
    assert trip is not None
    assert trip.cause == "window"
    seen = int(np.argmax(result.recording["guard.tripped"]))
    assert result.recording.time[seen - 1] < trip.t <= result.recording.time[seen]
    assert result.winding.emergency_at == pytest.approx(result.recording.time[seen], abs=1e-12)
    # it stops short of its landing, sooner than without the guard
    assert np.ptp(result.recording["conveyance.left.y"]) < 0.95 * WINDING.travel
    assert abs(result.recording["drive.rate"][-1]) < 0.01
    if law == "torque":
        assert np.argmax(result.recording["drive.brake_torque"] > 0.0) > seen


def test_a_run_that_goes_on_stops_at_the_same_sample(tmp_path: Path) -> None:
    result = wound()
    file = tmp_path / "good.npz"
    trip = guard_trip(result.recording)
    assert trip is not None
    for until in (trip.t - 0.5, trip.t + 1.5):
        stopped = host().run(lambda _, t, until=until: t < until, save_to=file)
        assert stopped.checkpoint is not None
        resumed = host().run(resume=stopped.checkpoint)
        assert resumed.winding == result.winding
        assert_array_equal(
            resumed.recording["conveyance.left.y"], result.recording["conveyance.left.y"]
        )
