"""Friction between the wires of a bent rope: the law, the element that has it, and the rope with it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from native_parts import carry
from numpy.testing import assert_allclose, assert_array_equal
from scenes import passed
from shared import Array, difference
from wire_scenes import scene

from rope_model import Rope, Solver
from rope_model.physics.element import (
    ELEMENT_DOF,
    POINTS,
    ElementFidelity,
    element_functions,
    parameters,
)
from rope_model.physics.node import NODE_DOF
from rope_model.physics.wire_element import TANGENT_SIZE, wire_functions
from rope_model.physics.wire_friction import (
    POINT_STATE_SIZE,
    BoucWenStep,
    bouc_wen_step,
    section_at,
    slip_curvature,
    wire_stiffness,
)

#: 1/m
K0 = 0.02
#: a rope with k0 = K0, whatever its tension
ROPE = Rope(length=10.0, EI=300.0, EI_stick=1300.0, slip_moment=20.0, slip_factor=0.0)


def bent(z: float, before: float, after: float) -> BoucWenStep:
    """A section of a straight rope whose curvature about one axis goes from ``before`` to ``after``."""
    straight = 1.0, 0.0, 0.0
    return bouc_wen_step(
        (*straight, 0.0, before, 0.0, 0.0, 0.0, z, 0.0), (*straight, 0.0, after, 0.0, 0.0), K0
    )


def path(curvatures: Array) -> tuple[Array, Array]:
    """z, and what was dissipated so far, along a path that begins at 0."""
    z = 0.0
    k = 0.0
    found = [(0.0, 0.0)]
    for after in curvatures[1:]:
        slid = bent(z, k, float(after))
        z = slid.z[1]
        k = float(after)
        found.append((z, found[-1][1] + slid.dissipated))
    of_z, of_loss = np.array(found).T
    return of_z, of_loss


def test_the_law_is_that_of_the_ropes_stiffnesses_and_tension() -> None:
    rope = replace(ROPE, slip_factor=0.02)
    C = wire_stiffness(rope)
    assert C == 1000.0
    assert slip_curvature(rope, C, 0.0, 0.0) == pytest.approx(K0)
    # 1.2e8 N times 1e-4 is 12 kN
    assert slip_curvature(rope, C, 1e-4, 0.0) == pytest.approx(
        (20.0 + 0.02 * 0.044 * 12e3) / 1000.0
    )
    assert slip_curvature(rope, C, -1e-4, 0.0) == pytest.approx(K0)


def test_a_fresh_rope_follows_the_hyperbolic_tangent() -> None:
    k = np.linspace(0.0, 5 * K0, 101)
    z, loss = path(k)
    # the series of sinh leaves s^7/5040 of a step s = 0.05
    assert_allclose(z, K0 * np.tanh(k / K0), rtol=1e-10)
    assert_allclose(
        loss, K0**2 * (np.log(np.cosh(k / K0)) - 0.5 * np.tanh(k / K0) ** 2), atol=1e-12 * K0**2
    )


@pytest.mark.parametrize("length", [0.3, 1.0, 3.0, 100.0])
def test_a_step_may_have_any_length(length: float) -> None:
    """As far as the series of sinh goes: to 0.06 % of k0 at its worst, and where all wires slide to the end."""
    whole = bent(0.0, 0.0, length * K0)
    parts = path(np.linspace(0.0, length * K0, 1001))[0]
    assert whole.z[1] == pytest.approx(parts[-1], abs=6e-4 * K0)
    assert bent(0.9 * K0, 0.0, 50 * K0).z[1] == pytest.approx(K0, abs=1e-9)


@pytest.mark.parametrize("amplitude", [0.8, 1.5, 4.0])
def test_a_steady_cycle_loses_what_the_closed_form_says(amplitude: float) -> None:
    """Half a cycle takes the moment elastically from its largest to 0 and on as that of a fresh rope."""
    z, loss = path(amplitude * K0 * np.sin(2 * math.pi * np.linspace(0, 30, 400 * 30 + 1)))
    largest = np.abs(z[-401:]).max() / K0
    # where the moment has that size, so has the curvature the amplitude; peaks lie on the path's
    # points
    assert 0.5 * (largest + math.atanh(largest)) == pytest.approx(amplitude, rel=1e-6)
    expected = -(K0**2) * (largest**2 + math.log1p(-(largest**2)))
    # turning points lie within steps no longer than 0.06 K0
    assert loss[-1] - loss[-401] == pytest.approx(expected, rel=1e-5)


def test_below_slip_next_to_nothing_is_lost() -> None:
    """With the fourth power of the curvature, while the work goes with the square; and nothing when it is let go."""
    losses = [bent(0.0, 0.0, part * K0).dissipated for part in (0.1, 0.05)]
    assert losses[0] == pytest.approx(0.25 * 0.1**4 * K0**2, rel=1e-2)
    assert losses[0] / losses[1] == pytest.approx(16.0, rel=1e-2)
    back = bent(0.7 * K0, 0.0, -0.7 * K0)
    assert_allclose(back.z, 0.0, atol=1e-12 * K0)
    assert back.dissipated < 1e-13 * K0**2


def random_sections(seed: int, number: int) -> tuple[Array, Array]:
    """(10, number), (7, number): sections that bend, turn and spin, with any z that friction can have."""
    chance = np.random.default_rng(seed)
    before = chance.normal(size=(POINT_STATE_SIZE, number))
    now = chance.normal(size=(7, number))
    now[:3] = before[:3] + 0.3 * now[:3]
    for x in (before, now):
        x[:3] /= np.linalg.norm(x[:3], axis=0)
        x[3:6] -= x[:3] * (x[:3] * x[3:6]).sum(axis=0)
    before[7:] -= before[:3] * (before[:3] * before[7:]).sum(axis=0)
    before[7:] *= K0 * chance.uniform(size=number) / np.linalg.norm(before[7:], axis=0)
    now[3:6] = before[3:6] + 10 ** chance.uniform(-3, 1, number) * K0 * now[3:6]
    now[3:6] -= now[:3] * (now[:3] * now[3:6]).sum(axis=0)
    return before, now


def test_friction_only_takes_energy_and_holds_no_more_than_its_moment() -> None:
    before, now = random_sections(1, 2000)
    slid = bouc_wen_step(before, now, K0)
    assert (slid.dissipated >= 0).all()
    assert (np.linalg.norm(slid.z, axis=0) <= K0 * (1 + 1e-12)).all()
    assert_allclose(
        (now[:3] * np.array(slid.z)).sum(axis=0), 0.0, atol=1e-12 * K0
    )  # across the rope


def test_what_turns_as_a_whole_remembers_all() -> None:
    """The section's frame, carried by the smallest rotation of the tangent and turned about it."""
    before, now = random_sections(2, 200)
    angle = 0.2
    t = now[:3]
    p = before[:3]

    def turned(x: Array) -> Array:
        y = x - (t * x).sum(axis=0) / (1 + (p * t).sum(axis=0)) * (p + t)
        return np.cos(angle) * y + np.sin(angle) * np.cross(t, y, axis=0)

    now[3:6] = turned(before[3:6])
    now[6] = before[6] + angle
    slid = bouc_wen_step(before, now, K0)
    # the turn errs by 34 / 40320 of angle^7, 1e-8, times a curvature of up to 5 1/m
    assert_allclose(slid.z, turned(before[7:]), atol=6e-8)
    assert (slid.dissipated < 6e-8 * K0).all()


def element_state(fidelity: ElementFidelity, seed: int) -> Array:
    chance = np.random.default_rng(seed)
    q = np.zeros((2, NODE_DOF))
    q[:, 3:6] = [0.6, -0.8, 0.0]
    q[1, :3] = [1.2, -1.6, 0.0]
    kept = list(ELEMENT_DOF[fidelity])
    q[:, kept] += 0.02 * chance.normal(size=(2, len(kept)))
    return q


def at_rest(q: Array, z: Array) -> Array:
    """The history of an element that moves on from ``q`` and ``z``, without strain."""
    known = [
        np.concatenate([np.array(section_at(xi, 2.0, q.ravel())).ravel(), of_point])
        for xi, of_point in zip(POINTS, z.reshape(-1, 3), strict=True)
    ]
    stiffness = wire_stiffness(ROPE)
    return np.array([*np.concatenate(known), slip_curvature(ROPE, stiffness, 0.0, 0.0), stiffness])


@pytest.mark.parametrize("fidelity", ELEMENT_DOF)
def test_while_wires_stick_the_residual_is_the_derivative_of_the_energy(
    fidelity: ElementFidelity,
) -> None:
    wires = wire_functions(fidelity)
    kept = list(ELEMENT_DOF[fidelity])
    before = element_state(fidelity, 1)
    now = element_state(fidelity, 1) + 1e-4 * element_state(fidelity, 2)
    nodes = before.ravel(), now.ravel()
    z = []
    for xi in POINTS:  # the moment falls on the way to `now`
        of_before, of_now = (np.array(section_at(xi, 2.0, x)) for x in nodes)
        z.append(-5.0 * (of_now[3:6] - of_before[3:6]))
        z[-1] -= of_before[:3] * (of_before[:3] @ z[-1])
    H = at_rest(before, np.array(z))
    H[-2] = 1e3  # 1/m: nothing slides

    def energy(x: Array) -> float:
        q = now.copy()
        q[:, kept] = x.reshape(2, -1)
        return float(wires.energy(q[:, kept].ravel(), 2.0, H))

    x = now[:, kept].ravel()
    R = np.array(wires.residual(x, 2.0, H)).ravel()
    assert np.abs(R).max() > 1e-3
    assert_allclose(R, difference(energy, x, 1e-6), atol=1e-5 * np.abs(R).max())


@pytest.mark.parametrize("fidelity", ELEMENT_DOF)
def test_at_rest_a_fresh_rope_has_the_stiffness_of_wires_that_stick(
    fidelity: ElementFidelity,
) -> None:
    plain = element_functions(fidelity)
    wires = wire_functions(fidelity)
    kept = list(ELEMENT_DOF[fidelity])
    q = element_state(fidelity, 3)[:, kept].ravel()
    still = np.zeros(2 * len(kept))
    stuck = np.array(
        wires.tangent(
            q, 2.0, at_rest(element_state(fidelity, 3), np.zeros(9)), np.zeros(TANGENT_SIZE), 1.0
        )
    )
    H = at_rest(element_state(fidelity, 3), np.zeros(9))
    slopes = difference(lambda x: np.array(wires.residual(x, 2.0, H)).ravel(), q, 1e-7)
    assert_allclose(stuck, slopes, atol=1e-6 * np.abs(stuck).max())
    # of a straight rope bending is all there is to it
    straight = element_state(fidelity, 3)
    straight[:, 3:6] = [0.6, -0.8, 0.0]
    straight[1, :3] = straight[0, :3] + [1.2, -1.6, 0.0]
    straight[:, 6] = 0.0
    q = straight[:, kept].ravel()
    F = np.array(plain.reference(q, 2.0))
    stiff, soft = (
        np.array(
            plain.tangent(
                q, still, still, 2.0, F, np.array(parameters(Rope(EI=EI), 9.81)), 1.0, 0.0, 0.0, q
            )[1]
        )
        for EI in (ROPE.EI_stick, ROPE.EI)
    )
    added = np.array(
        wires.tangent(q, 2.0, at_rest(straight, np.zeros(9)), np.zeros(TANGENT_SIZE), 1.0)
    )
    assert_allclose(added, stiff - soft, atol=1e-9 * np.abs(stiff).max())


def test_a_change_of_the_mesh_makes_no_energy_and_keeps_the_moments_sum() -> None:
    chance = np.random.default_rng(5)
    old = np.array([4.0, 2.0, 1.0, 1.0, 1.0, 2.0, 4.0])
    new = np.array([4.0, 2.0, 2.0, 1.0, 1.0, 1.0, 4.0])
    z = chance.normal(size=(old.size, 9))
    carried = carry(z, old, new)
    weights = np.array([5, 8, 5]) / 18

    def sums(x: Array, lengths: Array) -> tuple[Array, float]:
        points = x.reshape(-1, 3)
        parts = np.outer(lengths, weights).ravel()
        return parts @ points, float(parts @ (points**2).sum(axis=1))

    moment, energy = sums(z, old)
    moment_after, energy_after = sums(carried, new)
    assert_allclose(moment_after, moment, atol=1e-12)
    assert energy_after < energy
    assert_array_equal(carried[[0, 1, 6]], z[[0, 1, 6]])  # what lies where it lay, to the bit


def test_what_the_wires_take_is_in_the_energy_balance() -> None:
    energy = passed(scene(), 200).state.energy_balance
    assert energy.dissipated_wires > 10 * energy.dissipated_material > 0
    assert abs(energy.residual) < 2e-3 * energy.dissipated_wires


def test_steps_converge_with_the_second_order() -> None:
    """Also where the friction moment follows the tension, which it does by steps."""

    def swung(step: float) -> Array:
        of = scene(EI_stick=1300.0, slip_moment=20.0, beta_K=0.01)
        free = Solver(step_max=step, tolerance=1e6, newton_tolerance=1e-10, rho_inf=0.8)
        return passed(replace(of, solver=free), round(1.0 / step), step).state.motion.q

    exact = swung(1 / 1280)
    # 40 steps a second do not resolve where wires reverse their sliding
    errors = [np.abs(swung(1 / n) - exact).max() for n in (80, 160, 320)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 1.7).all(), (errors, orders)
