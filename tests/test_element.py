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
from rope_model.physics.frame import FrameRate, smallest_rotation_rate
from rope_model.simulation.statics import find_equilibrium

Array = NDArray[np.float64]

ELEMENT = element_functions()
STRAIN = ("axial", "coupling", "torsion", "bending")
SEEDS = range(6)
MATERIAL = {"rho": 1.3, "g": 9.8, "Qa": 5.0, "Qs": 0.8, "Qk": 0.3, "Qd": 2.0, "EI": 1.5, "rhoJ": 0.4}
MATERIAL |= {"beta_K": 0.3, "root_a": 1.3, "root_b": 0.7, "Qe": 0.6}
#: a central difference with this step errs by its square, and by rounding over it: both below 1e-9
STEP = 1e-5


@dataclass(frozen=True)
class State:
    """An element somewhere, in some motion; the frame is counted from ``reference`` (14,)."""

    q: Array
    v: Array
    a: Array
    l: float
    reference: Array

    @property
    def F(self) -> Array:
        """What the frame is counted from, as the element takes it."""
        return np.asarray(ELEMENT.reference(self.reference, self.l)).ravel()

    def P(self, **material: float) -> Array:
        """The element's parameters; what is not given is zero."""
        return np.array([material.get(name, 0.0) for name in PARAMETERS])


def random_state(seed: int) -> State:
    """A bent, twisted, stretched element turned anywhere; strains are of order 0.1 to 1."""
    rng = np.random.default_rng(seed)
    l, turn = rng.uniform(0.5, 2.0), rotation(rng.normal(size=3))
    slopes = (np.array([1.2, 0.0, 0.0]) + 0.25 * rng.normal(size=(2, 3))) @ turn.T
    left = rng.normal(size=3)
    right = left + l * (slopes.mean(axis=0) + 0.1 * rng.normal(size=3))
    q = np.concatenate((left, slopes[0], rng.normal(size=1), right, slopes[1], rng.normal(size=1)))
    # another shape, with tangents that are not opposite
    reference = q + 0.3 * rng.normal(size=14)
    return State(q, rng.normal(size=14), rng.normal(size=14), l, reference)


def residual(q: Array, v: Array, a: Array, l: float, F: Array, P: Array) -> Array:
    return np.asarray(ELEMENT.residual(q, v, a, l, F, P)).ravel()


def balance(q: Array, v: Array, l: float, F: Array, P: Array) -> dict[str, float]:
    return dict(zip(BALANCE, np.asarray(ELEMENT.balance(q, v, l, F, P)).ravel().tolist(), strict=True))


def energy(q: Array, v: Array, l: float, F: Array, P: Array, names: tuple[str, ...]) -> float:
    parts = balance(q, v, l, F, P)
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


def direction(d: Array, change: Array) -> tuple[Array, Array]:
    """Unit vectors of ``d`` (3, n) and their rates."""
    size = np.linalg.norm(d, axis=0)
    t = d / size
    return t, (change - t * np.sum(t * change, axis=0)) / size


@pytest.mark.parametrize("seed", SEEDS)
def test_the_balance_holds_the_integrals_of_the_theory(seed: int) -> None:
    s, m = random_state(seed), MATERIAL
    parts = balance(s.q, s.v, s.l, s.F, s.P(**m))
    # polynomials of degree six: exact with four points; strains by the element's three
    for points, names in ((4, ("kinetic", "gravity")), (3, (*STRAIN, "spin"))):
        xi, weights = np.polynomial.legendre.leggauss(points)
        at = 0.5 + 0.5 * xi
        r, d, c = interpolate(s.q, at, s.l)
        r_t, d_t, _ = interpolate(s.v, at, s.l)
        theta_x, theta_t = (s.q[13] - s.q[6]) / s.l, s.v[6] + at * (s.v[13] - s.v[6])
        _, d_p, c_p = interpolate(s.reference, at, s.l)
        stretch = np.linalg.norm(d, axis=0)
        (t, t_x), (_, t_t), (p, p_x) = (direction(*pair) for pair in ((d, c), (d, d_t), (d_p, c_p)))
        e, k = stretch - 1, np.linalg.norm(np.cross(d, c, axis=0), axis=0) / stretch**2
        twist, spin = (
            -np.sum(np.cross(p, t, axis=0) * change, axis=0) / (1 + np.sum(p * t, axis=0))
            for change in (p_x + t_x, t_t)
        )
        # one torsional strain for the element: its mean by three points, whatever points it is summed with
        tau, w = theta_x + 0.5 * float(weights @ twist), theta_t + spin
        density = {
            "axial": 0.5 * m["Qa"] * e**2,
            "coupling": m["Qs"] * e * tau,
            "torsion": 0.5 * (m["Qd"] + m["Qe"] * e) * tau**2,
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
    gradient = difference(lambda q: energy(q, rest, s.l, s.F, P, STRAIN), s.q)
    # truncation STEP^2 times third derivatives of order 10 to 100
    np.testing.assert_allclose(residual(s.q, rest, rest, s.l, s.F, P), gradient, rtol=0, atol=1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_weight_is_the_gradient_of_the_potential_energy(seed: int) -> None:
    s = random_state(seed)
    P, rest = s.P(rho=1.3, g=9.8), np.zeros(14)
    gradient = difference(lambda q: energy(q, rest, s.l, s.F, P, ("gravity",)), s.q)
    # linear: only rounding
    np.testing.assert_allclose(residual(s.q, rest, rest, s.l, s.F, P), gradient, rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_inertia_force_is_lagranges_derivative_of_the_kinetic_energy(seed: int) -> None:
    s = random_state(seed)
    P = s.P(rho=1.3, rhoJ=0.4)

    def kinetic(q: Array, v: Array) -> float:
        return energy(q, v, s.l, s.F, P, ("kinetic", "spin"))

    def momentum(t: float) -> Array:
        q, v = s.q + t * s.v + 0.5 * t * t * s.a, s.v + t * s.a
        # the energy is quadratic in v: the difference is exact for any step
        return difference(lambda x: kinetic(q, x), v, step=1.0)

    change = (momentum(1e-4) - momentum(-1e-4)) / 2e-4
    gradient = difference(lambda q: kinetic(q, s.v), s.q)
    # truncation 1e-8 times third time derivatives of order 10 to 100
    np.testing.assert_allclose(residual(s.q, s.v, s.a, s.l, s.F, P), change - gradient, rtol=0, atol=1e-5)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_momentum_is_the_derivative_of_the_kinetic_energy_along_rigid_motions(seed: int) -> None:
    s = random_state(seed)
    P = s.P(**MATERIAL | {"rhoJ": 0.0})
    nodes = s.q.reshape(2, NODE_DOF)
    found = np.asarray(ELEMENT.momentum(s.q, s.v, s.l, P)).ravel()

    def kinetic(v: Array) -> float:
        return float(np.asarray(ELEMENT.balance(s.q, v, s.l, s.F, P)).ravel()[BALANCE.index("kinetic")])

    for k, e in enumerate(np.eye(3)):
        shift, turn = np.zeros((2, NODE_DOF)), np.zeros((2, NODE_DOF))
        shift[:, :3], turn[:, :3], turn[:, 3:6] = e, np.cross(e, nodes[:, :3]), np.cross(e, nodes[:, 3:6])
        for motion, value in ((shift, found[k]), (turn, found[3 + k])):
            # the kinetic energy is quadratic in v: the central difference has rounding only
            difference = (kinetic(s.v + motion.ravel()) - kinetic(s.v - motion.ravel())) / 2
            assert value == pytest.approx(difference, rel=1e-9, abs=1e-9)
    # the mass, where it is: the weight's energy is g S_y
    assert found[7] * P[1] == pytest.approx(float(ELEMENT.balance(s.q, s.v, s.l, s.F, P)[BALANCE.index("gravity")]))


def test_a_straight_element_that_spins_has_the_momentum_of_its_polar_moment() -> None:
    l, d, v = 1.7, np.array([0.0, 1.0, 0.0]), np.zeros(2 * NODE_DOF)
    v[[6, 13]] = 0.7
    q = np.concatenate((np.zeros(3), d, [0.0], l * d, d, [0.0]))
    P = np.array([{"rhoJ": 0.4}.get(name, 0.0) for name in PARAMETERS])
    momentum = np.asarray(ELEMENT.momentum(q, v, l, P)).ravel()
    np.testing.assert_allclose(momentum, [0, 0, 0, 0, 0.4 * 0.7 * l, 0, 0, 0, 0], rtol=0, atol=1e-15)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_damping_force_takes_the_damping_power_out_of_the_motion(seed: int) -> None:
    s = random_state(seed)
    rest = np.zeros(14)
    P = s.P(Qa=5.0, Qs=0.8, Qd=2.0, EI=1.5, beta_K=0.3, root_a=1.3, root_b=0.7)
    force = residual(s.q, s.v, rest, s.l, s.F, P) - residual(s.q, rest, rest, s.l, s.F, P)
    power = balance(s.q, s.v, s.l, s.F, P)["damping_power"]
    assert power > 0
    np.testing.assert_allclose(force @ s.v, power, rtol=1e-12)  # an identity


@pytest.mark.parametrize("name", ["beta_K", "root_a", "root_b"])
def test_each_damping_acts_on_its_own_strain(name: str) -> None:
    """Stretched, twisted and bent at a rate of 1: what grows fourfold when the number of its strain is doubled."""
    l, damped = 1.7, {"beta_K": 0.3, "root_a": 1.3, "root_b": 0.7}
    q = np.array([0.0, 0, 0, 1, 0, 0, 0, l, 0, 0, 1, 0, 0, 0])
    stretched, twisted, bent = (np.zeros(14) for _ in range(3))
    stretched[[3, 7, 10]] = 1.0, l, 1.0
    twisted[13] = 1.0
    bent[[4, 11]] = -1.0, 1.0

    def powers(numbers: dict[str, float]) -> list[float]:
        s = State(q, stretched, stretched, l, q)
        P = s.P(Qa=5.0, Qd=2.0, EI=1.5, **numbers)
        return [balance(q, v, l, s.F, P)["damping_power"] for v in (stretched, twisted, bent)]

    doubled = np.array(powers(damped | {name: 2 * damped[name]})) / powers(damped)
    expected = {"beta_K": [2, 2, 2], "root_a": [1, 4, 1], "root_b": [1, 1, 4]}[name]
    np.testing.assert_allclose(doubled, expected, rtol=1e-12)


def test_the_damping_power_is_never_negative() -> None:
    rng = np.random.default_rng(7)
    powers = []
    for seed in range(40):
        s = random_state(seed)
        # coupling up to its limit sqrt(Qa Qd), where one combination of the rates costs nothing
        Qs = np.sqrt(5.0 * 2.0) * rng.uniform(-1, 1)
        P = s.P(Qa=5.0, Qs=Qs, Qd=2.0, EI=1.5, beta_K=0.3, root_a=1.3, root_b=0.7)
        powers.append(balance(s.q, rng.normal(size=14), s.l, s.F, P)["damping_power"])
    assert min(powers) >= 0


@pytest.mark.parametrize("seed", SEEDS)
def test_the_force_without_energy_takes_up_the_power_the_balance_says(seed: int) -> None:
    s = random_state(seed)
    P, rest = s.P(Qk=0.3), np.zeros(14)
    power = residual(s.q, rest, rest, s.l, s.F, P) @ s.v
    np.testing.assert_allclose(
        power, balance(s.q, s.v, s.l, s.F, P)["nonconservative_power"], rtol=1e-12
    )  # an identity


def test_a_closed_cycle_of_strain_does_the_work_of_qb_minus_qc() -> None:
    # straight, so that e and tau are those of the degrees of freedom: an ellipse in the strain plane
    l, Qk, e_0, tau_0 = 1.7, 0.3, 0.1, 0.4
    s = random_state(0)
    straight_x = np.array([0.0, 0, 0, 1, 0, 0, 0, l, 0, 0, 1, 0, 0, 0])
    F, P = State(s.q, s.v, s.a, l, straight_x).F, s.P(Qa=5.0, Qs=0.8, Qk=Qk, Qd=2.0)
    work, energy_balance, phases = 0.0, 0.0, np.arange(64) * 2 * np.pi / 64
    for phi in phases:
        q, v = np.zeros(14), np.zeros(14)
        q[[3, 10]], q[7], q[13] = 1 + e_0 * np.cos(phi), l * (1 + e_0 * np.cos(phi)), l * tau_0 * np.sin(phi)
        v[[3, 10]], v[7], v[13] = -e_0 * np.sin(phi), -l * e_0 * np.sin(phi), l * tau_0 * np.cos(phi)
        work += residual(q, v, np.zeros(14), l, F, P) @ v * 2 * np.pi / 64
        energy_balance += balance(q, v, l, F, P)["nonconservative_power"] * 2 * np.pi / 64
    # twice Qk times the enclosed area, negative for this sense; the trapezoidal rule is exact on a circle
    np.testing.assert_allclose([work, energy_balance], -2 * np.pi * Qk * e_0 * tau_0 * l, rtol=1e-12)


def test_costellos_law_is_the_gradient_of_its_energy_plus_the_remainder() -> None:
    Qa, Qs, Qk, Qd, Qe, e, tau = 5.0, 0.8, 0.3, 2.0, 0.6, 0.12, -0.4

    def U(x: Array) -> float:
        return float(costello.strain_energy(Qa, Qs, Qd, x[0], x[1]) + costello.stiffening_energy(Qe, x[0], x[1]))

    dU = difference(U, np.array([e, tau]))
    law = [costello.tension(Qa, Qs, Qk, Qe, e, tau), costello.torque(Qs, Qk, Qd, Qe, e, tau)]
    np.testing.assert_allclose(law, dU + Qk * np.array([tau, -e]), rtol=1e-9)  # cubic: rounding only
    # Qb = 1.1, Qc = 0.5
    np.testing.assert_allclose(law, [Qa * e + 1.1 * tau + 0.5 * Qe * tau**2, 0.5 * e + (Qd + Qe * e) * tau], rtol=1e-14)


def test_a_stretched_and_twisted_element_has_the_law_s_tension_and_torque() -> None:
    l, e, tau, numbers = 1.7, 0.12, -0.4, {"Qa": 5.0, "Qs": 0.8, "Qk": 0.3, "Qd": 2.0, "Qe": 0.6}
    q = np.zeros(14)
    q[[3, 7, 10]] = 1 + e, l * (1 + e), 1 + e
    s, q[13] = State(q, np.zeros(14), np.zeros(14), l, np.array([0.0, 0, 0, 1, 0, 0, 0, l, 0, 0, 1, 0, 0, 0])), tau * l
    R = residual(q, np.zeros(14), np.zeros(14), l, s.F, s.P(**numbers))
    Qa, Qs, Qk, Qd, Qe = numbers.values()
    assert R[7] == pytest.approx(costello.tension(Qa, Qs, Qk, Qe, e, tau), rel=1e-12)
    assert R[13] == pytest.approx(costello.torque(Qs, Qk, Qd, Qe, e, tau), rel=1e-12)


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
    F = np.asarray(element.reference(s.reference[kept], s.l)).ravel()

    def force(q: Array, v: Array, a: Array) -> Array:
        return np.asarray(element.residual(q, v, a, s.l, F, P)).ravel()

    R, J = (np.asarray(x) for x in element.tangent(q, rest, rest, s.l, F, P, *c))
    along = difference(lambda x: force(q + c[0] * x, c[1] * x, c[2] * x), rest, STEP / 8)
    # truncation of second order: up to 1e-6 where a planar element is nearly compressed to a point
    np.testing.assert_allclose(J, along, rtol=0, atol=1e-9 * np.abs(J).max() + 1e-6)
    np.testing.assert_allclose(R.ravel(), force(q, rest, rest), rtol=1e-12, atol=1e-12)
    v, a = s.v[kept], s.a[kept]
    np.testing.assert_allclose(
        element.tangent(q, v, a, s.l, F, P, *c)[0], force(q, v, a)[:, None], rtol=1e-12, atol=1e-12
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_what_the_tangent_leaves_out_in_motion_is_of_the_first_order_in_the_speed(seed: int) -> None:
    s, c = random_state(seed), (1.0, 3.0, 0.0)
    P, rest = s.P(**(MATERIAL | {"Qk": 0.0})), np.zeros(14)
    left_out = []
    for speed in (1e-2, 5e-3):
        v = speed * s.v
        J = np.asarray(ELEMENT.tangent(s.q, v, rest, s.l, s.F, P, *c)[1])
        along = difference(lambda x, v=v: residual(s.q + c[0] * x, v + c[1] * x, rest, s.l, s.F, P), rest, STEP)
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
    moved = State(there, s.v, s.a, s.l, turn_all(s.reference, turn))
    before, after = (balance(x.q, x.v, x.l, x.F, x.P(**MATERIAL)) for x in (s, moved))
    # rounding, and coordinates of 12 in differences of 1
    np.testing.assert_allclose([after[x] for x in STRAIN], [before[x] for x in STRAIN], rtol=1e-12)


# the frame's reference


def curve(x: Array) -> tuple[Array, Array, Array]:
    """r, r' (n, 3) and theta (n,) of a smooth, bent and twisted rope."""
    r = np.column_stack((np.sin(1.3 * x), x + 0.2 * x**2, 0.5 * np.cos(2 * x)))
    d = np.column_stack((1.3 * np.cos(1.3 * x), 1 + 0.4 * x, -np.sin(2 * x)))
    return r, d, 0.8 * np.sin(2 * x)


def on_curve(l: float) -> Array:
    """(14,): an element of length l on the curve."""
    r, d, theta = curve(np.array([0.3, 0.3 + l]))
    return np.column_stack((r, d, theta)).ravel()


@pytest.mark.parametrize("seed", SEEDS)
def test_what_becomes_the_reference_keeps_its_energies_and_its_spin(seed: int) -> None:
    s, P = random_state(seed), random_state(seed).P(**MATERIAL)
    q, v = s.q.copy(), s.v.copy()
    gained = np.asarray(ELEMENT.transport(q, v, s.a, s.l, s.F)).ravel()
    q[13] += gained[0]
    own = State(q, v, s.a, s.l, q)
    before, after = energy(s.q, s.v, s.l, s.F, P, STRAIN), energy(q, v, s.l, own.F, P, STRAIN)
    np.testing.assert_allclose(after, before, rtol=1e-12)
    # the angle's rate at the right node and its own rate: those of the spin there
    d, d_t, d_tt = (x[10:13] for x in (s.q, s.v, s.a))
    p = s.reference[10:13] / np.linalg.norm(s.reference[10:13])

    def spin(t: float) -> float:
        at, rate = d + t * d_t + 0.5 * t * t * d_tt, d_t + t * d_tt
        return float(smallest_rotation_rate(p, np.zeros(3), at, rate))

    expected = [spin(0.0), (spin(STEP) - spin(-STEP)) / (2 * STEP)]
    np.testing.assert_allclose(gained[1:], expected, rtol=1e-7, atol=1e-7)


def test_the_way_to_a_shape_does_not_matter_but_for_the_quadrature() -> None:
    rng, error, rest = np.random.default_rng(2), [], np.zeros(14)
    maps = np.eye(3) + 0.4 * rng.normal(size=(3, 3, 3))
    for l in (0.2, 0.1, 0.05):
        shapes = [turn_all(on_curve(l), A) for A in maps]
        frames = [ELEMENT.reference(x, l) for x in shapes]
        turn = sum(float(ELEMENT.transport(shapes[k], rest, rest, l, frames[k - 1])[0]) for k in range(3))
        # the frame at a node has turned by the area that the node's tangents enclose on the sphere
        first, last = (area(*(x[k : k + 3] for x in shapes)) for k in (3, 10))
        error.append(abs(turn - (last - first)))
    # three Gauss points: error l^7 per element, or less where its factor changes sign
    assert np.min(np.log2(np.array(error[:-1]) / error[1:])) > 6.5


def area(*corners: Array) -> float:
    """Signed area of the spherical triangle of these directions."""
    a, b, c = (x / np.linalg.norm(x) for x in corners)
    return 2.0 * float(np.arctan2(a @ np.cross(b, c), 1 + a @ b + b @ c + c @ a))


def test_a_rigid_rotation_dissipates_nothing_but_for_the_interpolation() -> None:
    # the angle is linear between the nodes, so is its rate: the spin of a section errs by l^2, the power by its square
    w, power = np.array([0.3, -1.1, 0.7]), []
    for l in (0.1, 0.05, 0.025):
        q, v = on_curve(l), np.zeros(14)
        for k in (0, 3, 7, 10):
            v[k : k + 3] = np.cross(w, q[k : k + 3])
        v[[6, 13]] = [w @ q[k : k + 3] / np.linalg.norm(q[k : k + 3]) for k in (3, 10)]
        s = State(q, v, v, l, q)
        P = s.P(Qa=5.0, Qs=0.8, Qd=2.0, EI=1.5, beta_K=0.3, root_a=1.3, root_b=0.7)
        power.append(balance(q, v, l, s.F, P)["damping_power"] / l)
        v[13] += l  # and a rotation with twisting does
        assert balance(q, v, l, s.F, P)["damping_power"] / l > 1e-3
    np.testing.assert_allclose(np.log2(np.array(power[:-1]) / power[1:]), 4.0, atol=0.3)


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
    s, rng = random_state(seed), np.random.default_rng(seed)
    (d, pole), (change, pole_change) = (s.q[3:6], s.reference[3:6]), rng.normal(size=(2, 3))
    if frame is tait_bryan:
        pole, pole_change = np.array([1.0, 0.0, 0.0]), np.zeros(3)

    def unit(x: Array) -> Array:
        return np.asarray(x / np.linalg.norm(x))

    def frame_at(x: float) -> Array:
        p = unit(pole + x * pole_change)
        return frame(p, unit(d + x * change)) @ transport(unit(pole), p)

    here = frame_at(0.0)
    np.testing.assert_allclose(here @ unit(pole), unit(d), atol=1e-15)
    # d(frame)/dx frame^T is the cross product with the turning vector
    spin = (frame_at(STEP) - frame_at(-STEP)) / (2 * STEP) @ here.T
    turning = 0.5 * np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]])
    turn = np.cross(pole, pole_change) / (pole @ pole)
    np.testing.assert_allclose(rate(unit(pole), turn, d, change), turning @ unit(d), rtol=1e-6, atol=1e-7)


def transport(old: Array, new: Array) -> Array:
    """(3, 3): what takes ``old`` to its neighbour ``new`` without turning about it."""
    return np.eye(3) if np.array_equal(old, new) else smallest_rotation(old, new)


def test_a_section_turned_with_the_rope_has_the_twist_of_the_element() -> None:
    # carried along the curve, turning at tau about the tangent: theta' = tau where the curve is the reference
    pole, rate = np.array([0.6, 0.0, 0.8]), 0.7

    def tangent(x: float) -> Array:
        d = curve(np.array([x]))[1][0]
        return np.asarray(d / np.linalg.norm(d))

    def rotation(x: float, m: Array) -> Array:
        t, t_x = tangent(x), (tangent(x + STEP) - tangent(x - STEP)) / (2 * STEP)
        return np.cross(np.cross(t, t_x) + rate * t, m)

    e = np.array([0.0, 1.0, 0.0])  # across the pole
    section = solve_ivp(rotation, (0.0, 1.0), smallest_rotation(pole, tangent(0.0)) @ e, rtol=1e-10, atol=1e-12).y[
        :, -1
    ]
    # the same from a straight reference along the pole, to the curve's own
    zero, t = smallest_rotation(pole, tangent(1.0)) @ e, tangent(1.0)
    theta = np.arctan2(np.cross(zero, section) @ t, zero @ section)
    straight_rope = np.tile(np.concatenate((np.zeros(3), pole, [0.0])), 2)
    s, gained, rest = np.linspace(0.0, 1.0, 21), 0.0, np.zeros(14)
    for i in range(20):
        r, d, _ = curve(s[i : i + 2])
        straight_rope[7:10] = pole * (s[i + 1] - s[i])
        F = ELEMENT.reference(straight_rope, s[i + 1] - s[i])
        q = np.column_stack((r, d, np.zeros(2))).ravel()
        gained += float(ELEMENT.transport(q, rest, rest, s[i + 1] - s[i], F)[0])
    # cubics of 1/20 of the curve
    np.testing.assert_allclose(theta + gained, rate, atol=1e-5)


def test_the_tait_bryan_frame_fails_where_the_tangent_is_out_of_plane_and_the_default_does_not() -> None:
    source = element_functions(frame_rate=tait_bryan_rate)
    torsion = {}
    for name, functions in (("source", source), ("default", ELEMENT)):
        torsion[name] = []
        for tilt in (0.08, 0.04, 0.02):
            # the rope passes Z at a distance ``tilt``, bending across
            q = np.array([0.0, -0.05, 0, tilt, -0.5, 1, 0, tilt, -0.05, 1, tilt, 0.5, 1, 0])
            P, along_x = (
                np.array([float(name == "Qd") for name in PARAMETERS]),
                np.array([0.0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0]),
            )
            F = ELEMENT.reference(along_x, 1.0)
            parts = np.asarray(functions.balance(q, np.zeros(14), 1.0, F, P)).ravel()
            torsion[name].append(parts[BALANCE.index("torsion")])
    growth = np.array(torsion["source"][1:]) / torsion["source"][:-1]
    np.testing.assert_allclose(growth, 4.0, rtol=0.1)  # twist ~ 1/tilt, energy its square
    # the default changes by the order of the change of shape
    np.testing.assert_allclose(torsion["default"], torsion["default"][-1], rtol=0.15)
    # and exactly there it has no value at all
    q = np.array([0.0, 0, 0, 0, -0.5, 1, 0, 0, 0, 1, 0, 0.5, 1, 0])
    rest = np.zeros(14)
    assert not np.all(np.isfinite(np.asarray(source.residual(q, rest, rest, 1.0, F, P))))
    assert np.all(np.isfinite(residual(q, rest, rest, 1.0, np.asarray(F), P)))


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
    errors = [np.linalg.norm(cantilever_tip(n, LOAD, 0.0)[:2] - exact) for n in (4, 8, 16)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    # cubic displacements: l^4; the last pair is in the asymptotic range
    np.testing.assert_allclose(orders[-1], 4.0, atol=0.2)


@pytest.mark.parametrize(("coupling", "order"), [(0.0, 4.0), (2.0, 2.0)])
def test_with_torsion_in_space_they_do_so_but_for_the_coupling(coupling: float, order: float) -> None:
    # a uniform torque without coupling means a uniform torsional strain: one for the element is no approximation.  With
    # coupling the strain follows the tension
    tips = [cantilever_tip(n, np.array([0.2, -2.0, 1.0]), 0.4, coupling) for n in (8, 16, 32, 64)]
    steps = np.linalg.norm(np.diff(tips, axis=0), axis=1)
    orders = np.log2(steps[:-1] / steps[1:])
    np.testing.assert_allclose(orders[-1], order, atol=0.2)
