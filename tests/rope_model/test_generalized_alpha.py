"""The reference's integrator: order 2 with constant and varying steps, spectral radius, consistent restarts."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from shared import Array

from rope_model.method.generalized_alpha import MAX_GROWTH, Motion
from rope_model.reference.generalized_alpha import restart, step
from rope_model.reference.newton import Cause

#: step patterns, repeated: the ratios stay the same when the steps are refined
CONSTANT = (1.0,)
VARYING = (0.6, 1.2, 0.9, 1.8, 0.5, 1.0)
NEWTON = 1e-12


@dataclass(frozen=True)
class Factors:
    """Tangent J of a system in the plane."""

    J: Array
    held: NDArray[np.bool_]
    singular: bool = False

    def solve(self, force: Array) -> Array:
        return np.where(self.held, 0.0, np.linalg.solve(self.J, force.T).T)


class System:
    """Another system than a rope, in the form of reference.equations.Equations."""

    held: NDArray[np.bool_]

    def residual(self, q: Array, v: Array, a: Array) -> Array:
        raise NotImplementedError

    def tangent(self, q: Array, c: tuple[float, float, float]) -> Array:
        raise NotImplementedError

    def linearised(
        self, q: Array, v: Array, a: Array, c: tuple[float, float, float], prestress: Array
    ) -> tuple[Array, Factors]:
        return self.residual(q, v, a), Factors(self.tangent(q, c), self.held)

    def size(self, x: Array) -> float:
        return float(np.max(np.abs(x), where=~self.held, initial=0.0))


class SpringPendulum(System):
    """A mass on a stiffening spring with a damper, hung from a point that is moved; rows: point, mass."""

    mass = 1.3
    stiffness = 40.0
    damping = 0.4
    rest = 1.0
    gravity = 9.8
    held = np.array([[True, True], [False, False]])

    def held_motion(self, t: float) -> Array:
        s = np.sin(2 * t)
        c = np.cos(2 * t)
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

    def tangent(self, q: Array, c: tuple[float, float, float]) -> Array:
        d = q[1] - q[0]
        L = float(np.linalg.norm(d))
        n = d / L
        stretch = L - self.rest
        across = self.stiffness * (stretch + stretch**3) / L
        K = across * np.eye(2) + (self.stiffness * (1 + 3 * stretch**2) - across) * np.outer(n, n)
        return np.asarray(c[0] * K + (c[1] * self.damping + c[2] * self.mass) * np.eye(2))

    def exact(self, t: float) -> tuple[Array, Array, Array]:
        """q, v of the mass and force on the point, by another method."""
        start = np.array([0.4, -1.3, 0.5, 0.2])

        def rates(t: float, y: Array) -> Array:
            point = self.held_motion(t)
            pull = self.pull(np.array([point[0][0], y[:2]]), np.array([point[1][0], y[2:]]))
            return np.array([*y[2:], *(-pull / self.mass - [0.0, self.gravity])])

        y = solve_ivp(rates, (0.0, t), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        point = self.held_motion(t)
        return (
            y[:2],
            y[2:],
            -self.pull(np.array([point[0][0], y[:2]]), np.array([point[1][0], y[2:]])),
        )

    def start(self) -> Motion:
        q = np.array([[0.0, 0.0], [0.4, -1.3]])
        v = np.array([[0.0, 0.0], [0.5, 0.2]])
        motion = restart(self, 0.0, q, v)  # type: ignore[arg-type]
        assert isinstance(motion, Motion)
        return motion


def integrate(
    system, motion: Motion, end: float, steps: int, pattern, rho: float, recentre: bool = True
) -> Motion:
    h = np.resize(np.array(pattern), steps)
    instants = motion.t + (end - motion.t) * np.cumsum(h) / h.sum()
    for t in instants:
        if not recentre:
            motion = replace(motion, a_rate=np.zeros_like(motion.a_rate))
        result = step(system, motion, t - motion.t, rho, NEWTON)
        assert result.motion is not None, result.cause
        motion = result.motion
    return motion


PENDULUM_END = 1.5  # s


def pendulum_orders(
    pattern: tuple[float, ...], rho: float, steps: int = 120, recentre: bool = True
) -> Array:
    """Observed orders (3,) of q, v and end force."""
    system = SpringPendulum()
    errors = []
    exact = system.exact(PENDULUM_END)
    for n in (steps, 2 * steps):
        m = integrate(system, system.start(), PENDULUM_END, n, pattern, rho, recentre)
        pairs = zip((m.q[1], m.v[1], m.reaction[0]), exact, strict=True)
        errors.append(np.array([np.linalg.norm(x - y) for x, y in pairs]))
    return np.asarray(np.log2(errors[0] / errors[1]))


@pytest.mark.parametrize("rho", [0.0, 0.6, 1.0])
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
class Oscillator(System):
    """q'' = -omega^2 q."""

    omega: float
    held = np.array([[False]])

    def held_motion(self, t: float) -> Array:
        return np.zeros((3, 1, 1))

    def residual(self, q: Array, v: Array, a: Array) -> Array:
        return a + self.omega**2 * q

    def tangent(self, q: Array, c: tuple[float, float, float]) -> Array:
        return np.array([[c[2] + c[0] * self.omega**2]])


def amplification(rho: float, omega: float) -> Array:
    """(3, 3) of one step h = 1 on (omega^2 q, omega v, b)."""
    columns = []
    for q, v, b in np.diag([omega**-2, 1 / omega, 1.0]):
        at = [np.full((1, 1), x) for x in (q, v, -(omega**2) * q, b, 0.0)]
        old = Motion(0.0, *at[:4], a_rate=at[4], h=1.0, reaction=at[4])
        # the first correction of a linear system is exact, and is taken
        new = step(Oscillator(omega), old, 1.0, rho, 1e2).motion  # type: ignore[arg-type]
        assert new is not None
        columns.append([new.q[0, 0] * omega**2, new.v[0, 0] * omega, new.b[0, 0]])
    return np.array(columns).T


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.6, 0.9, 1.0])
def test_no_frequency_is_amplified_and_the_radius_at_infinite_frequency_is_rho(rho: float) -> None:
    frequencies = [*np.geomspace(0.01, 1e3, 40), 1e4]
    radii = [np.abs(np.linalg.eigvals(amplification(rho, omega))).max() for omega in frequencies]
    assert max(radii) < 1 + 1e-6  # a multiple eigenvalue of rounding 1e-16 each
    # a triple eigenvalue moves with (h omega)^(-2/3)
    np.testing.assert_allclose(radii[-1], rho, atol=1e-2)


def test_a_restart_gives_accelerations_in_equilibrium_and_no_history() -> None:
    system = SpringPendulum()
    start = SpringPendulum().start()
    rng = np.random.default_rng(5)
    q = start.q + 0.05 * rng.normal(size=start.q.shape)
    v = rng.normal(size=start.q.shape)
    m = restart(system, 0.3, q, v)
    assert isinstance(m, Motion)
    np.testing.assert_allclose(m.reaction[~system.held], 0.0, atol=1e-12)  # rounding of 50 N
    given = system.held_motion(0.3)
    for x, y in zip((m.q, m.v, m.a), given, strict=True):
        np.testing.assert_array_equal(x[system.held], y[system.held])
    np.testing.assert_array_equal(m.q[~system.held], q[~system.held])
    np.testing.assert_array_equal(m.b, m.a)
    assert m.h == 0
    assert not m.a_rate.any()


def test_a_step_that_grows_too_fast_does_not_extrapolate_the_acceleration() -> None:
    system = SpringPendulum()
    m = integrate(system, system.start(), 0.01, 4, CONSTANT, 0.6)
    noisy = replace(m, a_rate=1e6 * np.ones_like(m.a_rate))
    h = 1.01 * MAX_GROWTH * m.h
    one, other = (step(system, x, h, 0.6, NEWTON).motion for x in (m, noisy))
    np.testing.assert_array_equal(one.q, other.q)


def test_a_failed_step_is_a_verdict_and_leaves_the_old_motion_alone() -> None:
    system = SpringPendulum()
    start = SpringPendulum().start()
    before = start.q.copy()
    hard = step(system, start, 50.0, 0.6, 1e-12)
    assert hard.motion is None
    assert hard.cause in (Cause.DIVERGED, Cause.NOT_CONVERGED)
    np.testing.assert_array_equal(start.q, before)
