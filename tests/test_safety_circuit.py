"""A guard of the rope's loop that trips stops the hoist, by the law of its winding, at the first sample to see it."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import rope_in_process
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Coupling, EmergencyLaw, Hoist, Winding
from hoist_demo.parameters.components import Brake
from hoist_demo.recording.incidents import guard_trip

WINDING = Winding(travel=20.0, settle=1.0)
BRAKED = Hoist(brake=Brake(torque=3e5))
#: m, as far as the loop of this trip is aside at about full speed
WINDOW = 0.6


@cache
def wound(law: EmergencyLaw = "drive", window: float = WINDOW, **run: Path) -> Result:
    rope = rope_in_process("rope-120", level="draft", parameters={"guard.window": window, "model.fidelity": 1})
    return Host(rope, BRAKED, replace(WINDING, emergency_law=law), Coupling()).run(**run)  # type: ignore[arg-type]


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
    travel = np.ptp(result.recording["conveyance.left.y"])
    assert travel < 0.95 * WINDING.travel
    assert abs(result.recording["drive.rate"][-1]) < 0.01
    if law == "torque":
        assert np.argmax(result.recording["drive.brake_torque"] > 0.0) > seen


def test_until_the_trip_the_run_is_that_without_the_guard() -> None:
    result, free = wound(), wound(window=1e3)
    seen = int(np.argmax(result.recording["guard.tripped"]))
    assert guard_trip(free.recording) is None
    for name in ("left.fy", "conveyance.left.y", "reference.position"):
        assert_array_equal(result.recording[name][:seen], free.recording[name][:seen])
    assert free.winding.emergency_at is None


def test_a_run_that_goes_on_stops_at_the_same_sample(tmp_path: Path) -> None:
    result, file = wound(), tmp_path / "good.npz"
    trip = guard_trip(result.recording)
    assert trip is not None

    def host() -> Host:
        rope = rope_in_process("rope-120", level="draft", parameters={"guard.window": WINDOW, "model.fidelity": 1})
        return Host(rope, BRAKED, WINDING, Coupling())

    for until in (trip.t - 0.5, trip.t + 1.5):
        stopped = host().run(lambda _, t, until=until: t < until, save_to=file)
        assert stopped.checkpoint is not None
        resumed = host().run(resume=stopped.checkpoint)
        assert resumed.winding == result.winding
        assert_array_equal(resumed.recording["conveyance.left.y"], result.recording["conveyance.left.y"])
