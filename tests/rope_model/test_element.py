"""Every force against its energy, every tangent against its force."""

from dataclasses import replace

import numpy as np
import pytest
from element_states import (
    ELEMENT,
    MATERIAL,
    STEP,
    STRAIN,
    State,
    balance,
    energy,
    residual,
    seeds,
    some_state,
    turned,
)
from numpy.polynomial.polynomial import polyder, polyval
from shared import Array, difference, rotation

from rope_model.physics import costello
from rope_model.physics.element import BALANCE, ELEMENT_DOF, element_functions
from rope_model.physics.node import NODE_DOF


def interpolate(x: Array, xi: Array, l: float) -> tuple[Array, Array, Array]:
    """r, r', r'' (3, n) at xi of an element's degrees of freedom ``x`` (14,)."""
    ends = np.array([x[0:3], l * x[3:6], x[7:10], l * x[10:13]])
    # of each polynomial a column, its coefficients from the constant on
    hermite = np.array([[1.0, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]]).T
    r, d, c = (ends.T @ polyval(xi, polyder(hermite, k)) / l**k for k in range(3))
    return r, d, c


def direction(d: Array, change: Array) -> tuple[Array, Array]:
    """Unit vectors of ``d`` (3, n) and their rates."""
    size = np.linalg.norm(d, axis=0)
    t = d / size
    return t, (change - t * np.sum(t * change, axis=0)) / size


@seeds
def test_the_balance_holds_the_integrals_of_the_theory(seed: int) -> None:
    s = some_state(seed)
    m = MATERIAL
    parts = balance(s.q, s.v, s.l, s.F, s.P(**m))
    # polynomials of degree six: exact with four points; strains by the element's three
    for points, names in ((4, ("kinetic", "gravity")), (3, (*STRAIN, "spin"))):
        xi, weights = np.polynomial.legendre.leggauss(points)
        at = 0.5 + 0.5 * xi
        r, d, c = interpolate(s.q, at, s.l)
        r_t, d_t, _ = interpolate(s.v, at, s.l)
        theta_x = (s.q[13] - s.q[6]) / s.l
        theta_t = s.v[6] + at * (s.v[13] - s.v[6])
        _, d_p, c_p = interpolate(s.reference, at, s.l)
        stretch = np.linalg.norm(d, axis=0)
        (t, t_x), (_, t_t), (p, p_x) = (direction(*pair) for pair in ((d, c), (d, d_t), (d_p, c_p)))
        e = stretch - 1
        mean = 0.5 * float(weights @ e)
        left, right = (float(np.linalg.norm(s.q[i : i + 3])) - 1 for i in (3, 10))
        assumed = left + at * (right - left) + (6 * mean - 3 * (left + right)) * at * (1 - at)
        k = np.linalg.norm(np.cross(d, c, axis=0), axis=0) / stretch**2
        twist, spin = (
            -np.sum(np.cross(p, t, axis=0) * change, axis=0) / (1 + np.sum(p * t, axis=0))
            for change in (p_x + t_x, t_t)
        )
        # one torsional strain for the element: its mean by three points, whatever points it is
        # summed with
        tau = theta_x + 0.5 * float(weights @ twist)
        w = theta_t + spin
        slope_rate = s.v[13] - s.v[6]
        density = {
            "axial": 0.5 * m["Qa"] * assumed**2,
            "coupling": m["Qs"] * e * tau,
            "torsion": 0.5 * (m["Qd"] + m["Qe"] * e) * tau**2,
            "bending": 0.5 * m["EI"] * k**2,
            "kinetic": 0.5 * m["rho"] * np.sum(r_t**2, axis=0),
            "spin": 0.5 * m["rhoJ"] * w**2 + 0.5 * m["rhoJ_x"] * slope_rate**2,
            "gravity": m["rho"] * m["g"] * r[1],
        }
        expected = [0.5 * s.l * float(weights @ density[name]) for name in names]
        np.testing.assert_allclose(
            [parts[name] for name in names], expected, rtol=1e-11
        )  # rounding


@seeds
def test_elastic_force_and_weight_are_gradients_of_their_energies(seed: int) -> None:
    s = some_state(seed)
    rest = np.zeros(14)
    for names, P in (
        (STRAIN, s.P(Qa=5.0, Qs=0.8, Qd=2.0, Qe=0.6, EI=1.5)),
        (("gravity",), s.P(rho=1.3, g=9.8)),
    ):
        gradient = difference(lambda q, P=P, names=names: energy(q, rest, s.l, s.F, P, names), s.q)
        # truncation STEP^2 times third derivatives of order 10 to 100
        np.testing.assert_allclose(
            residual(s.q, rest, rest, s.l, s.F, P), gradient, rtol=0, atol=1e-7
        )


@seeds
def test_the_inertia_force_is_lagranges_derivative_of_the_kinetic_energy(seed: int) -> None:
    s = some_state(seed)
    P = s.P(rho=1.3, rhoJ=0.4, rhoJ_x=0.2)

    def kinetic(q: Array, v: Array) -> float:
        return energy(q, v, s.l, s.F, P, ("kinetic", "spin"))

    def momentum(t: float) -> Array:
        q = s.q + t * s.v + 0.5 * t * t * s.a
        v = s.v + t * s.a
        # the energy is quadratic in v: the difference is exact for any step
        return difference(lambda x: kinetic(q, x), v, step=1.0)

    change = (momentum(1e-4) - momentum(-1e-4)) / 2e-4
    gradient = difference(lambda q: kinetic(q, s.v), s.q)
    # truncation 1e-8 times third time derivatives of order 10 to 100
    np.testing.assert_allclose(
        residual(s.q, s.v, s.a, s.l, s.F, P), change - gradient, rtol=0, atol=1e-5
    )


@seeds
def test_the_momentum_is_the_derivative_of_the_kinetic_energy_along_rigid_motions(
    seed: int,
) -> None:
    given = some_state(seed)
    s = replace(given, reference=given.q)  # there theta_t is the spin
    P = s.P(**MATERIAL)
    nodes = s.q.reshape(2, NODE_DOF)
    found = np.asarray(ELEMENT.momentum(s.q, s.v, s.l, P)).ravel()

    def kinetic(v: Array) -> float:
        return energy(s.q, v, s.l, s.F, P, ("kinetic", "spin"))

    for k, e in enumerate(np.eye(3)):
        shift = np.zeros((2, NODE_DOF))
        turn = np.zeros((2, NODE_DOF))
        shift[:, :3] = e
        turn[:, :3] = np.cross(e, nodes[:, :3])
        turn[:, 3:6] = np.cross(e, nodes[:, 3:6])
        turn[:, 6] = nodes[:, 3:6] @ e / np.linalg.norm(nodes[:, 3:6], axis=1)
        for motion, value in ((shift, found[k]), (turn, found[3 + k])):
            # the kinetic energy is quadratic in v: the central difference has rounding only
            difference = (kinetic(s.v + motion.ravel()) - kinetic(s.v - motion.ravel())) / 2
            assert value == pytest.approx(difference, rel=1e-9, abs=1e-9)
    # the mass, where it is: the weight's energy is g S_y
    assert found[7] * P[1] == pytest.approx(
        float(ELEMENT.balance(s.q, s.v, s.l, s.F, P)[BALANCE.index("gravity")])
    )


@seeds
def test_the_damping_force_takes_the_damping_power_out_of_the_motion(seed: int) -> None:
    s = some_state(seed)
    rest = np.zeros(14)
    P = s.P(Qa=5.0, Qs=0.8, Qd=2.0, EI=1.5, beta_K=0.3, root_a=1.3, root_b=0.7)
    force = residual(s.q, s.v, rest, s.l, s.F, P) - residual(s.q, rest, rest, s.l, s.F, P)
    power = balance(s.q, s.v, s.l, s.F, P)["damping_power"]
    assert power > 0
    np.testing.assert_allclose(force @ s.v, power, rtol=1e-12)  # an identity


@pytest.mark.parametrize("name", ["beta_K", "root_a", "root_b"])
def test_each_damping_acts_on_its_own_strain(name: str) -> None:
    """Stretched, twisted and bent at a rate of 1: what grows fourfold when the number of its strain is doubled."""
    l = 1.7
    damped = {"beta_K": 0.3, "root_a": 1.3, "root_b": 0.7}
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
    for s in map(some_state, range(40)):
        # coupling up to its limit sqrt(Qa Qd), where one combination of the rates costs nothing
        Qs = np.sqrt(5.0 * 2.0) * rng.uniform(-1, 1)
        P = s.P(Qa=5.0, Qs=Qs, Qd=2.0, EI=1.5, beta_K=0.3, root_a=1.3, root_b=0.7)
        assert balance(s.q, rng.normal(size=14), s.l, s.F, P)["damping_power"] >= 0


def test_a_closed_cycle_of_strain_does_the_work_of_qb_minus_qc() -> None:
    # straight, so that e and tau are those of the degrees of freedom: an ellipse in the strain
    # plane
    l = 1.7
    Qk = 0.3
    e_0 = 0.1
    tau_0 = 0.4
    s = some_state(0)
    straight_x = np.array([0.0, 0, 0, 1, 0, 0, 0, l, 0, 0, 1, 0, 0, 0])
    F = State(s.q, s.v, s.a, l, straight_x).F
    P = s.P(Qa=5.0, Qs=0.8, Qk=Qk, Qd=2.0)
    work = 0.0
    energy_balance = 0.0
    phases = np.arange(64) * 2 * np.pi / 64
    for phi in phases:
        q = np.zeros(14)
        v = np.zeros(14)
        q[[3, 10]] = 1 + e_0 * np.cos(phi)
        q[7] = l * (1 + e_0 * np.cos(phi))
        q[13] = l * tau_0 * np.sin(phi)
        v[[3, 10]] = -e_0 * np.sin(phi)
        v[7] = -l * e_0 * np.sin(phi)
        v[13] = l * tau_0 * np.cos(phi)
        work += residual(q, v, np.zeros(14), l, F, P) @ v * 2 * np.pi / 64
        energy_balance += balance(q, v, l, F, P)["nonconservative_power"] * 2 * np.pi / 64
    # twice Qk times the enclosed area, negative for this sense; the trapezoidal rule is exact on a
    # circle
    np.testing.assert_allclose(
        [work, energy_balance], -2 * np.pi * Qk * e_0 * tau_0 * l, rtol=1e-12
    )


def test_costellos_law_is_the_gradient_of_its_energy_plus_the_remainder() -> None:
    Qa = 5.0
    Qs = 0.8
    Qk = 0.3
    Qd = 2.0
    Qe = 0.6
    e = 0.12
    tau = -0.4

    def U(x: Array) -> float:
        return float(
            costello.strain_energy(Qa, Qs, Qd, x[0], x[1])
            + costello.stiffening_energy(Qe, x[0], x[1])
        )

    dU = difference(U, np.array([e, tau]))
    law = [costello.tension(Qa, Qs, Qk, Qe, e, tau), costello.torque(Qs, Qk, Qd, Qe, e, tau)]
    np.testing.assert_allclose(
        law, dU + Qk * np.array([tau, -e]), rtol=1e-9
    )  # cubic: rounding only
    # Qb = 1.1, Qc = 0.5
    np.testing.assert_allclose(
        law, [Qa * e + 1.1 * tau + 0.5 * Qe * tau**2, 0.5 * e + (Qd + Qe * e) * tau], rtol=1e-14
    )


@seeds
@pytest.mark.parametrize("c", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.7, 1.9, 0.4)])
@pytest.mark.parametrize("fidelity", ELEMENT_DOF)
def test_at_rest_the_tangent_is_the_derivative_of_the_residual(fidelity, seed, c):
    s = some_state(seed)
    element = element_functions(fidelity)
    kept = [*ELEMENT_DOF[fidelity], *(NODE_DOF + i for i in ELEMENT_DOF[fidelity])]
    q = s.q[kept]
    rest = np.zeros(len(kept))
    P = s.P(**(MATERIAL | {"Qk": 0.0}))
    F = np.asarray(element.reference(s.reference[kept], s.l)).ravel()

    def force(q: Array, v: Array, a: Array) -> Array:
        return np.asarray(element.residual(q, v, a, s.l, F, P)).ravel()

    R, J = (np.asarray(x) for x in element.tangent(q, rest, rest, s.l, F, P, *c, q))
    along = difference(lambda x: force(q + c[0] * x, c[1] * x, c[2] * x), rest, STEP / 8)
    # truncation of second order: up to 1e-6 where a planar element is nearly compressed to a point
    np.testing.assert_allclose(J, along, rtol=0, atol=1e-9 * np.abs(J).max() + 1e-6)
    np.testing.assert_allclose(R.ravel(), force(q, rest, rest), rtol=1e-12, atol=1e-12)
    v = s.v[kept]
    a = s.a[kept]
    R = np.asarray(element.tangent(q, v, a, s.l, F, P, *c, s.reference[kept])[0]).ravel()
    np.testing.assert_allclose(R, force(q, v, a), rtol=1e-12, atol=1e-12)


def test_the_tension_before_stiffens_the_element_as_that_of_a_string() -> None:
    l = 2.0
    strain = 1e-3
    P = some_state(0).P(Qa=5.0)
    still = np.zeros(14)
    string = np.zeros((2, 14))
    string[:, [3, 7, 10]] = np.outer((1.0, 1.0 + strain), (1.0, l, 1.0))
    F = np.asarray(ELEMENT.reference(string[0], l)).ravel()
    J = [
        np.asarray(ELEMENT.tangent(string[0], still, still, l, F, P, 1.0, 0.0, 0.0, q)[1])
        for q in string
    ]
    # of cubic interpolation: Przemieniecki, Theory of Matrix Structural Analysis (1968), 15.2
    K = [[36, 3 * l, -36, 3 * l], [3 * l, 4 * l**2, -3 * l, -(l**2)], [-36, -3 * l, 36, -3 * l]]
    K = np.array([*K, [3 * l, -(l**2), -3 * l, 4 * l**2]]) * P[2] * strain / (30 * l)
    sideways = [2, 5, 9, 12]
    np.testing.assert_allclose((J[1] - J[0])[np.ix_(sideways, sideways)], K, rtol=1e-9)


@seeds
def test_what_the_tangent_leaves_out_in_motion_is_of_the_first_order_in_the_speed(
    seed: int,
) -> None:
    s = some_state(seed)
    c = (1.0, 3.0, 0.0)
    P = s.P(**(MATERIAL | {"Qk": 0.0}))
    rest = np.zeros(14)
    left_out = []
    for speed in (1e-2, 5e-3):
        v = speed * s.v
        J = np.asarray(ELEMENT.tangent(s.q, v, rest, s.l, s.F, P, *c, s.q)[1])
        along = difference(
            lambda x, v=v: residual(s.q + c[0] * x, v + c[1] * x, rest, s.l, s.F, P), rest, STEP
        )
        left_out.append(np.abs(J - along).max())
    np.testing.assert_allclose(left_out[0] / left_out[1], 2.0, rtol=0.05)


@seeds
def test_the_strain_energy_does_not_see_a_rotation_or_translation(seed: int) -> None:
    s = some_state(seed)
    turn = rotation(np.random.default_rng(100 + seed).normal(size=3) * 2)
    there = turned(s.q, turn)
    there[[0, 7]] += 12.0
    moved = State(there, s.v, s.a, s.l, turned(s.reference, turn))
    before, after = (balance(x.q, x.v, x.l, x.F, x.P(**MATERIAL)) for x in (s, moved))
    # rounding, and coordinates of 12 in differences of 1
    np.testing.assert_allclose([after[x] for x in STRAIN], [before[x] for x in STRAIN], rtol=1e-12)
