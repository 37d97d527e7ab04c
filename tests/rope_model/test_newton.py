"""The engine's judgement of Newton's corrections: its status, and the error that it reckons to be left."""

import math

import pytest
from native_parts import CProgress, newton_judge

from rope_model.method.newton import UNKNOWN, NewtonStatus


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
        ([0.9**k for k in range(10)], NewtonStatus.TOO_MANY, 10),
    ],
)
def test_corrections_are_judged_by_their_norms(
    norms: list[float], status: NewtonStatus, iterations: int
) -> None:
    progress = CProgress(contraction=UNKNOWN)
    for norm in norms:
        assert progress.status == NewtonStatus.TOO_MANY.code
        progress = newton_judge(progress, norm, 2e-8, fresh=True)
    assert (progress.status, progress.iterations) == (status.code, iterations)


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
    tolerance: float, leaves: float, corrections: int, error: float
) -> None:
    """The error of x = 1, from x = 2 on, contracts by 0.2: a derivative of 1.25 instead of 1."""
    progress = CProgress(contraction=leaves)
    x = 2.0
    while progress.status == NewtonStatus.TOO_MANY.code:
        correction = (1.0 - x) / 1.25
        x += correction
        progress = newton_judge(
            progress, abs(correction), tolerance, fresh=progress.iterations == 0
        )
    assert (progress.status, progress.iterations) == (NewtonStatus.CONVERGED.code, corrections)
    assert progress.error == pytest.approx(error, rel=1e-12)
    assert x == pytest.approx(1.0 + error, rel=1e-12)
