"""Order 2 with constant and varying steps, the spectral radius, consistent restarts; Newton's verdicts."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
import pytest
from conftest import Array
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from rope_model.numerics.generalized_alpha import Solution, restart, step
from rope_model.numerics.newton import NewtonReport, initial_progress, judge, newton, report
from rope_model.rules.generalized_alpha import MAX_GROWTH, Coefficients, Motion
from rope_model.rules.newton import UNKNOWN, NewtonStatus


def verdict_on(norms: Iterator[float], tolerance: float, most: int) -> NewtonReport:
    progress, verdict = initial_progress(), judge()
    for norm in itertools.islice(norms, most):
        progress = verdict(progress, norm, tolerance, True)
        if progress[0] != NewtonStatus.TOO_MANY.code:
            break
    return report(np.asarray(progress).ravel().tolist())


#: step patterns, repeated: the ratios stay the same when the steps are refined
CONSTANT, VARYING = (1.0,), (0.6, 1.2, 0.9, 1.8, 0.5, 1.0)
NEWTON = 1e-12


@dataclass(frozen=True)
class Told:
    reaction: Array


class Corrected:
    """A system that is solved by Newton's method with a new derivative in every correction."""

    smooth = True

    def solve(
        self: Any,
        q: Array,
        v: Array,
        a: Array,
        reaction: Array,
        c: Array,
        tolerance: float,
        _: Array,
    ) -> Any:
        def corrections() -> Iterator[float]:
            nonlocal q, v, a, reaction
            while True:
                x, reaction = self.newton_step(q, v, a, reaction, c)
                q, v, a = q + x, v + c[1] * x, a + c[2] * x
                yield self.norm(x)

        newton = verdict_on(corrections(), tolerance, 10)
        return Solution(q, v, a, self.evaluate(q, v, a, reaction), newton)

    def evaluate(self: Any, q: Array, v: Array, a: Array, reaction: Array) -> Told:
        return Told(self.residual(q, v, a))

    def norm(self, x: Array) -> float:
        return float(np.max(np.abs(x)))


class SpringPendulum(Corrected):
    """A mass on a stiffening spring with a damper, hung from a point that is moved; rows: point, mass."""

    mass, stiffness, damping, rest, gravity = 1.3, 40.0, 0.4, 1.0, 9.8
    free = np.array([[False, False], [True, True]])

    def prescribed_motion(self, t: float) -> Array:
        s, c = np.sin(2 * t), np.cos(2 * t)
        rows = ([0.3 * s, 0.2 * (1 - c)], [0.6 * c, 0.4 * s], [-1.2 * s, 0.8 * c])
        return np.array([[row, [0.0, 0.0]] for row in rows])

    def pull(self, q: Array, v: Array) -> Array:
        d = q[1] - q[0]
        stretch = np.linalg.norm(d) - self.rest
        force = self.stiffness * (stretch + stretch**3) * d / np.linalg.norm(d)
        return np.asarray(force + self.damping * (v[1] - v[0]))

    def residual(self, q: Array, v: Array, a: Array) -> Array:
        pull = self.pull(q, v)
        return np.array([-pull, self.mass * a[1] + pull + [0.0, self.mass * self.gravity]])

    def newton_step(
        self, q: Array, v: Array, a: Array, reaction: Array, c: Array
    ) -> tuple[Array, Array]:
        R, d = self.residual(q, v, a), q[1] - q[0]
        L = float(np.linalg.norm(d))
        n, stretch = d / L, L - self.rest
        across = self.stiffness * (stretch + stretch**3) / L
        K = across * np.eye(2) + (self.stiffness * (1 + 3 * stretch**2) - across) * np.outer(n, n)
        J = c[0] * K + (c[1] * self.damping + c[2] * self.mass) * np.eye(2)
        return np.array([[0.0, 0.0], -np.linalg.solve(J, R[1])]), R

    def exact(self, t: float) -> tuple[Array, Array, Array]:
        """q, v of the mass and force on the point, by another method."""
        start = np.array([0.4, -1.3, 0.5, 0.2])

        def rates(t: float, y: Array) -> Array:
            point = self.prescribed_motion(t)
            pull = self.pull(np.array([point[0][0], y[:2]]), np.array([point[1][0], y[2:]]))
            return np.array([*y[2:], *(-pull / self.mass - [0.0, self.gravity])])

        y = solve_ivp(rates, (0.0, t), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        point = self.prescribed_motion(t)
        return (
            y[:2],
            y[2:],
            -self.pull(np.array([point[0][0], y[:2]]), np.array([point[1][0], y[2:]])),
        )

    def start(self) -> Motion:
        q, v = np.array([[0.0, 0.0], [0.4, -1.3]]), np.array([[0.0, 0.0], [0.5, 0.2]])
        return restart(self, 0.0, q, v, np.zeros((2, 2)))[0]


def integrate(
    system, motion: Motion, end: float, steps: int, pattern, rho: float, recentre: bool = True
) -> Motion:
    h = np.resize(np.array(pattern), steps)
    instants = motion.t + (end - motion.t) * np.cumsum(h) / h.sum()
    for t in instants:
        if not recentre:
            motion = replace(motion, a_rate=np.zeros_like(motion.a_rate))
        result = step(system, motion, t - motion.t, Coefficients(rho), NEWTON)
        assert result.motion is not None, result.newton
        motion = result.motion
    return motion


PENDULUM_END = 1.5  # s


def pendulum_orders(
    pattern: tuple[float, ...], rho: float, steps: int = 120, recentre: bool = True
) -> Array:
    """Observed orders (3,) of q, v and end force."""
    system, errors = SpringPendulum(), []
    exact = system.exact(PENDULUM_END)
    for n in (steps, 2 * steps):
        m = integrate(system, system.start(), PENDULUM_END, n, pattern, rho, recentre)
        pairs = zip((m.q[1], m.v[1], m.reaction[0]), exact, strict=True)
        errors.append(np.array([np.linalg.norm(x - y) for x, y in pairs]))
    return np.asarray(np.log2(errors[0] / errors[1]))


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.6, 0.9, 1.0])
@pytest.mark.parametrize("pattern", [CONSTANT, VARYING], ids=["constant", "varying"])
def test_a_nonlinear_pendulum_is_integrated_with_order_two(
    pattern: tuple[float, ...], rho: float
) -> None:
    np.testing.assert_allclose(pendulum_orders(pattern, rho), 2.0, atol=0.1)


def test_without_re_centring_varying_steps_fall_to_first_order() -> None:
    assert np.all(pendulum_orders(VARYING, 0.6, steps=480, recentre=False) < 1.4)
    # and constant steps do not need it
    np.testing.assert_allclose(pendulum_orders(CONSTANT, 0.6, recentre=False), 2.0, atol=0.1)


@dataclass(frozen=True)
class Oscillator(Corrected):
    """q'' = -omega^2 q."""

    omega: float
    free = np.array([[True]])

    def prescribed_motion(self, t: float) -> Array:
        return np.zeros((3, 1, 1))

    def residual(self, q: Array, v: Array, a: Array) -> Array:
        return a + self.omega**2 * q

    def newton_step(
        self, q: Array, v: Array, a: Array, reaction: Array, c: Array
    ) -> tuple[Array, Array]:
        R = self.residual(q, v, a)
        return -R / (c[2] + c[0] * self.omega**2), R


def amplification(rho: float, omega: float) -> Array:
    """(3, 3) of one step h = 1 on (q, v/omega, b/omega^2)."""
    columns = []
    for q, v, b in np.diag([1.0, omega, omega**2]):
        a = -(omega**2) * q
        at = [np.full((1, 1), x) for x in (q, v, a, b, 0.0)]
        old = Motion(0.0, *at[:4], a_rate=at[4], h=1.0, reaction=at[4])
        new = step(Oscillator(omega), old, 1.0, Coefficients(rho), 1e-9).motion
        columns.append([new.q[0, 0], new.v[0, 0] / omega, new.b[0, 0] / omega**2])
    return np.array(columns).T


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.6, 0.9, 1.0])
def test_no_frequency_is_amplified_and_the_radius_at_infinite_frequency_is_rho(rho: float) -> None:
    frequencies = [*np.geomspace(0.01, 1e3, 40), 1e4]
    radii = [np.abs(np.linalg.eigvals(amplification(rho, omega))).max() for omega in frequencies]
    assert max(radii) < 1 + 1e-6  # a multiple eigenvalue of rounding 1e-16 each
    # a triple eigenvalue moves with (h omega)^(-2/3)
    np.testing.assert_allclose(radii[-1], rho, atol=1e-2)


def test_the_error_estimate_is_the_local_error_to_leading_order() -> None:
    system = SpringPendulum()
    for rho in (0.3, 0.6):
        ratios = []
        for h in (4e-3, 2e-3):
            # a start with history: b where constant steps have it
            m = integrate(system, system.start(), 0.4, round(0.4 / h), CONSTANT, rho)
            result = step(system, m, h, Coefficients(rho), NEWTON)
            fine = integrate(
                system, restart(system, m.t, m.q, m.v, m.reaction)[0], m.t + h, 64, CONSTANT, 1.0
            )
            assert result.motion is not None
            ratios.append(result.error / system.norm(result.motion.q - fine.q))
        np.testing.assert_allclose(ratios[-1], 1.0, atol=0.1)


def test_a_restart_gives_accelerations_in_equilibrium_and_no_history() -> None:
    system, start = SpringPendulum(), SpringPendulum().start()
    rng = np.random.default_rng(5)
    q, v = start.q + 0.05 * rng.normal(size=start.q.shape), rng.normal(size=start.q.shape)
    m, told = restart(system, 0.3, q, v, start.reaction)
    np.testing.assert_allclose(told.reaction[system.free], 0.0, atol=1e-12)  # rounding of 50 N
    given = system.prescribed_motion(0.3)
    for x, y in zip((m.q, m.v, m.a), given, strict=True):
        np.testing.assert_array_equal(x[~system.free], y[~system.free])
    np.testing.assert_array_equal(m.q[system.free], q[system.free])
    np.testing.assert_array_equal(m.b, m.a)
    assert m.h == 0
    assert not m.a_rate.any()


def test_a_step_that_grows_too_fast_does_not_extrapolate_the_acceleration() -> None:
    system = SpringPendulum()
    m = integrate(system, system.start(), 0.01, 4, CONSTANT, 0.6)
    noisy = replace(m, a_rate=1e6 * np.ones_like(m.a_rate))
    h = 1.01 * MAX_GROWTH * m.h
    one, other = (step(system, x, h, Coefficients(0.6), NEWTON).motion for x in (m, noisy))
    np.testing.assert_array_equal(one.q, other.q)


def test_a_failed_step_is_a_verdict_and_leaves_the_old_motion_alone() -> None:
    system, start = SpringPendulum(), SpringPendulum().start()
    before = start.q.copy()
    hard = step(system, start, 50.0, Coefficients(0.6), 1e-12)
    assert (hard.motion, hard.evaluation, hard.newton.converged, hard.error) == (
        None,
        None,
        False,
        math.inf,
    )
    np.testing.assert_array_equal(start.q, before)


@pytest.mark.parametrize(
    ("norms", "status", "iterations"),
    [
        ([1e-9], NewtonStatus.CONVERGED, 1),  # tiny at once
        ([1.0, 1e-4], NewtonStatus.CONVERGED, 2),  # the contraction promises 1e-8
        ([1.0, 1e-2, 1e-6], NewtonStatus.CONVERGED, 3),
        ([1.0, 0.0], NewtonStatus.CONVERGED, 2),
        ([1.0, 1.5, 13.0], NewtonStatus.DIVERGED, 3),
        ([1.0, math.nan], NewtonStatus.NOT_FINITE, 2),
        ([math.inf], NewtonStatus.NOT_FINITE, 1),
        ([0.9**k for k in range(20)], NewtonStatus.TOO_MANY, 10),
    ],
)
def test_newton_returns_its_verdict(
    norms: list[float], status: NewtonStatus, iterations: int
) -> None:
    verdict = verdict_on(iter(norms), 2e-8, 10)
    assert (verdict.status, verdict.iterations) == (status, iterations)
    assert verdict.converged == (status is NewtonStatus.CONVERGED)


@pytest.mark.parametrize(
    ("tolerance", "leaves", "corrections", "error"),
    [
        (0.05, UNKNOWN, 2, 0.04),
        (0.03, UNKNOWN, 3, 0.008),
        (0.1, 0.25, 2, 0.04),
        (0.3, 0.25, 1, 0.2),
    ],
)
def test_the_error_left_by_a_wrong_derivative_is_estimated(
    tolerance, leaves: float, corrections: int, error
) -> None:
    z, factor, dx = (
        ca.MX.sym("z", 1, 2),
        ca.MX.sym("factor"),
        ca.MX.sym("dx"),
    )  # x and its residual, x - 1
    moved = z[0] + dx
    iteration = newton(
        ca.Function(
            "factorize", [z], [1.25 + 0 * z[0]]
        ),  # a wrong derivative: the error contracts by 0.2
        ca.Function("correct", [z, factor], [-z[1] / factor, ca.fabs(z[1] / factor)]),
        ca.Function("apply", [z, dx], [ca.horzcat(moved, moved - 1)]),
    )
    found, progress = iteration(ca.DM([[2.0, 1.0]]), tolerance, leaves)
    verdict = report(progress.full().ravel().tolist())
    assert (verdict.status, verdict.iterations) == (NewtonStatus.CONVERGED, corrections)
    assert_allclose(found.full().ravel(), [1 + error, error], rtol=1e-12)
    assert verdict.error == pytest.approx(error, rel=1e-12)
