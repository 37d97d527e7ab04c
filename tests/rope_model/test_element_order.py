"""Displacements and waves converge with the order of the element; its frames are those built from numbers."""

import math
from dataclasses import replace

import numpy as np
import pytest
from element_states import (
    ELEMENT,
    MATERIAL,
    STEP,
    STRAIN,
    Array,
    State,
    balance,
    energy,
    seeds,
    some_state,
    turned,
)
from rods import nothing_held, rod
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from shared import rotation, straight

from rope_model.parameters import Rope
from rope_model.physics import element
from rope_model.physics.element import PARAMETERS
from rope_model.physics.frame import smallest_rotation_rate
from rope_model.reference.statics import find_equilibrium

CANTILEVER = {"EI": 1.0, "Qa": 50.0, "Qd": 0.7}
LOAD = np.array([0.5, -3.0])


def elastica_tip() -> Array:
    """(2,) tip of the same cantilever, from the rod's own differential equation by shooting."""
    EI = CANTILEVER["EI"]
    Qa = CANTILEVER["Qa"]

    def rates(x: float, y: Array) -> Array:
        phi, phi_x = y[:2]
        t = np.array([np.cos(phi), np.sin(phi)])
        n = np.array([-np.sin(phi), np.cos(phi)])
        stretch = 1 + LOAD @ t / Qa
        return np.array([phi_x, -stretch * (LOAD @ n) / EI, *(stretch * t)])

    def shot(curvature: float) -> Array:
        y = solve_ivp(
            rates, (0.0, 1.0), [0.0, curvature, 0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13
        ).y
        return np.asarray(y[:, -1])

    return shot(brentq(lambda k: shot(k)[1], -3.0, 0.0, xtol=1e-13))[2:]


def cantilever_tip(elements: int, load: Array, torque: float, coupling: float = 0.0) -> Array:
    s = np.linspace(0.0, 1.0, elements + 1)
    q = straight(s)
    held = nothing_held(q)
    loads = np.zeros_like(q)
    held[0, [0, 1, 2, 4, 5, 6]] = True
    loads[-1, : load.size] = load
    loads[-1, 6] = torque
    P = np.array([(CANTILEVER | {"Qs": coupling}).get(name, 0.0) for name in PARAMETERS])
    # inertia for pseudo-transient continuation only
    P[0] = 1.0
    P[7] = 0.1
    return find_equilibrium(rod(np.diff(s), P, held, q, loads), q).q[-1, :3]


def test_displacements_converge_with_the_fourth_power_of_the_element_length() -> None:
    exact = elastica_tip()
    assert abs(exact[1]) > 0.5  # truly large: more than half the length
    errors = [np.linalg.norm(cantilever_tip(n, LOAD, 0.0)[:2] - exact) for n in (8, 16)]
    # cubic displacements: l^4; the last pair is in the asymptotic range
    np.testing.assert_allclose(np.log2(errors[-2] / errors[-1]), 4.0, atol=0.2)


@pytest.mark.parametrize(("coupling", "order"), [(0.0, 4.0), (2.0, 2.0)])
def test_with_torsion_in_space_they_do_so_but_for_the_coupling(
    coupling: float, order: float
) -> None:
    # a uniform torque without coupling means a uniform torsional strain: one for the element is no
    # approximation.  With coupling the strain follows the tension
    tips = [cantilever_tip(n, np.array([0.2, -2.0, 1.0]), 0.4, coupling) for n in (8, 16, 32, 64)]
    steps = np.linalg.norm(np.diff(tips, axis=0), axis=1)
    np.testing.assert_allclose(np.log2(steps[-2] / steps[-1]), order, atol=0.2)


def waves(P: Array, l: float, k: float) -> Array:
    """Frequencies (rad/s) of the waves of wave number ``k`` (1/m) along equal straight elements, slowest first."""
    q = np.zeros(14)
    none = np.zeros(14)
    q[[3, 7, 10]] = 1.0, l, 1.0
    F = np.asarray(ELEMENT.reference(q, l)).ravel()
    K, M = (
        np.asarray(ELEMENT.tangent(q, none, none, l, F, P, *c, q)[1])
        for c in ((1, 0, 0), (0, 0, 1))
    )
    along = [0, 3, 6]
    wave = np.zeros((14, 3), complex)
    wave[along] = np.eye(3)
    wave[[7 + i for i in along]] = np.exp(1j * k * l) * np.eye(3)
    K, M = (wave.conj().T @ matrix @ wave for matrix in (K, M))
    return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real))


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_torsional_waves_run_with_an_error_of_the_fourth_order(share: float) -> None:
    rope = Rope()
    k = 0.1
    x = np.array([0.1, 0.2, 0.4, 0.8])
    rope = replace(rope, Qb=share * rope.Qb, Qc=share * rope.Qc)
    stiffness = [[rope.Qa, rope.Qs], [rope.Qs, rope.Qd]]
    inertia = [rope.mass_per_length, rope.rhoJ]
    speed = math.sqrt(
        np.linalg.eigvals(np.array(stiffness) / np.array(inertia)[:, None]).real.min()
    )
    P = np.array(element.parameters(rope, 0.0))
    errors = np.array([waves(P, l, k)[0] for l in x / k]) / (k * speed) - 1
    np.testing.assert_allclose(np.diff(np.log(np.abs(errors))) / math.log(2), 4.0, atol=0.1)
    if share == 0:
        # the next term of the series, of sixth order, is below 6 % of this one
        np.testing.assert_allclose(errors, -(x**4) / 480, rtol=0.06)


def test_what_that_costs_the_longitudinal_wave_is_what_rayleigh_s_quotient_says() -> None:
    rope = Rope()
    k = 0.1
    x = 0.2
    P = np.array(element.parameters(rope, 0.0))
    stiffness = np.array([[rope.Qa, rope.Qs], [rope.Qs, rope.Qd]])
    square = np.linalg.eigvals(
        stiffness / np.array([rope.mass_per_length, rope.rhoJ])[:, None]
    ).real.max()
    strains = np.array([1.0, rope.Qs / (rope.rhoJ * square - rope.Qd)])
    too_much = square * P[PARAMETERS.index("rhoJ_x")] - rope.Qd / 12
    expected = -0.5 * x**2 * too_much * strains[1] ** 2 / (strains @ stiffness @ strains)
    found = waves(P, x / k, k) / (k * math.sqrt(square)) - 1
    # the next term is of the fourth order
    np.testing.assert_allclose(found[np.abs(found).argmin()], expected, rtol=0.01)
    np.testing.assert_allclose(expected, -8e-4 * x**2, rtol=0.06)


def test_the_inertia_of_the_slope_is_that_of_the_torsional_wave_where_it_is_the_faster_too() -> (
    None
):
    rope = replace(Rope(), Qb=0.0, Qc=0.0)
    for rhoJ in (rope.rhoJ, 1e-3 * rope.rhoJ):
        P = element.parameters(replace(rope, rhoJ=rhoJ), 0.0)
        np.testing.assert_allclose(P[PARAMETERS.index("rhoJ_x")], rhoJ / 12, rtol=1e-12)


def curve(x: Array) -> tuple[Array, Array, Array]:
    """r, r' (n, 3) and theta (n,) of a smooth, bent and twisted rope."""
    r = np.column_stack((np.sin(1.3 * x), x + 0.2 * x**2, 0.5 * np.cos(2 * x)))
    return (
        r,
        np.column_stack((1.3 * np.cos(1.3 * x), 1 + 0.4 * x, -np.sin(2 * x))),
        0.8 * np.sin(2 * x),
    )


def on_curve(l: float) -> Array:
    """(14,): an element of length l on the curve."""
    r, d, theta = curve(np.array([0.3, 0.3 + l]))
    return np.column_stack((r, d, theta)).ravel()


@seeds
def test_what_becomes_the_reference_keeps_its_energies_and_its_spin(seed: int) -> None:
    s = some_state(seed)
    P = s.P(**MATERIAL)
    q = s.q.copy()
    v = s.v.copy()
    gained = np.asarray(ELEMENT.transport(q, v, s.a, s.l, s.F)).ravel()
    q[13] += gained[0]
    own = State(q, v, s.a, s.l, q)
    before = energy(s.q, s.v, s.l, s.F, P, STRAIN)
    after = energy(q, v, s.l, own.F, P, STRAIN)
    np.testing.assert_allclose(after, before, rtol=1e-12)
    # the angle's rate at the right node and its own rate: those of the spin there
    d, d_t, d_tt = (x[10:13] for x in (s.q, s.v, s.a))
    p = s.reference[10:13] / np.linalg.norm(s.reference[10:13])

    def spin(t: float) -> float:
        at = d + t * d_t + 0.5 * t * t * d_tt
        rate = d_t + t * d_tt
        return float(smallest_rotation_rate(p, np.zeros(3), at, rate))

    expected = [spin(0.0), (spin(STEP) - spin(-STEP)) / (2 * STEP)]
    np.testing.assert_allclose(gained[1:], expected, rtol=1e-7, atol=1e-7)


def test_the_way_to_a_shape_does_not_matter_but_for_the_quadrature() -> None:
    rng = np.random.default_rng(2)
    error = []
    rest = np.zeros(14)
    maps = np.eye(3) + 0.4 * rng.normal(size=(3, 3, 3))
    for l in (0.2, 0.1, 0.05):
        shapes = [turned(on_curve(l), A) for A in maps]
        frames = [ELEMENT.reference(x, l) for x in shapes]
        turn = sum(
            float(ELEMENT.transport(shapes[k], rest, rest, l, frames[k - 1])[0]) for k in range(3)
        )
        # the frame at a node has turned by the area that the node's tangents enclose on the sphere
        first = area(*(x[3:6] for x in shapes))
        last = area(*(x[10:13] for x in shapes))
        error.append(abs(turn - (last - first)))
    # three Gauss points: error l^7 per element, or less where its factor changes sign
    assert np.min(np.log2(np.array(error[:-1]) / error[1:])) > 6.5


def area(*corners: Array) -> float:
    """Signed area of the spherical triangle of these directions."""
    a, b, c = (x / np.linalg.norm(x) for x in corners)
    return 2.0 * float(np.arctan2(a @ np.cross(b, c), 1 + a @ b + b @ c + c @ a))


def test_a_rigid_rotation_dissipates_nothing_but_for_the_interpolation() -> None:
    # the angle is linear between the nodes, so is its rate: the spin of a section errs by l^2, the
    # power by its square
    w = np.array([0.3, -1.1, 0.7])
    power = []
    for l in (0.1, 0.05, 0.025):
        q = on_curve(l)
        v = np.zeros(14)
        for k in (0, 3, 7, 10):
            v[k : k + 3] = np.cross(w, q[k : k + 3])
        v[[6, 13]] = [w @ q[k : k + 3] / np.linalg.norm(q[k : k + 3]) for k in (3, 10)]
        s = State(q, v, v, l, q)
        P = s.P(Qa=5.0, Qs=0.8, Qd=2.0, EI=1.5, beta_K=0.3, root_a=1.3, root_b=0.7)
        power.append(balance(q, v, l, s.F, P)["damping_power"] / l)
        v[13] += l  # and a rotation with twisting does
        assert balance(q, v, l, s.F, P)["damping_power"] / l > 1e-3
    np.testing.assert_allclose(np.log2(np.array(power[:-1]) / power[1:]), 4.0, atol=0.3)


def smallest_rotation(pole: Array, t: Array) -> Array:
    """(3, 3): the smallest rotation from ``pole`` to ``t``."""
    axis = np.cross(pole, t)
    sine = float(np.linalg.norm(axis))
    cosine = float(pole @ t)
    return rotation(axis / sine * np.arctan2(sine, cosine))


@seeds
def test_the_frame_rate_is_how_fast_the_frame_turns_about_the_tangent(seed: int) -> None:
    s = some_state(seed)
    rng = np.random.default_rng(seed)
    d = s.q[3:6]
    pole = s.reference[3:6]
    change, pole_change = rng.normal(size=(2, 3))

    def unit(x: Array) -> Array:
        return np.asarray(x / np.linalg.norm(x))

    def frame_at(x: float) -> Array:
        p = unit(pole + x * pole_change)
        # carried along to the neighbour of the pole without turning about it
        carried = np.eye(3)
        if x != 0.0:
            carried = smallest_rotation(unit(pole), p)
        return smallest_rotation(p, unit(d + x * change)) @ carried

    here = frame_at(0.0)
    np.testing.assert_allclose(here @ unit(pole), unit(d), atol=1e-15)
    # d(frame)/dx frame^T is the cross product with the turning vector
    spin = (frame_at(STEP) - frame_at(-STEP)) / (2 * STEP) @ here.T
    turning = 0.5 * np.array(
        [spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]]
    )
    turn = np.cross(pole, pole_change) / (pole @ pole)
    found = smallest_rotation_rate(unit(pole), turn, d, change)
    np.testing.assert_allclose(found, turning @ unit(d), rtol=1e-6, atol=1e-7)


def test_a_section_turned_with_the_rope_has_the_twist_of_the_element() -> None:
    # carried along the curve, turning at tau about the tangent: theta' = tau where the curve is the
    # reference
    pole = np.array([0.6, 0.0, 0.8])
    rate = 0.7

    def tangent(x: float) -> Array:
        d = curve(np.array([x]))[1][0]
        return np.asarray(d / np.linalg.norm(d))

    def rotation(x: float, m: Array) -> Array:
        t = tangent(x)
        t_x = (tangent(x + STEP) - tangent(x - STEP)) / (2 * STEP)
        return np.cross(np.cross(t, t_x) + rate * t, m)

    e = np.array([0.0, 1.0, 0.0])  # across the pole
    start = smallest_rotation(pole, tangent(0.0)) @ e
    section = solve_ivp(rotation, (0.0, 1.0), start, rtol=1e-10, atol=1e-12).y[:, -1]
    # the same from a straight reference along the pole, to the curve's own
    zero = smallest_rotation(pole, tangent(1.0)) @ e
    t = tangent(1.0)
    theta = np.arctan2(np.cross(zero, section) @ t, zero @ section)
    straight_rope = np.tile(np.concatenate((np.zeros(3), pole, [0.0])), 2)
    s = np.linspace(0.0, 1.0, 21)
    gained = 0.0
    rest = np.zeros(14)
    for i in range(20):
        r, d, _ = curve(s[i : i + 2])
        straight_rope[7:10] = pole * (s[i + 1] - s[i])
        F = ELEMENT.reference(straight_rope, s[i + 1] - s[i])
        q = np.column_stack((r, d, np.zeros(2))).ravel()
        gained += float(ELEMENT.transport(q, rest, rest, s[i + 1] - s[i], F)[0])
    # cubics of 1/20 of the curve
    np.testing.assert_allclose(theta + gained, rate, atol=1e-5)
