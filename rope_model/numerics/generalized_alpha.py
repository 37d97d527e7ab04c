"""Generalized-alpha method with variable steps for second-order systems with prescribed degrees of freedom.

    alpha_m = (2 rho - 1)/(rho + 1),  alpha_f = rho/(rho + 1),  gamma = 1/2 + alpha_f - alpha_m,
    beta = (1 + alpha_f - alpha_m)^2 / 4
    (1 - alpha_m) b_{n+1} + alpha_m b_n = (1 - alpha_f) a_{n+1} + alpha_f a_n
    q_{n+1} = q_n + h v_n + h^2 ((1/2 - beta) b_n + beta b_{n+1})
    v_{n+1} = v_n + h ((1 - gamma) b_n + gamma b_{n+1})

a is the acceleration, b the auxiliary one; equilibrium holds at t_{n+1} with a_{n+1}.  b_n approximates the
acceleration at t_n + (alpha_m - alpha_f) h.  A change of the step moves that instant, and b must be moved with it
(re-centring), or the method falls to first order:

    b_n <- b_n + (alpha_m - alpha_f) (h_new - h_old) (a_n - a_{n-1}) / h_old

Sources: Chung and Hulbert, J. Appl. Mech. 60 (1993); Arnold and Brüls, Multibody Syst. Dyn. 18 (2007), for the
form with auxiliary accelerations; Brüls and Arnold, J. Comput. Nonlinear Dyn. 3 (2008), for variable steps.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from rope_model.arrays import Array
from rope_model.numerics.newton import NewtonReport
from rope_model.rules.generalized_alpha import (
    MAX_GROWTH,
    Coefficients,
    Motion,
    auxiliary_weights,
    local_error,
    recentring_time,
)
from rope_model.rules.newton import NewtonStatus


class HasReaction(Protocol):
    """Evaluation of a system at an instant, with at least its residual."""

    @property
    def reaction(self) -> Array:
        """Residual R: zero where free, the force of the surroundings where prescribed."""


B = TypeVar("B", bound=HasReaction)


@dataclass(frozen=True)
class Solution(Generic[B]):
    """Result of Newton's method: q, v, a, their evaluation, and its report.

    ``resolve`` returns the resolved part of a change of the accelerations, J^-1 c[2] M times it; by default all of it.
    """

    q: Array
    v: Array
    a: Array
    evaluation: B
    newton: NewtonReport
    resolve: Callable[[Array], Array] = lambda change: change


class System(Protocol[B]):
    """System to be integrated.  ``reaction`` is the previous one, for loads that depend on it (friction)."""

    @property
    def free(self) -> NDArray[np.bool_]:
        """True where a degree of freedom is free, False where it is prescribed."""

    @property
    def smooth(self) -> bool:
        """True if accelerations are likely to continue at their rate."""

    def prescribed_motion(self, t: float) -> Array:
        """Return full arrays of q, v and a (3, ...), of which the prescribed entries count."""

    def solve(
        self,
        q: Array,
        v: Array,
        a: Array,
        reaction: Array,
        c: Array,
        tolerance: float,
        before: Array,
    ) -> Solution[B]:
        """Find the equilibrium by corrections x of the free q, to which v and a follow by c[1] x and c[2] x.

        Stresses at the guess q may be far off: the derivatives take the strains of the configuration ``before``.
        """

    def newton_step(
        self, q: Array, v: Array, a: Array, reaction: Array, c: Array
    ) -> tuple[Array, Array]:
        """Return x and R: J x = -R on the free degrees of freedom with J = c[0] dR/dq + c[1] dR/dv + c[2] dR/da."""

    def evaluate(self, q: Array, v: Array, a: Array, reaction: Array) -> B:
        """Evaluate the residual and whatever else the system reports of this instant."""

    def norm(self, x: Array) -> float:
        """Return the size of a correction or error, in the system's unit."""


def rate_known(h: float, before: float) -> bool:
    """Return whether the acceleration's rate over a step of length ``before`` serves a step of length ``h``."""
    return 0 < h <= MAX_GROWTH * before


def recentring(method: Coefficients, h: float, before: float) -> float:
    """Return the time (s) by which b moves when a step ``h`` follows one of length ``before``, 0 after a restart."""
    return float(recentring_time(method, h, before)) if rate_known(h, before) else 0.0


@dataclass(frozen=True)
class StepResult(Generic[B]):
    """Trial step: motion and evaluation (None if Newton's method failed), report, local error.

    The error is in ``System.norm``.  ``a_rate`` is that of the resolved part of the motion.
    """

    motion: Motion | None
    evaluation: B | None
    newton: NewtonReport
    error: float
    a_rate: Array | None


def step(
    system: System[B], old: Motion, h: float, method: Coefficients, tolerance: float
) -> StepResult[B]:
    """Take a trial step of length ``h``; ``tolerance`` is Newton's, in ``System.norm``."""
    t, free = old.t + h, system.free
    past = np.array((old.q, old.v, old.a, old.b, old.a_rate))
    correction_motion, ahead = (
        recentring(method, h, old.h),
        h if system.smooth and rate_known(h, old.h) else 0.0,
    )
    flat = past.reshape(len(past), -1)
    q, v, a = guess = (method.prediction(h, correction_motion, ahead) @ flat).reshape(
        3, *old.q.shape
    )
    np.copyto(guess, system.prescribed_motion(t), where=~free)
    with np.errstate(all="ignore"):  # a diverging trial shows in its norm
        solution = system.solve(q, v, a, old.reaction, method.newton(h), tolerance, old.q)
    newton, evaluation = solution.newton, solution.evaluation
    if newton.converged and not math.isfinite(evaluation.reaction.sum()):
        newton = NewtonReport(NewtonStatus.NOT_FINITE, newton.iterations, np.inf)
    if not newton.converged:
        return StepResult(None, None, newton, np.inf, None)
    a = solution.a
    *before, weight = auxiliary_weights(method, correction_motion)
    b = (np.array(before) @ flat[2:]).reshape(a.shape) + weight * a
    change = a - old.a
    resolved = solution.resolve(change)
    error = local_error(method, h, system.norm(free * resolved))
    motion = Motion(t, solution.q, solution.v, a, b, change / h, h, evaluation.reaction)
    return StepResult(motion, evaluation, newton, error, resolved / h)


def restart(system: System[B], t: float, q: Array, v: Array, reaction: Array) -> tuple[Motion, B]:
    """Return a consistent motion at ``t``, with prescribed values, accelerations from equilibrium and no history.

    The residual is linear in the acceleration, so one correction solves it.
    """
    free = system.free
    q_p, v_p, a_p = system.prescribed_motion(t)
    q, v = np.where(free, q, q_p), np.where(free, v, v_p)
    a = np.where(free, 0.0, a_p)
    for _ in range(2):  # friction needs the reactions of the first correction
        x, reaction = system.newton_step(q, v, a, reaction, np.array([0.0, 0.0, 1.0]))
        a = a + x
    evaluation = system.evaluate(q, v, a, reaction)
    return Motion(t, q, v, a, a, np.zeros_like(a), 0.0, evaluation.reaction), evaluation
