"""What would differ between versions of Python and of numpy: states without type hints, sums without compensation."""

import builtins
from collections.abc import Iterable
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_equal
from scenes import going_aside, hung

from hoist_demo.control.trajectory import s_curve
from hoist_demo.design.shaping import shape
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.parameters.hoist import hoist_with
from hoist_demo.parameters.trip_design import Shaper
from rope_model import (
    BalanceRope,
    Guard,
    Mesh,
    Rope,
    Scene,
    Shaft,
    Solver,
    Sump,
    Swivel,
    balance_rope,
)
from rope_model.method.generalized_alpha import Motion
from rope_model.method.partition import Partition
from rope_model.state import RopeState

#: a rope with all that its state can hold: guards, a floor that it presses, a swivel that slips, wires that rub
FULL = Scene(
    Rope(length=30.0, EI_stick=3000.0),
    mesh=Mesh("eem", elements=16),
    left=Swivel(mode="coulomb"),
    shaft=Shaft(sump=Sump(level=-11.9), guard=Guard(rise=0.01, window=0.3, turns=0.2, torque=5.0)),
    # no more steps than the host's
    solver=Solver(step_max=0.01, tolerance=1e6),
)


#: its part that the reference rope computes
PUBLISHED = replace(FULL, rope=Rope(length=30.0), shaft=Shaft())


def moved(rope: BalanceRope, steps: int = 1) -> BalanceRope:
    hung(rope, *going_aside(0.0))
    for k in range(1, steps + 1):
        status = rope.advance_to(0.01 * k, *going_aside(0.01 * k))
        assert status.valid, status.message
    return rope


@pytest.fixture(scope="module")
def state() -> RopeState:
    return moved(balance_rope(FULL)).state


def test_a_state_is_rebuilt_without_type_hints(
    state: RopeState, monkeypatch: pytest.MonkeyPatch
) -> None:
    """numpy 2.5 makes NDArray an alias that no longer shows what it stands for."""
    for kind in (Motion, Partition):
        monkeypatch.setattr(
            kind, "__annotations__", dict.fromkeys((field.name for field in fields(kind)), object)
        )
    data = state.to_bytes()
    rebuilt = RopeState.from_bytes(data)
    for name, value in vars(state.motion).items():
        assert_equal(getattr(rebuilt.motion, name), value)
    assert rebuilt.to_bytes() == data


def test_a_state_is_rebuilt_with_the_kinds_that_it_had(state: RopeState) -> None:
    def kinds(x: Any) -> Any:
        parts: Iterable[Any] = ()
        if is_dataclass(x):
            parts = [getattr(x, field.name) for field in fields(x)]
        elif isinstance(x, tuple):
            parts = x
        return type(x), [kinds(part) for part in parts]

    assert kinds(RopeState.from_bytes(state.to_bytes())) == kinds(state)


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
