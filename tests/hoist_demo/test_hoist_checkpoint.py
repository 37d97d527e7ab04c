"""A controller with a memory of its own is stopped, saved, read and resumed as if it had never stopped."""

import io
import json
import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal
from rope_groups import rope_in_process

from hoist_demo.control.controller import Command, Controller, Gains, Measurement
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.identity import (
    Identity,
    differences,
    named_values,
)
from hoist_demo.cosimulation.participants.plain_data import decode, encode
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Coupling, Hoist, Winding
from hoist_demo.parameters.components import SheaveLining

TRIP = Winding(travel=0.5, settle=0.0, start_delay=0.0)
#: its pulls swing by a quarter of the weight
QUICK_TRIP = replace(TRIP, travel=1.0, acceleration=1.5, jerk=10.0)
GAINS = Gains()
#: N, of 98 kN at rest on the lighter side
SLACK = 9e4


class Filter(NamedTuple):
    speed: float  # m/s


@dataclass
class Remembered:
    """What Filtered carries from sample to sample."""

    integral: float = 0.0  # N
    filter: Filter = field(default_factory=lambda: Filter(0.0))
    errors: list[float] = field(default_factory=list)  # m/s, the last three
    seen: np.ndarray[Any, np.dtype[np.float64]] = field(
        default_factory=lambda: np.zeros(2)
    )  # least and largest error


class Filtered:
    """Integrator on the mean of the last errors of a filtered speed; changes what it is handed."""

    def __init__(self, hoist: Hoist, holding_torque: float) -> None:
        self._hoist = hoist
        self._holding_torque = holding_torque

    def command(
        self, trajectory: TrajectoryPoint, measured: Measurement, state: Remembered | None, h: float
    ) -> Command:
        if state is None:
            state = Remembered()
        state.filter = Filter(state.filter.speed + h / 0.05 * (measured.speed - state.filter.speed))
        state.errors.append(trajectory.speed - state.filter.speed)
        del state.errors[:-3]
        mean = sum(state.errors) / len(state.errors)
        state.seen = np.array([min(state.seen[0], mean), max(state.seen[1], mean)])
        state.integral += h * 2e5 * mean
        wanted = self._hoist.moving_mass * trajectory.acceleration + 2e5 * mean + state.integral
        return Command(self._holding_torque + self._hoist.sheave_radius * wanted, False, state)


Made = Callable[[Hoist, float], Controller]


def wind(
    controller: Made, stop_at: float = math.inf, coupling: Coupling | None = None, **options: Any
) -> Result:
    """A short trip with the draft rope, until ``stop_at`` [s]."""
    host = Host(
        rope_in_process("rope-120", level="draft"), Hoist(), TRIP, coupling, controller=controller
    )
    return host.run(lambda fraction, t: t < stop_at, **options)


STOPPED = [(0.3, Coupling()), (1.1, Coupling()), (0.5, Coupling(step=0.02, sample=0.01))]


@pytest.mark.parametrize(("stop_at", "coupling"), STOPPED)
def test_a_controller_with_a_memory_of_its_own_resumes_to_the_same_bits(
    stop_at, coupling, tmp_path: Path
) -> None:
    whole = wind(Filtered, coupling=coupling)
    stopped = wind(Filtered, stop_at, save_to=tmp_path / "kept.npz", coupling=coupling)
    assert stopped.saved is not None
    kept = Checkpoint.read(stopped.saved)
    assert kept.controller.errors != [0.0, 0.0, 0.0]
    for _ in range(2):  # resuming does not change the checkpoint
        resumed = wind(Filtered, resume=kept, coupling=coupling)
        assert resumed.completed
        for name, values in whole.recording.signals.items():
            assert_array_equal(resumed.recording[name], values, name)
    other = Coupling(step=0.03 - coupling.step)
    changed = rf"coupling\.period is {coupling.period} there, {other.period} here: give"
    with pytest.raises(ValueError, match=changed):
        wind(Filtered, resume=kept, coupling=other)


def test_an_emergency_stop_goes_on_when_the_pull_that_asked_for_it_is_there_again() -> None:
    def stopped_for_slack(stop_at: float = math.inf, resume: Checkpoint | None = None) -> Result:
        hoist = Hoist(slack_tension=SLACK)
        host = Host(rope_in_process("rope-120", level="draft"), hoist, QUICK_TRIP)
        return host.run(lambda fraction, t: t < stop_at, resume=resume)

    whole = stopped_for_slack()
    begun = whole.winding.emergency_at
    assert begun is not None
    pulls = [whole.recording[f"drive.pull_{side}"] for side in ("left", "right")]
    low = (np.minimum(*pulls) < SLACK).nonzero()[0]
    later = whole.recording["time"][low[-1] + 1]
    stopped = stopped_for_slack(later + 0.05)
    assert stopped.checkpoint is not None
    resumed = stopped_for_slack(resume=stopped.checkpoint)
    assert resumed.winding.emergency_at == begun
    for name, values in whole.recording.signals.items():
        assert_array_equal(resumed.recording[name], values, name)


class Hoarder:
    """Remembers its samples in a deque, at once or from the third one on."""

    def __init__(self, begins: int) -> None:
        self._begins = begins

    def command(
        self, trajectory: TrajectoryPoint, measured: Measurement, state: Any, h: float
    ) -> Command:
        count = 0
        if state is not None:
            count = state["count"]
        last = None
        if count >= self._begins:
            last = deque([1.0])
        return Command(0.0, False, {"count": count + 1, "last": last})


def test_what_cannot_be_saved_is_refused_at_the_first_sample_with_its_place(tmp_path: Path) -> None:
    with pytest.raises(
        ValueError, match=r"the controller's state\['last'\] is of type deque.*plain data \(numbers"
    ):
        wind(lambda *_: Hoarder(0), save_to=tmp_path / "kept.npz")
    # nothing is to be written without a file
    assert wind(lambda *_: Hoarder(0), 0.1).checkpoint is not None


def there_and_back(value: Any) -> Any:
    """Write and read it, as a checkpoint does."""
    arrays = dict[str, np.ndarray]()
    file = io.BytesIO()
    text = json.dumps(encode(value, "x", arrays))
    np.savez(file, text=text, **arrays)
    with np.load(io.BytesIO(file.getvalue()), allow_pickle=False) as kept:
        return decode(json.loads(text), {name: kept[name] for name in kept.files})


plain = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False)
    | st.text(st.characters(exclude_categories=["Cs"]))
    | st.binary(),
    lambda inside: (
        st.lists(inside, max_size=3)
        | st.lists(inside, max_size=3).map(tuple)
        | st.dictionaries(
            st.text() | st.integers() | st.tuples(st.booleans(), st.integers()), inside, max_size=3
        )
        | st.builds(Remembered, errors=inside, seen=inside)
        | st.builds(Filter, inside)
    ),
    max_leaves=8,
)


@given(plain)
@settings(max_examples=15)  # each of some eight leaves
def test_plain_data_come_back_equal_and_of_the_same_kind(value: Any) -> None:
    back = there_and_back(value)
    assert back == value
    assert repr(back) == repr(value)


OF_NUMPY = (
    np.float64(0.1),
    np.float32(math.nan),
    np.arange(6).reshape(2, 3)[:, ::2],
    np.array([True]),
    np.array(1j),
)


@pytest.mark.parametrize("value", OF_NUMPY)
def test_numbers_and_arrays_of_numpy_come_back_with_their_type(value: Any) -> None:
    back = there_and_back(value)
    assert (type(back), back.dtype, back.shape) == (type(value), value.dtype, value.shape)
    assert back.tobytes() == value.tobytes()


def test_a_class_that_has_changed_is_named() -> None:
    text = encode(Filter(1.0), "x", {})
    text["class"][2]["rate"] = 0.0
    with pytest.raises(
        ValueError, match=r"Filter with speed, rate, which is not known here: import"
    ):
        decode(text, {})


def test_each_value_that_differs_from_the_saved_run_is_named_with_both_values() -> None:
    def identity(hoist: Hoist, step: float = 0.01) -> Identity:
        rope = rope_in_process("rope-120", level="draft")
        return Host(rope, hoist, TRIP, Coupling(step=step, sample=0.01), GAINS).plan.identity

    saved = identity(Hoist())
    # the step may change where all samples stay
    assert differences(saved, identity(Hoist(), step=0.005)) == ""
    # a part that only one of both has, and a value of another
    changed = Hoist(lining=SheaveLining(sliding=0.7), payload_left=3e3)
    assert differences(saved, identity(changed)) == (
        "hoist.payload_left is 5000.0 there, 3000.0 here, "
        "hoist.lining.sliding is not set there, 0.7 here"
    )
    # in a tuple, and of so many that some are only counted
    there = named_values({"segments": tuple(range(9))})
    here = named_values({"segments": tuple(range(1, 10))})
    listed = differences(there, here)
    assert listed.startswith("segments.1 is 0 there, 1 here, segments.2 is 1 there, 2 here")
    assert listed.endswith("segments.6 is 5 there, 6 here and 3 more")
