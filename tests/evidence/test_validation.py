"""The page against measurement and theory: rows that are quick to compute anew, and what counts as missed."""

from __future__ import annotations

import math

import pytest

from evidence.validation import chains, onset
from evidence.validation.measure import onset_rows, swing_rows
from evidence.validation.row import Row
from evidence.validation.wires import GAP, STEP, WIRES, thrown

BLACK = WIRES[1]


def row(value: float, bound: float) -> Row:
    return Row("X-1", "theory", "reference", "result", value, "1", bound, "test")


@pytest.mark.parametrize(
    ("value", "bound", "missed"), [(0.5, 1.0, False), (1.0, 1.0, True), (math.nan, 1.0, True), (5.0, math.nan, False)]
)
def test_a_row_misses_where_an_acceptance_is_stated_and_not_met(value: float, bound: float, missed: bool) -> None:
    assert row(value, bound).misses is missed


def test_the_black_wire_throws_its_loop_as_measured_with_one_of_the_published_pairs() -> None:
    # angles are good for half a step; the other pairs miss, to both sides
    half = 0.5 * STEP
    assert min(BLACK.twists) - half < thrown(BLACK, *BLACK.stiffness[1], GAP) < max(BLACK.twists) + half


def test_a_hanging_rope_swings_with_the_zeros_of_j0() -> None:
    found = list(swing_rows(chains.swings()))
    assert len(found) == chains.MODES
    assert not [row.id for row in found if row.misses]


def test_a_clamped_rod_buckles_at_the_torque_of_the_theory() -> None:
    found = list(onset_rows(onset.measure()))
    assert len(found) == 2 * len(onset.PRINTED)
    assert not [row.id for row in found if row.misses]
