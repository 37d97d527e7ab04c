"""Contact of the rope with itself: the law, the coupled Newton's method, the rope in it."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from contact_scenes import crossing, force_error
from native_parts import SelfContacts, find_self_contacts
from numpy.testing import assert_allclose, assert_array_equal
from scenes import hung, wound
from self_contact_scenes import D, K, end, twisted
from shared import Array

from rope_model import (
    Contact,
    Layout,
    Mesh,
    Rope,
    Scene,
    Shaft,
    Solver,
    balance_rope,
)
from rope_model.analysis.conjugate_gradients import conjugate_gradients
from rope_model.physics.contact import ONSET


def holding(**changed: float) -> Scene:
    return Scene(shaft=Shaft(contact=Contact(rope_stiffness=K, **changed)))


def contacts(
    q: Array,
    lengths: Array,
    v: Array | None = None,
    c: Any = (0.0, 0.0),
    x: Array | None = None,
    **changed: float,
) -> SelfContacts:
    if v is None:
        v = np.zeros_like(q)
    return find_self_contacts(holding(**changed), q, v, lengths, c, x)


@pytest.mark.parametrize(("degrees", "off"), [(90, 0.03), (30, 2e-3), (5, 1e-4)])
def test_the_force_of_crossing_strings_is_the_integral_of_the_law(
    degrees: float, off: float
) -> None:
    """``off`` is by how much the spacing of the places shows."""
    assert force_error(degrees) < off


ORDERS = ((0, 1, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))


def bundle(order: tuple[int, ...]) -> Array:
    """Three straight strands of 3 m in a triangle, 0.8 diameters apart, which one rope passes in this order."""
    q = np.zeros((12, 7))
    for k, corner in enumerate(order):
        angle = 2.0 * math.pi * corner / 3
        sense = 1 - 2 * (k % 2)
        q[4 * k : 4 * k + 4, 0] = sense * np.linspace(-1.5, 1.5, 4)
        q[4 * k : 4 * k + 4, 1:4] = math.cos(angle), math.sin(angle), sense
        q[4 * k : 4 * k + 4, 1:3] *= 0.8 * THIN / math.sqrt(3.0)
    return q


THIN = 0.02


@pytest.mark.parametrize("order", ORDERS)
def test_each_of_three_strands_feels_both_others_in_whatever_order_the_rope_passes_them(
    order: tuple[int, ...],
) -> None:
    scene = holding().with_(rope=Rope(diameter=THIN))
    q = bundle(order)
    lengths = np.where(np.arange(11) % 4 == 3, 20.0, 1.0)
    found = find_self_contacts(scene, q, 0 * q, lengths)
    R = np.zeros_like(q)
    found.take_force(R)
    pressed = 0.2 * THIN
    onset = ONSET * THIN
    each = 3.0 * K * (0.5 * onset + pressed - onset)
    # what joins the strands goes on along them, and presses within a diameter of their ends: 1/150
    # of their length
    most = THIN / 3.0
    assert found.sums["rope"] == pytest.approx(3.0 * each, rel=most)
    for k, corner in enumerate(order):
        angle = 2.0 * math.pi * corner / 3
        outwards = math.sqrt(3.0) * each * np.array([0.0, math.cos(angle), math.sin(angle)])
        assert_allclose(-R[4 * k : 4 * k + 4, :3].sum(axis=0), outwards, atol=most * each)


def tangled(length: float, elements: int) -> Scene:
    rope = Rope(length=length, diameter=THIN, EI=100.0)
    return holding().with_(rope=rope, layout=Layout(0.3), mesh=Mesh("eem", elements=elements))


COILS = 9
CIRCUMFERENCE = 1.5
RISE = 0.1 * THIN


def test_no_touch_is_left_out_of_strands_that_lie_in_each_other() -> None:
    rope = hung(balance_rope(tangled(COILS * CIRCUMFERENCE, 4 * COILS), "native"))
    # so many turns of one circle, four elements each, each turn lying in those before it
    turn = np.linspace(0.0, COILS, 4 * COILS + 1)
    radius = CIRCUMFERENCE / (2.0 * math.pi)
    angle = 2.0 * math.pi * turn
    q = np.zeros((turn.size, 7))
    q[:, 0] = radius * np.cos(angle)
    q[:, 1] = RISE * turn
    q[:, 2] = radius * np.sin(angle)
    q[:, 3] = -np.sin(angle)
    q[:, 4] = RISE / CIRCUMFERENCE
    q[:, 5] = np.cos(angle)
    rope.restore(rope.state._replace(motion=replace(rope.state.motion, q=q)))
    # the six nearest of the turns to the right press, beyond the law's onset
    pressure = [K * (THIN - k * RISE - 0.5 * ONSET * THIN) for k in range(1, 7)]
    exact = sum((COILS - k) * CIRCUMFERENCE * each for k, each in enumerate(pressure, start=1))
    # a place at the end of a turn is as near to the beginning of the next
    assert rope.signals(["contact.rope"])["contact.rope"] == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("seed", range(3))
def test_the_forces_of_a_pair_cancel_and_its_friction_leaves_its_couple(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q, lengths = crossing(0.8 * D, 0.4)
    q += 0.003 * rng.normal(size=q.shape)
    found = contacts(q, lengths, rng.normal(size=q.shape))
    R = np.zeros_like(q)
    found.take_force(R)
    sums = found.sums
    assert sums["contact_dissipated"] > 0
    # rounding of shares that add up to 1
    assert_allclose(R[:, :3].sum(axis=0), 0.0, atol=1e-14 * sums["rope"])
    moment = np.cross(q[:, :3], R[:, :3]).sum(axis=0) + np.cross(q[:, 3:6], R[:, 3:6]).sum(axis=0)
    assert_allclose(-moment, [sums[f"contact_m{x}"] for x in "xyz"], atol=1e-12 * sums["rope"])
    assert np.linalg.norm(moment) < Contact().friction * D * sums["rope"]


@pytest.mark.parametrize("seed", range(3))
def test_the_force_is_the_energys_gradient_without_losses(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q, lengths = crossing(0.8 * D, 0.4)
    q += 0.003 * rng.normal(size=q.shape)
    R = np.zeros_like(q)
    way = rng.normal(size=q.shape)
    size = 1e-7
    contacts(q, lengths).take_force(R)
    more, less = (contacts(q + sign * size * way, lengths).sums["contact"] for sign in (1, -1))
    assert (more - less) / (2 * size) == pytest.approx(np.vdot(R, way), rel=1e-5)


def test_the_tangent_is_the_forces_derivative_where_nothing_is_left_out() -> None:
    """Of strings side by side that come nearer, or slide."""
    q, lengths = crossing(0.8 * D, 0.0)
    size = 1e-7
    x = np.zeros_like(q)
    x[3:, 2] = 1.0

    def force(q: Array, v: Array, **changed: float) -> Array:
        R = np.zeros_like(q)
        contacts(q, lengths, v, **changed).take_force(R)
        return R

    no_losses: dict[str, float] = {"friction": 0.0, "damping": 0.0}
    product = contacts(q, lengths, c=(1.0, 0.0), x=x, **no_losses).product
    stiffness = (
        force(q + size * x, 0 * q, **no_losses) - force(q - size * x, 0 * q, **no_losses)
    ) / (2 * size)
    assert np.abs(product).max() > 1e5
    assert_allclose(product, stiffness, atol=1e-5 * np.abs(product).max())
    v = np.zeros_like(q)
    v[3:, :2] = (0.02, 0.01)
    x[3:, :2] = (1.0, 2.0)
    product = contacts(q, lengths, v, (0.0, 1.0), x, damping=0.0).product
    rate = (force(q, v + size * x, damping=0.0) - force(q, v - size * x, damping=0.0)) / (2 * size)
    assert_allclose(product, rate, atol=1e-5 * np.abs(product).max())


def test_conjugate_gradients_solve_the_coupled_system_in_as_many_steps_as_its_rank() -> None:
    rng = np.random.default_rng(1)
    size = 60
    rank = 5
    A = rng.normal(size=(size, size))
    B = rng.normal(size=(size, rank))
    J = A @ A.T + np.eye(size)
    C = 1e4 * B @ B.T
    R = rng.normal(size=size)
    solved: list[Array] = []

    def solve(g: Array) -> Array:
        solved.append(g)
        return -np.linalg.solve(J, g)

    x = conjugate_gradients(solve, lambda p: C @ p, R)
    assert_allclose(x, -np.linalg.solve(J + C, R), atol=1e-6 * np.abs(x).max())
    assert len(solved) <= rank + 3  # rounding costs one or two


def test_a_rope_that_does_not_touch_itself_computes_what_it_does_without() -> None:
    one, other = (
        wound(balance_rope(twisted(x)), lambda t: (end(t, 1.5, 2.0),) * 2, 20).state
        for x in (0.0, K)
    )
    assert_array_equal(one.motion.q, other.motion.q)
    assert_array_equal(one.motion.reaction[[0, -1]], other.motion.reaction[[0, -1]])
    assert one.counts == other.counts


def test_legs_that_turn_about_each_other_lie_against_each_other_and_keep_the_balances() -> None:
    rope = Rope(length=10.0, EI=200.0)
    scene = twisted(
        1e7, rope=rope, layout=Layout(0.5), mesh=Mesh("eem", elements=40), solver=Solver()
    )
    ropes = [balance_rope(x, "native") for x in (scene, scene.with_(shaft=Shaft()))]
    held, passing = (wound(x, lambda t: (end(t, 4.0, 10.0),) * 2, 350) for x in ropes)
    energy = held.state.energy_balance
    audit = held.state.audit
    assert energy.dissipated_contact > 5.0
    assert abs(energy.residual) < 1e-3 * energy.work_ends
    assert audit.missing_force < 1e-3 * audit.force
    signals = held.signals(["loop.turns", "loop.crossings", "contact.rope", "loop.clearance"])
    assert signals["contact.rope"] > 500
    assert signals["loop.turns"] > 0.9
    assert signals["loop.crossings"] == 0
    assert signals["loop.clearance"] > -0.1 * rope.diameter
    assert passing.signals(["loop.crossings"])["loop.crossings"] > 0
