"""What would differ between versions of Python: sums without compensation."""

import builtins
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest
from scenes import going_aside, hung

from hoist_demo.control.trajectory import s_curve
from hoist_demo.design.shaping import shape
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.parameters.hoist import hoist_with
from hoist_demo.parameters.trip_design import Shaper
from rope_model import (
    BalanceRope,
    Mesh,
    Rope,
    Scene,
    Solver,
    Swivel,
    balance_rope,
)

#: a rope whose swivel slips
PUBLISHED = Scene(
    Rope(length=30.0),
    mesh=Mesh("eem", elements=16),
    left=Swivel(mode="coulomb"),
    # no more steps than the host's
    solver=Solver(step_max=0.01, tolerance=1e6),
)


def moved(rope: BalanceRope, steps: int = 1) -> BalanceRope:
    hung(rope, *going_aside(0.0))
    for k in range(1, steps + 1):
        status = rope.advance_to(0.01 * k, *going_aside(0.01 * k))
        assert status.valid, status.message
    return rope


@pytest.fixture
def sums_no_floats(monkeypatch: pytest.MonkeyPatch) -> None:
    """``sum``, which compensates for the rounding of floats since Python 3.12, refuses them."""
    kept = sum

    def checked(terms: Iterable[Any], /, start: Any = 0) -> Any:
        terms = [*terms]
        assert not any(type(x) is float for x in terms), (
            "sum of floats: take sum_of of rope_model.physics.elementary"
        )
        return kept(terms, start)

    monkeypatch.setattr(builtins, "sum", checked)


@pytest.mark.usefixtures("sums_no_floats")
def test_a_rope_adds_its_numbers_from_left_to_right() -> None:
    rope = moved(balance_rope(PUBLISHED, "reference"))
    rope.restore(rope.save())
    assert np.isfinite([*rope.signals().values()]).all()


@pytest.mark.usefixtures("sums_no_floats")
def test_a_hoist_adds_its_numbers_from_left_to_right() -> None:
    trip = shape(s_curve(Winding()), Shaper("ZVD", 1.3, 0.05))
    assert trip.points[-1].position == pytest.approx(Winding().travel)
    assert hoist_with(Hoist(), [(4.0, 120.0), (5.0, 120.0)]).tail_rope_mass == 9.0
