"""Times of communication steps: what a percentile is."""

import numpy as np
import pytest

from evidence.latency.measure import STEPS, Case, percentiles

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
