"""Accuracy and speed: arithmetic of the fronts, and what the recorded data say of levels, depth and Exudyn."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from evidence.chart import depth
from evidence.chart.front import cheapest, cost_at, pareto
from evidence.chart.page import equal_errors
from evidence.chart.reading import FORCE, finest_error, limit
from evidence.pages import PAGES
from evidence.reproduction.costs import SOURCE_SAVED
from evidence.tables import rows, table

TABLES = PAGES["accuracy"].tables()
POINTS = TABLES["points"]
NAN = float("nan")
#: made up
COST = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 0.5])
ERROR = np.array([1.0, 0.1, 0.2, 0.01, 0.01, NAN])


@pytest.mark.parametrize("order", [[0, 1, 2, 3, 4, 5], [4, 2, 0, 5, 3, 1]])
def test_no_point_of_the_front_is_beaten_in_both_whatever_their_order(order: list[int]) -> None:
    # 2 is beaten by 1, 4 by 3, the last is no number
    assert_array_equal(np.take(order, pareto(COST[order], ERROR[order])), [0, 1, 3])
    assert (cheapest(COST, ERROR, 0.5), cheapest(COST, ERROR, 0.1), cheapest(COST, ERROR, 1e-3)) == (1, 1, None)


def test_cost_is_interpolated_in_the_logarithms() -> None:
    cost = np.array([1.0, 2.0, 4.0])
    assert_allclose(cost_at(cost, 1.0 / cost**3, 3.0**-3), 3.0, rtol=1e-12)  # a power law is a straight line


def test_beyond_the_front_cost_is_the_cheapest_points_or_not_a_number() -> None:
    assert cost_at(COST, ERROR, 10.0) == pytest.approx(1.0, rel=1e-12)
    assert np.isnan(cost_at(COST, ERROR, 0.001))
    assert np.isnan(cost_at(np.array([]), np.array([]), 1.0))


@pytest.mark.parametrize(("order", "left"), [(1, 1.0), (2, 1.0), (3, 2.33)])
def test_the_references_own_error_follows_from_its_convergence(order: int, left: float) -> None:
    solutions = np.array([4.0, 2.0, 1.0]) ** order  # errors; a third order is taken as a second one, with caution
    assert_allclose(finest_error(solutions[:2] - solutions[2]), left, rtol=2e-3)


@pytest.mark.parametrize("coupling", ["coupled", "uncoupled"])
@pytest.mark.parametrize(("level", "bound"), [("draft", 0.03), ("standard", 0.005), ("standard, 10 ms", 0.005)])
def test_levels_are_as_accurate_as_they_say(coupling: str, level: str, bound: float) -> None:
    error = rows(POINTS, family="levels", name=level, coupling=coupling)[FORCE]
    assert error.size == 1
    assert limit(POINTS, coupling, FORCE) < error[0] < bound


def test_savings_are_those_of_equal_elements_with_the_same_loop_error() -> None:
    elements = np.array([100.0, 200.0, 400.0])
    rows_of_eem = [("r", 10.0, 5.0, 1.0, "coupled", "EEM", 0.0, n, 2e-5 * n, 1e-6, 1e4 / n**4) for n in elements]
    reference = ("r", 10.0, 5.0, 1.0, "coupled", "EEM", 0.0, 4000.0, 1.0, 0.0, 0.0)
    other = ("s", 10.0, 5.0, 1.0, "coupled", "EEM", 0.0, 10.0, 1e-9, 0.0, 1e-9)
    faster = ("r", 10.0, 5.0, 2.0, "coupled", "EEM", 0.0, 10.0, 1e-9, 0.0, 1e-9)
    # as good as 300 equal elements, 6e-3 s/s
    ours = ("r", 10.0, 5.0, 1.0, "coupled", "TMN-ETM", 1e-3, 50.0, 1.5e-3, 1e-6, 1e4 / 300.0**4)
    (found,) = depth.savings(table((*depth.COLUMNS, *depth.ERRORS), [reference, *rows_of_eem, other, faster, ours]))
    assert_allclose((found.equal_elements, found.saved), (300.0, 75.0), rtol=1e-9)


@pytest.mark.parametrize("coupling", depth.COUPLINGS)
def test_the_deeper_the_shaft_the_more_is_saved(coupling: str) -> None:
    found = [s for s in depth.savings(TABLES["depth"]) if s.coupling == coupling]
    assert len(found) == len(depth.TRIPS) * len(depth.LOOP_ERRORS)
    for wanted in depth.LOOP_ERRORS:
        of_one_mesh = [s for s in found if s.wanted == wanted and s.speed <= 10.0]
        if wanted == min(depth.LOOP_ERRORS):  # on short ropes finer than any of the equal elements
            of_one_mesh = [s for s in of_one_mesh if np.isfinite(s.saved)]
        assert all(a.length < b.length and a.saved < b.saved for a, b in itertools.pairwise(of_one_mesh))


@pytest.mark.parametrize("coupling", depth.COUPLINGS)
def test_what_the_source_states_is_saved_in_a_deep_shaft(coupling: str) -> None:
    deepest = [s for s in depth.savings(TABLES["depth"]) if s.coupling == coupling and s.length > 1000.0]
    assert max(s.saved for s in deepest) > SOURCE_SAVED[coupling]


def test_ours_is_faster_than_the_other_code_at_every_error_compared() -> None:
    found = equal_errors(TABLES["peer/winding"])
    assert found["loop"][0] > 30
    assert found["force"][0] > 15
