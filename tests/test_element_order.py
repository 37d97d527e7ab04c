"""Displacements of a chain of elements, and waves along it, converge with the order of the element."""

import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import Chain, portable_system, straight
from element_states import ELEMENT, Array
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rope_model.parameters import Rope
from rope_model.physics import element
from rope_model.physics.element import PARAMETERS
from rope_model.simulation.stepping.statics import find_equilibrium

CANTILEVER = {"EI": 1.0, "Qa": 50.0, "Qd": 0.7}
LOAD = np.array([0.5, -3.0])


def elastica_tip() -> Array:
    """(2,) tip of the same cantilever, from the rod's own differential equation by shooting."""
    EI, Qa = CANTILEVER["EI"], CANTILEVER["Qa"]

    def rates(x: float, y: Array) -> Array:
        phi, phi_x = y[:2]
        t, n = np.array([np.cos(phi), np.sin(phi)]), np.array([-np.sin(phi), np.cos(phi)])
        stretch = 1 + LOAD @ t / Qa
        return np.array([phi_x, -stretch * (LOAD @ n) / EI, *(stretch * t)])

    def shot(curvature: float) -> Array:
        y = solve_ivp(rates, (0.0, 1.0), [0.0, curvature, 0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13).y
        return np.asarray(y[:, -1])

    return shot(brentq(lambda k: shot(k)[1], -3.0, 0.0, xtol=1e-13))[2:]


def cantilever_tip(elements: int, load: Array, torque: float, coupling: float = 0.0) -> Array:
    s = np.linspace(0.0, 1.0, elements + 1)
    chain = Chain.unloaded(straight(s))
    chain.held[0, [0, 1, 2, 4, 5, 6]] = True
    chain.loads[-1, : load.size], chain.loads[-1, 6] = load, torque
    P = np.array([(CANTILEVER | {"Qs": coupling}).get(name, 0.0) for name in PARAMETERS])
    P[0], P[7] = 1.0, 0.1  # inertia for pseudo-transient continuation only
    return find_equilibrium(portable_system(np.diff(s), P, chain), chain.values).q[-1, :3]


def test_displacements_converge_with_the_fourth_power_of_the_element_length() -> None:
    exact = elastica_tip()
    assert abs(exact[1]) > 0.5  # truly large: more than half the length
    errors = [np.linalg.norm(cantilever_tip(n, LOAD, 0.0)[:2] - exact) for n in (8, 16)]
    # cubic displacements: l^4; the last pair is in the asymptotic range
    np.testing.assert_allclose(np.log2(errors[-2] / errors[-1]), 4.0, atol=0.2)


@pytest.mark.parametrize(("coupling", "order"), [(0.0, 4.0), (2.0, 2.0)])
def test_with_torsion_in_space_they_do_so_but_for_the_coupling(coupling: float, order: float) -> None:
    # a uniform torque without coupling means a uniform torsional strain: one for the element is no approximation.  With
    # coupling the strain follows the tension
    tips = [cantilever_tip(n, np.array([0.2, -2.0, 1.0]), 0.4, coupling) for n in (8, 16, 32, 64)]
    steps = np.linalg.norm(np.diff(tips, axis=0), axis=1)
    np.testing.assert_allclose(np.log2(steps[-2] / steps[-1]), order, atol=0.2)


def waves(P: Array, l: float, k: float) -> Array:
    """Frequencies (rad/s) of the waves of wave number ``k`` (1/m) along equal straight elements, slowest first."""
    q, none = np.zeros(14), np.zeros(14)
    q[[3, 7, 10]] = 1.0, l, 1.0
    F = np.asarray(ELEMENT.reference(q, l)).ravel()
    K, M = (np.asarray(ELEMENT.tangent(q, none, none, l, F, P, *c)[1]) for c in ((1, 0, 0), (0, 0, 1)))
    along = [0, 3, 6]
    wave = np.zeros((14, 3), complex)
    wave[along], wave[[7 + i for i in along]] = np.eye(3), np.exp(1j * k * l) * np.eye(3)
    K, M = (wave.conj().T @ matrix @ wave for matrix in (K, M))
    return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real))


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_torsional_waves_run_with_an_error_of_the_fourth_order(share: float) -> None:
    rope, k, x = Rope(), 0.1, np.array([0.1, 0.2, 0.4, 0.8])
    rope = replace(rope, Qb=share * rope.Qb, Qc=share * rope.Qc)
    stiffness, inertia = [[rope.Qa, rope.Qs], [rope.Qs, rope.Qd]], [rope.mass_per_length, rope.rhoJ]
    speed = math.sqrt(np.linalg.eigvals(np.array(stiffness) / np.array(inertia)[:, None]).real.min())
    P = np.array(element.parameters(rope, 0.0))
    errors = np.array([waves(P, l, k)[0] for l in x / k]) / (k * speed) - 1
    np.testing.assert_allclose(np.diff(np.log(np.abs(errors))) / math.log(2), 4.0, atol=0.1)
    if share == 0:
        # the next term of the series, of sixth order, is below 6 % of this one
        np.testing.assert_allclose(errors, -(x**4) / 480, rtol=0.06)


def test_what_that_costs_the_longitudinal_wave_is_what_rayleigh_s_quotient_says() -> None:
    rope, k, x = Rope(), 0.1, 0.2
    P = np.array(element.parameters(rope, 0.0))
    stiffness = np.array([[rope.Qa, rope.Qs], [rope.Qs, rope.Qd]])
    square = np.linalg.eigvals(stiffness / np.array([rope.mass_per_length, rope.rhoJ])[:, None]).real.max()
    strains = np.array([1.0, rope.Qs / (rope.rhoJ * square - rope.Qd)])
    too_much = square * P[PARAMETERS.index("rhoJ_x")] - rope.Qd / 12
    expected = -0.5 * x**2 * too_much * strains[1] ** 2 / (strains @ stiffness @ strains)
    found = waves(P, x / k, k) / (k * math.sqrt(square)) - 1
    # the next term is of the fourth order
    np.testing.assert_allclose(found[np.abs(found).argmin()], expected, rtol=0.01)
    np.testing.assert_allclose(expected, -8e-4 * x**2, rtol=0.06)


def test_the_inertia_of_the_slope_is_that_of_the_torsional_wave_where_it_is_the_faster_too() -> None:
    rope = replace(Rope(), Qb=0.0, Qc=0.0)
    for rhoJ in (rope.rhoJ, 1e-3 * rope.rhoJ):
        P = element.parameters(replace(rope, rhoJ=rhoJ), 0.0)
        np.testing.assert_allclose(P[PARAMETERS.index("rhoJ_x")], rhoJ / 12, rtol=1e-12)
