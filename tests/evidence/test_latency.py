"""Times of communication steps: what a percentile is, and which steps are slow and why."""

import numpy as np
import pytest

from evidence.latency.measure import COUNTED, STEPS, Case, causes, percentiles, work

CASE = Case("rope-120", "winding", "draft", "in process", 0.01)


@pytest.mark.parametrize(("rounds", "time", "largest", "late"), [(1, 3e-2, 5e-5, 0.0), (slice(3), 11e-3, 11e-3, 0.01)])
def test_a_step_is_late_that_is_long_in_every_round(
    rounds: int | slice, time: float, largest: float, late: float
) -> None:
    times = np.full((3, 100), 5e-5)
    times[rounds, 40] = time
    found = dict(zip(STEPS, percentiles(CASE, times, 52), strict=True))  # type: ignore[arg-type]
    np.testing.assert_allclose([found["largest [s]"], found["own largest [s]"]], largest)
    assert found["late"] == late


def test_the_slowest_steps_are_told_by_what_happened_in_them() -> None:
    times, counts = np.full((1, 200), 5e-5), np.zeros((200, len(COUNTED)), dtype=np.int64)
    times[0, 7:9], counts[7:9, 1] = 3e-4, 1
    counts[100, 0] = 1
    rejected, transformed, *_, rejected_all, _, _ = causes(CASE, times, counts)[5:11]
    assert (rejected, transformed, rejected_all) == (0.0, 1.0, 0.005)


def test_the_work_of_a_trip_is_counted_step_by_step() -> None:
    counts, elements = work(CASE)
    assert counts.shape == (len(CASE.motions) - 1, len(COUNTED))
    assert elements == 52
    assert counts[:, -1].min() >= 1
    assert counts[:, 1].sum() > 10
