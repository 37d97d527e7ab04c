"""Every force against its energy, every tangent against its force, the frames against frames built from numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from conftest import Chain, portable_system, rotation, straight
from numpy.polynomial.polynomial import polyder, polyval
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from evidence.stability.counterexamples import tait_bryan_rate
from rope_model.physics import costello
from rope_model.physics.element import BALANCE, ELEMENT_DOF, NODE_DOF, PARAMETERS, ElementFidelity, element_functions
from rope_model.physics.frame import FrameRate, pole_change_angle, smallest_rotation_rate
from rope_model.simulation.statics import find_equilibrium

Array = NDArray[np.float64]

ELEMENT = element_functions()
STRAIN = ("axial", "coupling", "torsion", "bending")
SEEDS = range(6)
MATERIAL = {"rho": 1.3, "g": 9.8, "Qa": 5.0, "Qs": 0.8, "Qk": 0.3, "Qd": 2.0, "EI": 1.5, "rhoJ": 0.4, "beta_K": 0.3}
#: a central difference with this step errs by its square, and by rounding over it: both below 1e-9
STEP = 1e-5


@dataclass(frozen=True)
class State:
    """An element somewhere, in some motion; ``pole`` is the frame's."""

    q: Array
    v: Array
    a: Array
    l: float
    pole: Array

    def P(self, **material: float) -> Array:
        """The element's parameters; what is not given is zero."""
        return np.array([*(material.get(name, 0.0) for name in PARAMETERS[:9]), *self.pole])


def random_state(seed: int) -> State:
    """A bent, twisted, stretched element turned anywhere; strains are of order 0.1 to 1."""
    rng = np.random.default_rng(seed)
    l, turn = rng.uniform(0.5, 2.0), rotation(rng.normal(size=3))
    slopes = (np.array([1.2, 0.0, 0.0]) + 0.25 * rng.normal(size=(2, 3))) @ turn.T
    left = rng.normal(size=3)
    right = left + l * (slopes.mean(axis=0) + 0.1 * rng.normal(size=3))
    q = np.concatenate((left, slopes[0], rng.normal(size=1), right, slopes[1], rng.normal(size=1)))
    # any pole that is not opposite the tangents
    pole = turn @ [1.0, 0.0, 0.0] + 0.7 * rng.normal(size=3) / np.sqrt(3)
    return State(q, rng.normal(size=14), rng.normal(size=14), l, pole / np.linalg.norm(pole))


def residual(q: Array, v: Array, a: Array, l: float, P: Array) -> Array:
    return np.asarray(ELEMENT.residual(q, v, a, l, P)).ravel()


def balance(q: Array, v: Array, l: float, P: Array) -> dict[str, float]:
    return dict(zip(BALANCE, np.asarray(ELEMENT.balance(q, v, l, P)).ravel().tolist(), strict=True))


def energy(q: Array, v: Array, l: float, P: Array, names: tuple[str, ...]) -> float:
    parts = balance(q, v, l, P)
    return sum(parts[name] for name in names)


def difference(f: Callable[[Array], Array | float], x: Array, step: float = STEP) -> Array:
    """Columns df/dx_i by central differences."""
    columns = [(np.asarray(f(x + d)) - np.asarray(f(x - d))) / (2 * step) for d in step * np.eye(x.size)]
    return np.stack(columns, axis=-1)


# energies against their definition


def interpolate(x: Array, xi: Array, l: float) -> tuple[Array, Array, Array]:
    """r, r', r'' (3, n) at xi of an element's degrees of freedom ``x`` (14,)."""
    ends = np.array([x[0:3], l * x[3:6], x[7:10], l * x[10:13]])
    hermite = np.array([[1.0, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]])
    rates = [np.array([polyval(xi, polyder(shape, k)) for shape in hermite]) / l**k for k in range(3)]
    r, d, c = (ends.T @ rate for rate in rates)
    return r, d, c


@pytest.mark.parametrize("seed", SEEDS)
def test_the_balance_holds_the_integrals_of_the_theory(seed: int) -> None:
    s, m = random_state(seed), MATERIAL
    parts = balance(s.q, s.v, s.l, s.P(**m))
    # polynomials of degree six: exact with four points; strains by the element's three
    for points, names in ((4, ("kinetic", "gravity")), (3, (*STRAIN, "spin"))):
        xi, weights = np.polynomial.legendre.leggauss(points)
        at = 0.5 + 0.5 * xi
        r, d, c = interpolate(s.q, at, s.l)
        r_t, d_t, _ = interpolate(s.v, at, s.l)
        theta_x, theta_t = (s.q[13] - s.q[6]) / s.l, s.v[6] + at * (s.v[13] - s.v[6])
        stretch = np.linalg.norm(d, axis=0)
        t = d / stretch
        t_x, t_t = ((x - t * np.sum(t * x, axis=0)) / stretch for x in (c, d_t))
        e, k = stretch - 1, np.linalg.norm(np.cross(d, c, axis=0), axis=0) / stretch**2
        tau, w = (
            x - s.pole @ np.cross(t, change, axis=0) / (1 + s.pole @ t)
            for x, change in ((theta_x, t_x), (theta_t, t_t))
        )
        density = {
            "axial": 0.5 * m["Qa"] * e**2,
            "coupling": m["Qs"] * e * tau,
            "torsion": 0.5 * m["Qd"] * tau**2,
            "bending": 0.5 * m["EI"] * k**2,
            "kinetic": 0.5 * m["rho"] * np.sum(r_t**2, axis=0),
            "spin": 0.5 * m["rhoJ"] * w**2,
            "gravity": m["rho"] * m["g"] * r[1],
        }
        expected = [0.5 * s.l * float(weights @ density[name]) for name in names]
        np.testing.assert_allclose([parts[name] for name in names], expected, rtol=1e-11)  # rounding


# forces against energies


@pytest.mark.parametrize("seed", SEEDS)
def test_the_elastic_force_is_the_gradient_of_the_strain_energy(seed: int) -> None:
    s = random_state(seed)
    P = s.P(Qa=5.0, Qs=0.8, Qd=2.0, EI=1.5)
    rest = np.zeros(14)
    gradient = difference(lambda q: energy(q, rest, s.l, P, STRAIN), s.q)
    # truncation STEP^2 times third derivatives of order 10 to 100
    np.testing.assert_allclose(residual(s.q, rest, rest, s.l, P), gradient, rtol=0, atol=1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_weight_is_the_gradient_of_the_potential_energy(seed: int) -> None:
    s = random_state(seed)
    P, rest = s.P(rho=1.3, g=9.8), np.zeros(14)
    gradient = difference(lambda q: energy(q, rest, s.l, P, ("gravity",)), s.q)
    # linear: only rounding
    np.testing.assert_allclose(residual(s.q, rest, rest, s.l, P), gradient, rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_inertia_force_is_lagranges_derivative_of_the_kinetic_energy(seed: int) -> None:
    s = random_state(seed)
    P = s.P(rho=1.3, rhoJ=0.4)

    def kinetic(q: Array, v: Array) -> float:
        return energy(q, v, s.l, P, ("kinetic", "spin"))

    def momentum(t: float) -> Array:
        q, v = s.q + t * s.v + 0.5 * t * t * s.a, s.v + t * s.a
        # the energy is quadratic in v: the difference is exact for any step
        return difference(lambda x: kinetic(q, x), v, step=1.0)

    change = (momentum(1e-4) - momentum(-1e-4)) / 2e-4
    gradient = difference(lambda q: kinetic(q, s.v), s.q)
    # truncation 1e-8 times third time derivatives of order 10 to 100
    np.testing.assert_allclose(residual(s.q, s.v, s.a, s.l, P), change - gradient, rtol=0, atol=1e-5)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_damping_force_takes_the_damping_power_out_of_the_motion(seed: int) -> None:
    s = random_state(seed)
    rest = np.zeros(14)
    P = s.P(Qa=5.0, Qs=0.8, Qd=2.0, EI=1.5, beta_K=0.3)
    force = residual(s.q, s.v, rest, s.l, P) - residual(s.q, rest, rest, s.l, P)
    power = balance(s.q, s.v, s.l, P)["damping_power"]
    assert power > 0
    np.testing.assert_allclose(force @ s.v, power, rtol=1e-12)  # an identity


def test_the_damping_power_is_never_negative() -> None:
    rng = np.random.default_rng(7)
    powers = []
    for seed in range(40):
        s = random_state(seed)
        # coupling up to its limit sqrt(Qa Qd), where one combination of the rates costs nothing
        Qs = np.sqrt(5.0 * 2.0) * rng.uniform(-1, 1)
        P = s.P(Qa=5.0, Qs=Qs, Qd=2.0, EI=1.5, beta_K=0.3)
        powers.append(balance(s.q, rng.normal(size=14), s.l, P)["damping_power"])
    assert min(powers) >= 0


@pytest.mark.parametrize("seed", SEEDS)
def test_the_force_without_energy_takes_up_the_power_the_balance_says(seed: int) -> None:
    s = random_state(seed)
    P, rest = s.P(Qk=0.3), np.zeros(14)
    power = residual(s.q, rest, rest, s.l, P) @ s.v
    np.testing.assert_allclose(power, balance(s.q, s.v, s.l, P)["nonconservative_power"], rtol=1e-12)  # an identity


def test_a_closed_cycle_of_strain_does_the_work_of_qb_minus_qc() -> None:
    # straight, so that e and tau are those of the degrees of freedom: an ellipse in the strain plane
    l, Qk, e_0, tau_0 = 1.7, 0.3, 0.1, 0.4
    s = random_state(0)
    P = State(s.q, s.v, s.a, l, np.array([1.0, 0.0, 0.0])).P(Qa=5.0, Qs=0.8, Qk=Qk, Qd=2.0)
    work, energy_balance, phases = 0.0, 0.0, np.arange(64) * 2 * np.pi / 64
    for phi in phases:
        q, v = np.zeros(14), np.zeros(14)
        q[[3, 10]], q[7], q[13] = 1 + e_0 * np.cos(phi), l * (1 + e_0 * np.cos(phi)), l * tau_0 * np.sin(phi)
        v[[3, 10]], v[7], v[13] = -e_0 * np.sin(phi), -l * e_0 * np.sin(phi), l * tau_0 * np.cos(phi)
        work += residual(q, v, np.zeros(14), l, P) @ v * 2 * np.pi / 64
        energy_balance += balance(q, v, l, P)["nonconservative_power"] * 2 * np.pi / 64
    # twice Qk times the enclosed area, negative for this sense; the trapezoidal rule is exact on a circle
    np.testing.assert_allclose([work, energy_balance], -2 * np.pi * Qk * e_0 * tau_0 * l, rtol=1e-12)


def test_costellos_law_is_the_gradient_of_its_energy_plus_the_remainder() -> None:
    Qa, Qs, Qk, Qd, e, tau = 5.0, 0.8, 0.3, 2.0, 0.12, -0.4

    def U(x: Array) -> float:
        return float(costello.strain_energy(Qa, Qs, Qd, x[0], x[1]))

    dU = difference(U, np.array([e, tau]))
    law = [costello.tension(Qa, Qs, Qk, e, tau), costello.torque(Qs, Qk, Qd, e, tau)]
    np.testing.assert_allclose(law, dU + Qk * np.array([tau, -e]), rtol=1e-9)  # quadratic: rounding only
    np.testing.assert_allclose(law, [Qa * e + 1.1 * tau, 0.5 * e + Qd * tau], rtol=1e-14)  # Qb = 1.1, Qc = 0.5


# tangents against forces


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("c", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.7, 1.9, 0.4)])
@pytest.mark.parametrize("fidelity", ELEMENT_DOF)
def test_at_rest_the_tangent_is_the_derivative_of_the_residual(
    fidelity: ElementFidelity, seed: int, c: tuple[float, float, float]
) -> None:
    s, element = random_state(seed), element_functions(fidelity)
    kept = [*ELEMENT_DOF[fidelity], *(NODE_DOF + i for i in ELEMENT_DOF[fidelity])]
    q, rest, P = s.q[kept], np.zeros(len(kept)), s.P(**(MATERIAL | {"Qk": 0.0}))

    def force(q: Array, v: Array, a: Array) -> Array:
        return np.asarray(element.residual(q, v, a, s.l, P)).ravel()

    R, J = (np.asarray(x) for x in element.tangent(q, rest, rest, s.l, P, *c))
    along = difference(lambda x: force(q + c[0] * x, c[1] * x, c[2] * x), rest, STEP / 8)
    # truncation of second order: up to 1e-6 where a planar element is nearly compressed to a point
    np.testing.assert_allclose(J, along, rtol=0, atol=1e-9 * np.abs(J).max() + 1e-6)
    np.testing.assert_allclose(R.ravel(), force(q, rest, rest), rtol=1e-12, atol=1e-12)
    v, a = s.v[kept], s.a[kept]
    np.testing.assert_allclose(element.tangent(q, v, a, s.l, P, *c)[0], force(q, v, a)[:, None], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_what_the_tangent_leaves_out_in_motion_is_of_the_first_order_in_the_speed(seed: int) -> None:
    s, c = random_state(seed), (1.0, 3.0, 0.0)
    P, rest = s.P(**(MATERIAL | {"Qk": 0.0})), np.zeros(14)
    left_out = []
    for speed in (1e-2, 5e-3):
        v = speed * s.v
        J = np.asarray(ELEMENT.tangent(s.q, v, rest, s.l, P, *c)[1])
        along = difference(lambda x, v=v: residual(s.q + c[0] * x, v + c[1] * x, rest, s.l, P), rest, STEP)
        left_out.append(np.abs(J - along).max())
    np.testing.assert_allclose(left_out[0] / left_out[1], 2.0, rtol=0.05)


# rigid motion


def turn_all(q: Array, turn: Array) -> Array:
    """All vectors of an element's degrees of freedom turned, theta kept."""
    y = q.copy()
    for k in (0, 3, 7, 10):
        y[k : k + 3] = turn @ q[k : k + 3]
    return y


@pytest.mark.parametrize("seed", SEEDS)
def test_the_strain_energy_does_not_see_a_rotation_or_translation(seed: int) -> None:
    s = random_state(seed)
    turn = rotation(np.random.default_rng(100 + seed).normal(size=3) * 2)
    there = turn_all(s.q, turn)
    there[[0, 7]] += 12.0
    moved = State(there, s.v, s.a, s.l, turn @ s.pole)
    before, after = (balance(x.q, x.v, x.l, x.P(**MATERIAL)) for x in (s, moved))
    # rounding, and coordinates of 12 in differences of 1
    np.testing.assert_allclose([after[x] for x in STRAIN], [before[x] for x in STRAIN], rtol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_turning_about_the_pole_is_turning_theta(seed: int) -> None:
    # the same pole before and after: the frame turns with the rope, and theta counts from where it was
    s = random_state(seed)
    moved = turn_all(s.q, rotation(1.1 * s.pole))
    moved[[6, 13]] += 1.1
    P = s.P(**MATERIAL)
    before, after = (balance(q, s.v, s.l, P) for q in (s.q, moved))
    np.testing.assert_allclose([after[x] for x in STRAIN], [before[x] for x in STRAIN], rtol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_rigid_rotation_dissipates_nothing(seed: int) -> None:
    # about the pole, where the discretised rope can turn rigidly to rounding
    s = random_state(seed)
    v = np.zeros(14)
    for k in (0, 3, 7, 10):
        v[k : k + 3] = np.cross(s.pole, s.q[k : k + 3])
    v[[6, 13]] = 1.0
    P = s.P(Qa=5.0, Qs=0.8, Qd=2.0, EI=1.5, beta_K=0.3)
    assert balance(s.q, v, s.l, P)["damping_power"] < 1e-26  # the square of rounding
    v[13] = 2.0  # and a rotation with twisting does
    assert balance(s.q, v, s.l, P)["damping_power"] > 1e-3


# a change of the pole


def curve(x: Array) -> tuple[Array, Array, Array]:
    """r, r' (n, 3) and theta (n,) of a smooth, bent and twisted rope."""
    r = np.column_stack((np.sin(1.3 * x), x + 0.2 * x**2, 0.5 * np.cos(2 * x)))
    d = np.column_stack((1.3 * np.cos(1.3 * x), 1 + 0.4 * x, -np.sin(2 * x)))
    return r, d, 0.8 * np.sin(2 * x)


def on_new_pole(l: float) -> tuple[Array, Array]:
    """(twist, energy) of an element of length l on the curve, with the old pole and the new."""
    r, d, theta = curve(np.array([0.3, 0.3 + l]))
    poles = np.array([[1.0, 0.0, 0.0], [0.36, 0.48, 0.8]])
    t = d / np.linalg.norm(d, axis=1)[:, None]
    twist, energies = [], []
    for pole, added in zip(poles, (0.0, pole_change_angle(poles[0], poles[1], t)), strict=True):
        q = np.column_stack((r, d, theta + added)).ravel()
        s = State(q, np.zeros(14), np.zeros(14), l, pole)
        twist.append(l * float(ELEMENT.strains(q, l, s.P(**MATERIAL))[1]))
        energies.append(energy(q, s.v, l, s.P(Qd=2.0), STRAIN) / l)
    return np.array(twist), np.array(energies)


def test_a_pole_change_keeps_the_twist_to_quadrature_and_the_energy_to_second_order() -> None:
    lengths = np.array([0.4, 0.2, 0.1, 0.05])
    twist = np.array([on_new_pole(l)[0] for l in lengths])
    change = np.abs(np.diff(twist, axis=1)[:, 0])
    # three Gauss points: error l^7 per element
    np.testing.assert_allclose(np.log2(change[:-1] / change[1:]), 7.0, atol=0.7)
    # linear theta: tau is redistributed inside the element, l^2 in the energy per length
    halved = (on_new_pole(l)[1] for l in (0.02, 0.01, 0.005))
    per_length = np.abs([after - before for before, after in halved])
    np.testing.assert_allclose(np.log2(per_length[:-1] / per_length[1:]), 2.0, atol=0.3)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_pole_change_points_theta_at_the_same_material(seed: int) -> None:
    s = random_state(seed)
    new, t = random_state(seed + 50).pole, s.q[3:6] / np.linalg.norm(s.q[3:6])
    e = np.cross(s.pole, t)
    material = smallest_rotation(s.pole, t) @ e  # at theta = 0
    zero = smallest_rotation(new, t) @ smallest_rotation(s.pole, new) @ e
    expected = np.arctan2(np.cross(zero, material) @ t, zero @ material)
    # the same angle, up to whole turns, to rounding
    turns = (pole_change_angle(s.pole, new, t[None])[0] - expected) / (2 * np.pi)
    np.testing.assert_allclose(turns, round(turns), atol=1e-13)


def test_a_pole_change_is_undone_by_the_way_back() -> None:
    t = np.random.default_rng(3).normal(size=(20, 3)) + np.array([4.0, 0.0, 0.0])
    t /= np.linalg.norm(t, axis=1)[:, None]
    a, b = np.array([1.0, 0.0, 0.0]), np.array([0.6, 0.8, 0.0])
    np.testing.assert_allclose(pole_change_angle(a, b, t) + pole_change_angle(b, a, t), 0.0, atol=1e-14)


# reference frames


def smallest_rotation(pole: Array, t: Array) -> Array:
    """(3, 3): the smallest rotation from ``pole`` to ``t``."""
    axis = np.cross(pole, t)
    sine, cosine = float(np.linalg.norm(axis)), float(pole @ t)
    return rotation(axis / sine * np.arctan2(sine, cosine))


def tait_bryan(pole: Array, t: Array) -> Array:
    """(3, 3): about Z, then about the new Y, taking X to ``t``."""
    about_z = rotation(np.array([0.0, 0.0, np.arctan2(t[1], t[0])]))
    return about_z @ rotation(np.array([0.0, -np.arcsin(t[2]), 0.0]))


@pytest.mark.parametrize(
    ("rate", "frame"), [(smallest_rotation_rate, smallest_rotation), (tait_bryan_rate, tait_bryan)]
)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_frame_rate_is_how_fast_the_frame_turns_about_the_tangent(
    rate: FrameRate, frame: Callable[[Array, Array], Array], seed: int
) -> None:
    s = random_state(seed)
    d, change = s.q[3:6], np.random.default_rng(seed).normal(size=3)

    def frame_at(x: float) -> Array:
        y = d + x * change
        return frame(s.pole, y / np.linalg.norm(y))

    here = frame_at(0.0)
    np.testing.assert_allclose(here @ (s.pole if frame is smallest_rotation else [1, 0, 0]), d / np.linalg.norm(d))
    # d(frame)/dx frame^T is the cross product with the turning vector
    spin = (frame_at(STEP) - frame_at(-STEP)) / (2 * STEP) @ here.T
    turning = 0.5 * np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]])
    expected = turning @ d / np.linalg.norm(d)
    np.testing.assert_allclose(rate(s.pole, d, change), expected, rtol=1e-6, atol=1e-7)  # STEP^2 and rounding


def test_a_section_turned_with_the_rope_has_the_twist_of_the_element() -> None:
    # a material frame carried along the curve, turning at tau about the tangent, is the reference frame turned by theta
    pole, rate = np.array([0.6, 0.0, 0.8]), 0.7

    def tangent(x: float) -> Array:
        d = curve(np.array([x]))[1][0]
        return np.asarray(d / np.linalg.norm(d))

    def rotation(x: float, m: Array) -> Array:
        t, t_x = tangent(x), (tangent(x + STEP) - tangent(x - STEP)) / (2 * STEP)
        return np.cross(np.cross(t, t_x) + rate * t, m)

    e = np.array([0.0, 1.0, 0.0])  # across the pole
    carried = solve_ivp(rotation, (0.0, 1.0), smallest_rotation(pole, tangent(0.0)) @ e, rtol=1e-10, atol=1e-12).y[
        :, -1
    ]
    zero, t = smallest_rotation(pole, tangent(1.0)) @ e, tangent(1.0)
    theta = np.arctan2(np.cross(zero, carried) @ t, zero @ carried)
    x = np.linspace(0.0, 1.0, 2001)
    d = curve(x)[1].T
    frame_twist = np.trapezoid(smallest_rotation_rate(pole, d, np.gradient(d, x, axis=1)), x)
    # integrated by second-order differences and the trapezoidal rule: 1e-6
    np.testing.assert_allclose(theta + frame_twist, rate, atol=1e-5)


def test_the_tait_bryan_frame_fails_where_the_tangent_is_out_of_plane_and_the_default_does_not() -> None:
    source = element_functions(frame_rate=tait_bryan_rate)
    torsion = {}
    for name, functions in (("source", source), ("default", ELEMENT)):
        torsion[name] = []
        for tilt in (0.08, 0.04, 0.02):
            # the rope passes Z at a distance ``tilt``, bending across
            q = np.array([0.0, -0.05, 0, tilt, -0.5, 1, 0, tilt, -0.05, 1, tilt, 0.5, 1, 0])
            P = np.array([0, 0, 0, 0, 0, 1.0, 0, 0, 0, 1.0, 0, 0])
            parts = np.asarray(functions.balance(q, np.zeros(14), 1.0, P)).ravel()
            torsion[name].append(parts[BALANCE.index("torsion")])
    growth = np.array(torsion["source"][1:]) / torsion["source"][:-1]
    np.testing.assert_allclose(growth, 4.0, rtol=0.1)  # twist ~ 1/tilt, energy its square
    # the default changes by the order of the change of shape
    np.testing.assert_allclose(torsion["default"], torsion["default"][-1], rtol=0.15)
    # and exactly there it has no value at all
    q = np.array([0.0, 0, 0, 0, -0.5, 1, 0, 0, 0, 1, 0, 0.5, 1, 0])
    rest = np.zeros(14)
    assert not np.all(np.isfinite(np.asarray(source.residual(q, rest, rest, 1.0, P))))
    assert np.all(np.isfinite(residual(q, rest, rest, 1.0, P)))


# order of convergence

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


def cantilever_tip(elements: int, load: Array, torque: float) -> Array:
    s = np.linspace(0.0, 1.0, elements + 1)
    chain = Chain.unloaded(straight(s))
    chain.held[0, [0, 1, 2, 4, 5, 6]] = True
    chain.loads[-1, : load.size], chain.loads[-1, 6] = load, torque
    P = np.array([CANTILEVER.get(name, 0.0) for name in PARAMETERS[:9]] + [1.0, 0.0, 0.0])
    P[0], P[7] = 1.0, 0.1  # inertia for pseudo-transient continuation only
    return find_equilibrium(portable_system(np.diff(s), P, chain), chain.values).q[-1, :3]


def test_displacements_converge_with_the_fourth_power_of_the_element_length() -> None:
    exact = elastica_tip()
    assert abs(exact[1]) > 0.5  # truly large: more than half the length
    errors = [np.linalg.norm(cantilever_tip(n, LOAD, 0.0)[:2] - exact) for n in (4, 8, 16)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    # cubic displacements: l^4; the last pair is in the asymptotic range
    np.testing.assert_allclose(orders[-1], 4.0, atol=0.2)


def test_with_torsion_in_space_the_linear_angle_leaves_second_order() -> None:
    # theta is linear: tau keeps a part ~ l inside the element, where the frame's own twist varies
    tips = [cantilever_tip(n, np.array([0.2, -2.0, 1.0]), 0.4) for n in (8, 16, 32, 64)]
    steps = np.linalg.norm(np.diff(tips, axis=0), axis=1)
    orders = np.log2(steps[:-1] / steps[1:])
    np.testing.assert_allclose(orders[-1], 2.0, atol=0.2)
    # and little of it: 1e-6 of the length with 32 elements
    assert steps[-1] < 1e-6
