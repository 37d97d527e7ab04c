"""Newton's method seen from outside: when it has converged, and why it has not.

The error after correction k is estimated from the contraction theta = d_k / d_{k-1} of the corrections' norms,
error <= theta / (1 - theta) d_k  (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum


class NewtonStatus(Enum):
    """How an iteration ended; the value is what the user is told."""

    CONVERGED = "Newton iteration converged"
    DIVERGED = "Newton iteration diverged: the step is too large or the elements are too long for this motion"
    TOO_MANY = "Newton iteration did not converge within the allowed iterations"
    NOT_FINITE = "Newton iteration met a value that is not finite"


@dataclass(frozen=True)
class NewtonReport:
    """Status, corrections applied, and the estimated norm of what is left."""

    status: NewtonStatus
    iterations: int
    error: float

    @property
    def converged(self) -> bool:
        """Whether the result may be used."""
        return self.status is NewtonStatus.CONVERGED


def iterate(correct: Callable[[], float], tolerance: float, max_iterations: int) -> NewtonReport:
    """Call ``correct``, which applies one correction and returns its norm, until the rest is below ``tolerance``."""
    previous = math.inf
    for k in range(1, max_iterations + 1):
        norm = correct()
        if not math.isfinite(norm):
            return NewtonReport(NewtonStatus.NOT_FINITE, k, norm)
        contraction = norm / previous if previous > 0 else 0.0
        if k > 1 and contraction >= 2:
            return NewtonReport(NewtonStatus.DIVERGED, k, norm)
        # the first correction says nothing of the contraction: trust it only when it is tiny itself
        error = norm if k == 1 or contraction >= 0.5 else contraction / (1 - contraction) * norm
        if error <= tolerance:
            return NewtonReport(NewtonStatus.CONVERGED, k, error)
        previous = norm
    return NewtonReport(NewtonStatus.TOO_MANY, max_iterations, norm)
