"""Newton's verdicts, and what it says is left of the error."""

import math
from collections.abc import Iterator

import casadi as ca
import pytest
from integrated_systems import verdict_on
from numpy.testing import assert_allclose

from rope_model.numerics.newton import NewtonStatus, newton, report


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
def test_newton_returns_its_verdict(norms: list[float], status: NewtonStatus, iterations: int) -> None:
    verdict = verdict_on(iter(norms), 2e-8, 10)
    assert (verdict.status, verdict.iterations) == (status, iterations)
    assert verdict.converged == (status is NewtonStatus.CONVERGED)


def test_newtons_estimate_bounds_what_is_left_of_a_linear_contraction() -> None:
    rate, x = 0.3, [1.0]

    def corrections() -> Iterator[float]:
        while True:
            x.append(rate * x[-1])
            yield x[-2] - x[-1]

    verdict = verdict_on(corrections(), 1e-6, 50)
    assert_allclose(verdict.error, x[-1], rtol=1e-6)
    assert x[-1] <= 1e-6 < x[-2]


@pytest.mark.parametrize(("tolerance", "reached", "corrections"), [(0.05, 1.04, 2), (0.03, 1.008, 3)])
def test_the_error_left_by_a_wrong_derivative_is_estimated(tolerance: float, reached: float, corrections: int) -> None:
    z, factor, dx = ca.MX.sym("z", 1, 2), ca.MX.sym("factor"), ca.MX.sym("dx")  # x and its residual, x - 1
    moved = z[0] + dx
    iteration = newton(
        ca.Function("factorize", [z], [1.25 + 0 * z[0]]),  # a wrong derivative: the error contracts by 0.2
        ca.Function("correct", [z, factor], [-z[1] / factor, ca.fabs(z[1] / factor)]),
        ca.Function("apply", [z, dx], [ca.horzcat(moved, moved - 1)]),
    )
    found, progress = iteration(ca.DM([[2.0, 1.0]]), tolerance)
    verdict = report(progress.full().ravel().tolist())
    assert (verdict.status, verdict.iterations) == (NewtonStatus.CONVERGED, corrections)
    assert_allclose(found.full().ravel(), [reached, reached - 1], rtol=1e-12)
    assert verdict.error == pytest.approx(reached - 1, rel=1e-12)
