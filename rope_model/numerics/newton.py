"""Newton's method as one CasADi function: a full correction, then cheap ones with the same factorization.

The error after correction k is estimated from the contraction theta = d_k / d_{k-1} of the corrections' norms, error <=
theta / (1 - theta) d_k  (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8).  A round begins with a
new factorization and continues with it while the contraction pays; a slow round is followed by another.  The iterations
are branches and loops of generated code: only needed parts are evaluated.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca

from rope_model.rules.newton import HUGE, SMOOTH, UNKNOWN, NewtonLimits, NewtonStatus

_STATUS = {status.code: status for status in NewtonStatus}


@dataclass(frozen=True)
class NewtonReport:
    """Status, number of corrections, and estimated norm of the remaining error."""

    status: NewtonStatus
    iterations: int
    error: float

    @property
    def converged(self) -> bool:
        """True if the result may be used."""
        return self.status is NewtonStatus.CONVERGED


#: entries of the progress vector.  applies: 1 if the latest correction does.  contraction: before the first correction
#: the assumed error over that correction
PROGRESS = ("status", "iterations", "applies", "norm", "error", "contraction")
STATUS, ITERATIONS, APPLIES, NORM, ERROR, CONTRACTION = range(len(PROGRESS))
#: status while the iteration continues, and its result where the limits end it
RUNNING = NewtonStatus.TOO_MANY.code


def initial_progress(error_fraction: Any = UNKNOWN) -> Any:
    """Return the progress before the first correction."""
    return ca.vertcat(0.0, 0.0, 1.0, ca.inf, ca.inf, error_fraction)


def report(progress: list[float]) -> NewtonReport:
    """Return the report of a finished progress vector."""
    return NewtonReport(_STATUS[int(progress[STATUS])], int(progress[ITERATIONS]), progress[ERROR])


@cache
def judge(limits: NewtonLimits = SMOOTH) -> ca.Function:
    """Build (progress, norm of the correction, tolerance, 1 if its factorization is new) -> progress after it."""
    before, norm, tolerance = (
        ca.SX.sym("progress", len(PROGRESS)),
        ca.SX.sym("norm"),
        ca.SX.sym("tolerance"),
    )
    fresh = ca.SX.sym("fresh")
    _, iterations, _, previous, _, error_fraction = ca.vertsplit(before)
    contraction = ca.if_else(previous > 0, norm / previous, 0.0)
    first = iterations < 1
    sure = ca.logic_and(ca.logic_not(first), contraction < limits.unsure)
    guess = ca.if_else(first, error_fraction * norm, norm)
    error = ca.if_else(sure, contraction / (1 - contraction) * norm, guess)
    useless = ca.logic_not(ca.logic_or(sure, fresh))
    diverged = ca.logic_and(ca.logic_not(first), contraction >= limits.growing)
    # status, applies, norm, error, contraction
    after = ca.vertcat(RUNNING, 1, norm, error, contraction)
    done = ca.vertcat(NewtonStatus.CONVERGED.code, 1, norm, error, contraction)
    after = ca.if_else(error <= tolerance, done, after)
    after = ca.if_else(
        diverged, ca.vertcat(NewtonStatus.DIVERGED.code, 1, norm, norm, contraction), after
    )
    # a cheap correction that contracts badly only shows that a new factorization is due
    after = ca.if_else(useless, ca.vertcat(RUNNING, 0, previous, ca.inf, ca.inf), after)
    finite = norm < HUGE  # false for NaN too
    after = ca.if_else(
        finite, after, ca.vertcat(NewtonStatus.NOT_FINITE.code, 1, norm, ca.inf, contraction)
    )
    return ca.Function(
        "judge", [before, norm, tolerance, fresh], [ca.vertcat(after[0], iterations + 1, after[1:])]
    )


def newton(factorize: ca.Function, correct: ca.Function, apply: ca.Function) -> ca.Function:
    """Build the whole iteration; x contains its residual, so that none is evaluated twice.

    factorize: (x, *fixed) -> factors ...                     of the derivative at x
    correct:   (x, *factors, *fixed) -> correction, norm      with these factors
    apply:     (x, correction, *fixed) -> x                   with its residual
    result:    (x, *fixed, tolerance, error_fraction) -> x, progress; ``error_fraction`` is that of initial_progress
    """
    number = factorize.n_out()
    x, *fixed = factorize.mx_in()
    factors = [ca.MX.sym(f"factor{i}", factorize.sparsity_out(i)) for i in range(number)]
    progress, tolerance = ca.MX.sym("progress", len(PROGRESS)), ca.MX.sym("tolerance")
    moved = _where(apply, 1)

    def one_correction(name: str, fresh: bool) -> ca.Function:
        step, norm = correct(x, *factors, *fixed)
        after = judge()(progress, norm, tolerance, fresh)
        inputs = [x, progress, *factors, *fixed, tolerance]
        return ca.Function(name, inputs, [moved(after[APPLIES], x, step, *fixed), after])

    first, again = (
        one_correction("newton_first", True),
        _where(one_correction("newton_again", False), 2),
    )
    after = first(x, progress, *factors, *fixed, tolerance)
    for _ in range(int(SMOOTH.per_round) - 1):
        goes_on = ca.logic_and(after[1][STATUS] == RUNNING, after[1][CONTRACTION] < SMOOTH.slow)
        after = again(goes_on, *after, *factors, *fixed, tolerance)
    corrections = ca.Function(
        "newton_corrections", [x, progress, *factors, *fixed, tolerance], [*after]
    )
    inputs = [x, progress, *fixed, tolerance]
    factors_x = factorize.call([x, *fixed])
    one_round = ca.Function(
        "newton_round", inputs, corrections.call([x, progress, *factors_x, *fixed, tolerance])
    )
    another = _where(one_round, 2)
    error_fraction = ca.MX.sym("error_fraction")
    result = one_round(x, initial_progress(error_fraction), *fixed, tolerance)
    for _ in range(int(SMOOTH.rounds) - 1):
        result = another(result[1][STATUS] == RUNNING, *result, *fixed, tolerance)
    return ca.Function("newton", [x, *fixed, tolerance, error_fraction], list(result))


def _where(function: ca.Function, states: int) -> ca.Function:
    """Build (condition, inputs) -> ``function`` of the inputs, or its first ``states`` inputs unchanged."""
    inputs = function.mx_in()
    passed = ca.Function(f"{function.name()}_not", inputs, inputs[:states])
    return ca.Function.if_else(f"{function.name()}_if", function, passed)
