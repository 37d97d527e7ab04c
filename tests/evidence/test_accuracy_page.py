"""Accuracy and speed: the fronts, and what the recorded data say of levels, depth, Exudyn and single steps."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from evidence.accuracy import depth
from evidence.accuracy.front import cheapest, pareto
from evidence.accuracy.page import equal_errors
from evidence.accuracy.reading import FORCE, finest_error, limit
from evidence.latency.measure import STEPS, Case, percentiles
from evidence.pages import PAGES, tables
from evidence.reproduction.costs import SOURCE_SAVED
from evidence.tables import rows

TABLES = tables(PAGES["accuracy"])
POINTS = TABLES["points"]
NAN = float("nan")
#: made up
COST = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 0.5])
ERROR = np.array([1.0, 0.1, 0.2, 0.01, 0.01, NAN])


@pytest.mark.parametrize("order", [[0, 1, 2, 3, 4, 5], [4, 2, 0, 5, 3, 1]])
def test_no_point_of_the_front_is_beaten_in_both_whatever_their_order(order: list[int]) -> None:
    # 2 is beaten by 1, 4 by 3, the last is no number
    assert_array_equal(np.take(order, pareto(COST[order], ERROR[order])), [0, 1, 3])
    assert (
        cheapest(COST, ERROR, 0.5),
        cheapest(COST, ERROR, 0.1),
        cheapest(COST, ERROR, 1e-3),
    ) == (1, 1, None)


@pytest.mark.parametrize(("order", "left"), [(1, 1.0), (2, 1.0), (3, 2.33)])
def test_the_references_own_error_follows_from_its_convergence(order: int, left: float) -> None:
    solutions = (
        np.array([4.0, 2.0, 1.0]) ** order
    )  # errors; a third order is taken as a second one, with caution
    assert_allclose(finest_error(solutions[:2] - solutions[2]), left, rtol=2e-3)


@pytest.mark.parametrize("coupling", ["coupled", "uncoupled"])
@pytest.mark.parametrize(
    ("level", "bound"), [("draft", 0.03), ("standard", 0.005), ("standard, 10 ms", 0.005)]
)
def test_levels_are_as_accurate_as_they_say(coupling: str, level: str, bound: float) -> None:
    error = rows(POINTS, family="levels", name=level, coupling=coupling)[FORCE]
    assert error.size == 1
    assert limit(POINTS, coupling, FORCE) < error[0] < bound


@pytest.mark.parametrize("coupling", depth.COUPLINGS)
def test_the_deeper_the_shaft_the_more_is_saved(coupling: str) -> None:
    found = [s for s in depth.savings(TABLES["depth"]) if s.coupling == coupling]
    assert len(found) == len(depth.TRIPS) * len(depth.LOOP_ERRORS)
    for wanted in depth.LOOP_ERRORS:
        of_one_mesh = [s for s in found if s.wanted == wanted and s.speed <= 10.0]
        if wanted == min(depth.LOOP_ERRORS):  # on short ropes finer than any of the equal elements
            of_one_mesh = [s for s in of_one_mesh if np.isfinite(s.saved)]
        assert all(
            a.length < b.length and a.saved < b.saved for a, b in itertools.pairwise(of_one_mesh)
        )


@pytest.mark.parametrize("coupling", depth.COUPLINGS)
def test_what_the_source_states_is_saved_in_a_deep_shaft(coupling: str) -> None:
    deepest = [
        s for s in depth.savings(TABLES["depth"]) if s.coupling == coupling and s.length > 1000.0
    ]
    assert max(s.saved for s in deepest) > SOURCE_SAVED[coupling]


def test_ours_is_faster_than_the_other_code_at_every_error_compared() -> None:
    found = equal_errors(TABLES["exudyn/winding"])
    assert found["loop"][0] > 30
    assert found["force"][0] > 15


@pytest.mark.parametrize(
    ("rounds", "time", "largest", "late"), [(1, 3e-2, 5e-5, 0.0), (slice(3), 11e-3, 11e-3, 0.01)]
)
def test_a_step_is_late_that_is_long_in_every_round(
    rounds: int | slice, time: float, largest: float, late: float
) -> None:
    case = Case("rope-120", "winding", "draft", "in process", 0.01)
    times = np.full((3, 100), 5e-5)
    times[rounds, 40] = time
    found = dict(zip(STEPS, percentiles(case, times, 52), strict=True))  # type: ignore[arg-type]
    assert_allclose([found["largest [s]"], found["own largest [s]"]], largest)
    assert found["late"] == late
