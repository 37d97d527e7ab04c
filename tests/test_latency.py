"""Times of communication steps: what a percentile is, which step is slow and why, and what the scenes do."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from benchmarks.latency import COUNTED, Case, Measured, Work, work
from benchmarks.rest import PUSHED, hanging, pushed
from evidence.latency.page import cause
from evidence.latency.tables import causes, curves, explained, steps
from hoist_demo.cases.table import find_case

US = 1e-6


def measured(times: np.ndarray, counts: np.ndarray | None = None, H: float = 0.01) -> Measured:
    done = np.zeros((times.shape[1], len(COUNTED)), dtype=np.int64) if counts is None else counts
    return Measured(Case("rope-120", "winding", "standard", H), times, Work(done, 57, "torsional"), (0, 0, 0))


def test_one_hiccup_in_one_round_moves_no_percentile_and_no_own_time() -> None:
    times = np.full((3, 100), 50 * US)
    times[1, 40] = 30e-3
    found = measured(times)
    assert_allclose(found.as_run, 50 * US)
    assert_allclose(found.own, 50 * US)
    assert found.late == 0.0


def test_a_step_that_is_long_in_every_round_is_late() -> None:
    times = np.full((3, 100), 50 * US)
    times[:, 40] = 11e-3
    found = measured(times)
    assert found.late == 0.01
    assert steps([found])["own late"][0] == 0.01
    assert_allclose(found.as_run[-1], 11e-3)
    assert measured(times, H=0.02).late == 0.0


def test_times_made_of_iterations_and_transformations_are_taken_apart() -> None:
    rng = np.random.default_rng(3)
    newton, transformations = rng.integers(2, 9, 500), rng.integers(0, 2, 500)
    own = 25 * US * newton + 120 * US * transformations
    found = explained({"count.newton": newton, "count.transformations": transformations}, own)
    assert_allclose(found, (25 * US, 120 * US, 1.0), rtol=1e-9)


def test_the_slowest_steps_are_told_by_what_happened_in_them() -> None:
    counts = np.zeros((200, len(COUNTED)), dtype=np.int64)
    counts[:, COUNTED.index("count.newton")] = 2
    counts[[10, 20], COUNTED.index("count.transformations")] = 1
    counts[30, COUNTED.index("count.rejections")] = 1
    times = np.full((1, 200), 50 * US)
    times[0, [10, 20]] = 170 * US
    t = causes([measured(times, counts)])
    assert t["count.transformations, slowest"][0] == 1.0
    assert t["count.transformations, all"][0] == 0.01
    assert t["count.rejections, slowest"][0] == 0.0
    assert t["worst at [s]"][0] in (0.11, 0.21)


@pytest.mark.parametrize(
    ("swivel", "words"), [(0.8, "a swivel event, in 80 % of them"), (0.4, "nothing that most of them have")]
)
def test_a_cause_is_what_most_of_the_slowest_steps_have(swivel: float, words: str) -> None:
    assert cause({"count.rejections": 0.1, "count.transformations": 0.3, "count.swivel_events": swivel}) == words


def test_the_curve_tells_which_share_of_the_steps_takes_longer() -> None:
    times = US * np.arange(1.0, 1001.0)[None, :]
    t = curves([measured(times)])
    assert_allclose(t["time [s]"], US * (1001 - 1000 * t["share"]))
    assert (t["share"][0], t["share"][-1]) == (1e-3, 1.0)


def test_the_stop_on_rope_240_comes_after_the_swivels_release_and_shortens_the_trip() -> None:
    stop, whole = (Case("rope-240", trip, "draft", 0.02) for trip in ("emergency stop", "winding"))
    assert stop.winding.emergency_at > find_case("rope-240").rope["left.swivel.release_time"]
    assert len(stop.motions) < len(whole.motions)
    assert [end.vy for end in stop.motions[-1]] == [0.0, 0.0]


def test_counted_work_is_that_of_each_step() -> None:
    case = Case("rope-120", "winding", "draft", 0.02)
    case.__dict__["motions"] = case.motions[:30]
    done = work(case)
    own = done.counts[:, COUNTED.index("count.steps")]
    assert done.counts.shape == (29, len(COUNTED))
    assert own.min() >= 1
    assert done.counts[:, COUNTED.index("count.newton")].min() >= 1


def test_the_push_begins_and_ends_at_rest_and_its_rates_are_its_derivatives() -> None:
    for t in (0.0, PUSHED):
        left, _ = pushed(t)
        assert (left.z, left.vz) == (0.0, 0.0)
    assert pushed(PUSHED + 1.0) == hanging(0.0)
    t, h = 0.3 * PUSHED, 1e-4
    before, now, after = (pushed(t + d)[0] for d in (-h, 0.0, h))
    # central differences err by h^2 of the next derivatives, some 1e-9 here
    assert_allclose(now.vz, (after.z - before.z) / (2 * h), rtol=1e-6)
    assert_allclose(now.az, (after.vz - before.vz) / (2 * h), rtol=1e-6)
