"""What the page of coupling says, by its recorded data."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from evidence.coupling.figures import FIGURES
from evidence.coupling.reading import PROMISED, correct_predictions, order_on_hoist, theory
from evidence.rendering import DOCS
from evidence.tables import read, rows
from hoist_demo.cases.table import CASES
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.cosimulation.schemes.stability import MARGIN
from hoist_demo.parameters import Coupling

TABLES = read(DOCS / "data" / "coupling")


def test_figures_are_there() -> None:
    assert {p.stem for p in (DOCS / "images" / "coupling").iterdir()} == set(FIGURES)


def test_the_default_errs_by_less_than_promised_on_every_case() -> None:
    t = TABLES["cases"]
    assert set(t["case"]) == set(CASES)
    assert set(t["scheme"]) == {Coupling().scheme}
    assert_array_equal(t["H [s]"], 0.01)
    assert np.all(t["force error"] < PROMISED)
    assert np.all(t["predicted growth"] < MARGIN)
    assert not any(t["cause"])


@pytest.mark.parametrize("name", SCHEMES)
def test_the_observed_order_on_the_hoist_is_at_least_that_of_theory(name: str) -> None:
    # the controller's samples are kinks, which a parabola does not follow: half an order less at most
    assert order_on_hoist(TABLES["schemes"], name) > theory(name) - 0.5


@pytest.mark.parametrize("name", ["gauss-seidel-0", "gauss-seidel-1", "semi-implicit-1", "impulse-preserving"])
def test_the_observed_order_on_the_hoist_is_no_higher_where_waves_and_kinks_do_not_matter(name: str) -> None:
    assert order_on_hoist(TABLES["schemes"], name) < theory(name) + 0.3


def test_stability_happens_as_predicted() -> None:
    agree, count = correct_predictions(TABLES["stability"], MARGIN)
    assert agree >= 0.9 * count
    for name in ("semi-implicit-0", "semi-implicit-1", "implicit-impulse"):
        stable = rows(TABLES["stability"], scheme=name)["stable"]
        assert stable.size > 20
        assert np.all(stable > 0)
