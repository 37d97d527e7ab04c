"""The coupling schemes on the hoist, from the recorded data."""

from __future__ import annotations

import pytest

from evidence.coupling.page import order, theory
from evidence.rendering import DOCS
from evidence.tables import read
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.cosimulation.schemes.stability import MARGIN

TABLES = read(DOCS / "data" / "coupling")


@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_scheme_has_its_order_on_the_hoist_to_half_an_order_or_a_higher_one(scheme: str) -> None:
    assert order(TABLES["schemes"], scheme) > theory(scheme) - 0.5


def test_the_default_errs_by_less_than_half_a_percent_on_every_case_and_is_stable() -> None:
    t = TABLES["cases"]
    assert t["force error"].max() < 0.005
    assert t["predicted growth"].max() < MARGIN
    assert not any(str(cause) not in ("", "nan") for cause in t["cause"])
