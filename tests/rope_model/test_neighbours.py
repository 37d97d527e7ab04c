"""Ropes side by side that press each other: the law, action and reaction, balances, a wall midway, groups."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from contact_scenes import (
    FACING,
    GAP,
    SCENE,
    STIFFNESS,
    Alone,
    against_a_wall,
    begun,
    exact_force,
    striking,
    swinging,
)
from numpy.testing import assert_allclose, assert_array_equal
from shared import Array

from rope_model import Air, Contact, EndMotion, Rope, Shaft, Solver
from rope_model.analysis.pair_contact import Pair, Rows, rows_of
from rope_model.physics.centreline import enclosing_box
from rope_model.physics.contact import ONSET

D = Rope().diameter
K = STIFFNESS


def straight(points: Array, tangents: Array, s: Array) -> Rows:
    q = np.hstack((points, tangents))
    lengths = np.diff(s)
    return Rows(s, q, 0.0 * q, lengths, np.array(enclosing_box(lengths, q[:-1].T, q[1:].T)))


def strand(angle: float, y: float, z: float) -> tuple[Array, Array]:
    tangent = np.array([math.cos(angle), math.sin(angle), 0.0])
    return np.outer((-1.0, 0.0, 1.0), tangent) + np.array([0.0, y, z]), np.tile(tangent, (3, 1))


S = np.array([0.0, 1.0, 2.0])
STRINGS = SCENE.with_(rope=Rope(length=2.0))


@pytest.mark.parametrize(("degrees", "off"), [(90, 0.03), (30, 2e-3), (5, 1e-4)])
def test_the_force_of_crossing_strings_is_the_integral_of_the_law(
    degrees: float, off: float
) -> None:
    """``off`` is by how much the spacing of the places shows, as it does in a rope's contact with itself."""
    angle = math.radians(degrees)
    gap = 0.85 * D
    one = straight(*strand(0.0, 0.0, 0.0), S)
    other = straight(*strand(angle, 0.003, gap), S)
    found = Pair(STRINGS, STRINGS).find_contacts(one, other, np.array([1.0, 0.0]))
    assert found.force.sum(axis=0)[2] == pytest.approx(-exact_force(gap, math.sin(angle)), rel=off)


def test_a_rope_feels_both_strands_of_the_other() -> None:
    one = straight(*strand(0.0, 0.0, 0.0), S)
    upper = strand(0.0, 0.0, 0.8 * D)
    lower = strand(math.pi, 0.8 * D, 0.0)
    other = straight(
        *(np.concatenate(x) for x in zip(upper, lower, strict=True)),
        np.array([0, 1, 2, 9, 10, 11.0]),
    )
    force = Pair(STRINGS, STRINGS).find_contacts(one, other, np.array([1.0, 0.0])).force.sum(axis=0)
    pressed = 0.2 * D
    onset = ONSET * D
    each = 2.0 * K * (pressed - 0.5 * onset)
    # what joins the strands goes on along them, and presses within a diameter of their ends
    assert_allclose(force, [0.0, -each, -each], atol=D * each)


@pytest.mark.parametrize("h", [0.01, pytest.param(0.002, marks=pytest.mark.slow)])
def test_what_ropes_that_strike_lose_is_what_their_contact_books(h: float) -> None:
    neighbours, ropes = striking(h)
    account = neighbours.contacts.accounts[0, 1]
    work = sum(rope.state.energy_balance.work_ends for rope in ropes)  # their ends rest
    assert account.work < -2.0
    # the ropes book by their own steps, which they may halve
    off = 1e-4
    if h > 0.005:
        off = 0.03
    assert work == pytest.approx(account.work, rel=off)
    assert account.missed < 2e-4
    assert account.work + account.energy + account.dissipated - account.created == pytest.approx(
        0.0, abs=1e-9
    )


@pytest.mark.slow
def test_what_the_steps_make_falls_with_them() -> None:
    long, short = (abs(striking(h)[0].contacts.accounts[0, 1].created) for h in (0.01, 0.0005))
    # of 18 J in their swing
    assert long < 0.04 * 18.0
    assert short < 0.1 * long


def test_two_that_swing_against_each_other_move_as_one_against_a_wall_midway() -> None:
    """But that the law begins softly within a part of the diameter, which the wall has twice."""
    h = 0.002
    struck, z = (
        rope.rows()[:, 3]
        for rope in (striking(h, friction=0.0)[1][0], against_a_wall(h, friction=0.0))
    )
    assert np.abs(z).max() > 0.1
    assert np.abs(struck - z).max() < 0.02 * np.abs(struck).max()
    free = swinging(SCENE.with_(shaft=Shaft()), 1.0)
    assert free.advance_to(0.3, EndMotion(), EndMotion()).valid
    assert np.abs(free.rows()[:, 3] - z).max() > 0.05


def test_fast_ropes_do_not_pass_through_each_other() -> None:
    """In a step of 20 ms they come nearer by two diameters."""
    scene = SCENE.with_(solver=Solver(step_max=0.02, tolerance=1e5))
    neighbours, ropes, partners = begun([scene, scene], (2.2, -2.2), FACING)
    for k in range(10):
        assert neighbours.step(0.02 * k, 0.02, partners)
    assert neighbours.contacts.accounts[0, 1].peak > 100.0
    assert ropes[0].rows()[8, 3] - ropes[1].rows()[8, 3] < GAP


@pytest.mark.slow
def test_a_wind_that_presses_one_rope_on_the_other_pulls_at_both() -> None:
    h = 0.02
    steps = 150
    mass = Rope().mass_per_length
    holding = Shaft(contact=Contact(rope_stiffness=K))
    still, blown = (
        SCENE.with_(shaft=replace(holding, air=Air(1.2, vz=speed))) for speed in (0.0, 12.0)
    )
    neighbours, ropes, partners = begun(
        [still, still], (0.0, 0.0), [(0.0, 0.0, 0.0), (0.3, 0.0, 1.5 * D)]
    )
    ropes[0].retune(blown)
    impulse = pull = 0.0
    for k in range(steps):
        assert neighbours.step(k * h, h, partners)
        impulse -= h * neighbours.contacts.forces[0, 1].force.sum(axis=0)[2]
        pull += h * sum(ropes[1].signals(["left.fz", "right.fz"]).values())
    rows = ropes[1].rows()
    momentum = mass * float(np.diff(rows[:, 0]) @ (0.5 * (rows[1:, 9] + rows[:-1, 9])))
    assert impulse > 5.0
    # the one in the lee feels hardly more than the contact; the sums are those of the steps' ends
    assert pull + momentum == pytest.approx(impulse, rel=0.05)


@pytest.mark.slow
def test_ropes_that_hang_into_each_other_are_led_apart_gently() -> None:
    places = [(0.0, 0.0, 0.0), (0.3, 0.0, 0.5 * D)]
    neighbours, ropes, partners = begun([SCENE, SCENE], (0.0, 0.0), places)
    # they hang in parallel planes, yawed a little by their coupling
    assert neighbours.contacts.insets[0, 1] == pytest.approx(0.5 * D, rel=0.02)
    for k in range(100):
        assert neighbours.step(0.01 * k, 0.01, partners)
    rows = [rows_of(rope, np.array(place)) for rope, place in zip(ropes, places, strict=True)]
    assert Pair(SCENE, SCENE).inset(*rows) < 0.05 * D
    assert sum(rope.state.energy_balance.kinetic for rope in ropes) < 0.05


def test_a_state_that_is_gone_back_to_leads_on_bit_by_bit() -> None:
    neighbours, ropes = striking(0.02)
    saved = [rope.snapshot() for rope in ropes]
    contacts = neighbours.contacts
    ends = []
    for _ in range(2):
        for rope, kept in zip(ropes, saved, strict=True):
            rope.restore(kept)
        neighbours.contacts = contacts
        partners = [Alone(rope) for rope in ropes]
        for k in range(5):
            assert neighbours.step(0.3 + 0.02 * k, 0.02, partners)
        ends.append((ropes[0].rows(), neighbours.contacts.accounts[0, 1]))
    assert_array_equal(ends[0][0], ends[1][0])
    assert ends[0][1] == ends[1][1]


def test_a_rope_that_hangs_in_pieces_presses_no_more() -> None:
    neighbours, ropes = striking(0.01)
    partners: list[Any] = [Alone(rope) for rope in ropes]
    at = 0.3
    while not neighbours.contacts.forces[0, 1].point_id.size:
        assert neighbours.step(at, 0.01, partners)
        at += 0.01
        assert at < 3.0
    # what is left of a rope
    partners[1] = SimpleNamespace(
        rope=None, begin=lambda *_: None, go=lambda: True, back=list, accept=list
    )
    for k in range(3):
        assert neighbours.step(at + 0.01 * k, 0.01, partners)
    assert neighbours.contacts.forces[0, 1].point_id.size == 0
