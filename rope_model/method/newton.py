"""Limits and statuses of Newton's method."""

from enum import Enum
from typing import NamedTuple

from rope_model.physics.elementary import Scalar, logical_and, maximum, where

#: larger norms are not finite in effect
HUGE = 1e200


class NewtonLimits(NamedTuple):
    """Limits of an iteration."""

    rounds: float  #: largest number of factorizations
    per_round: float  #: largest number of corrections with each
    slow: float  #: contraction from which on a new factorization pays
    unsure: float  #: contraction from which on it does not serve the error estimate
    growing: float  #: growth of full corrections that counts as divergence; a little growth at the start does not


SMOOTH = NewtonLimits(8.0, 5.0, 0.1, 0.5, 8.0)
#: limits for equations with kinks: a factorization and its prediction serve one side of a kink only
KINKED = NewtonLimits(16.0, 1.0, 0.1, 0.2, HUGE)
# assumed error after the first correction over that correction
UNKNOWN = 1.0  #: value without knowledge of the system
GOOD = 0.1  #: value of a smooth system in a time step with a small tolerance: windings and stops left 0.04 at most
SMALL = 1e-4  #: largest such tolerance


class NewtonStatus(Enum):
    """Outcome of an iteration, with its code, which counts from 0, and a message for the user."""

    TOO_MANY = 0, "Newton iteration did not converge within the allowed iterations"
    CONVERGED = 1, "Newton iteration converged"
    DIVERGED = (
        2,
        "Newton iteration diverged: the step is too large or the elements are too long for this motion",
    )
    NOT_FINITE = 3, "Newton iteration met a value that is not finite"

    def __init__(self, code: int, text: str) -> None:
        self.code = code
        self.text = text


#: fraction of the initial squared error, in J's norm, at which conjugate gradients end
CG_TOLERANCE = 1e-16
#: largest number of steps of conjugate gradients
CG_MAX_STEPS = 200

#: Newton iterations of a step where they are bounded: the largest number in recorded trips
STEP_ITERATIONS = 12
# errors (m and rad) that Newton's method may leave where work is bounded to one step
BOUNDED_STEP_ERROR = 1e-4
BOUNDED_MESH_ERROR = 2e-3  #: on a new mesh


def effective_tolerance(
    newton_tolerance: Scalar, work_max: Scalar, bounded_tolerance: Scalar
) -> Scalar:
    """Return Newton's tolerance (m and rad), at least ``bounded_tolerance`` where work is bounded to one step."""
    bounded = logical_and(work_max > 0.0, work_max < 2.0 * STEP_ITERATIONS)
    return where(bounded, maximum(newton_tolerance, bounded_tolerance), newton_tolerance)
