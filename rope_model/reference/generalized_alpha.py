"""Extended generalized-alpha method: one step of the equations of motion.

    (1 - alpha_m) b1 + alpha_m b0 = (1 - alpha_f) a1 + alpha_f a0
    q1 = q0 + h v0 + h^2 ((1/2 - beta) b0 + beta b1)
    v1 = v0 + h ((1 - gamma) b0 + gamma b1)
    R(q1, v1, a1) = 0

(docs/theory/time.md, eq-alpha and eq-coefficients).  a is the acceleration, b the auxiliary one,
which approximates a at t0 + (alpha_m - alpha_f) h.  A change of the step moves that instant, and b
with it (eq-recentre), or the method falls to first order:

    b0 <- b0 + (alpha_m - alpha_f) (h - h_before) (a0 - a_before) / h_before

What is held follows its own motion; it takes part with its acceleration.
"""

from dataclasses import dataclass

import numpy as np

from rope_model.arrays import Array
from rope_model.method.generalized_alpha import (
    MAX_GROWTH,
    Coefficients,
    Motion,
    local_error,
    newton_coefficients,
    recentring_time,
)
from rope_model.reference.equations import Equations
from rope_model.reference.newton import Cause, Failure, Guess, solve

TOLERANCE = 3e-6  #: m and rad, last correction of Newton's method


@dataclass(frozen=True)
class Step:
    """Trial step; ``motion`` is None if it failed for the ``cause``."""

    motion: Motion | None
    corrections: int
    cause: Cause | None


def step(
    equations: Equations, old: Motion, h: float, rho_inf: float, tolerance: float = TOLERANCE
) -> Step:
    """Return a trial step of ``h`` (s); ``tolerance`` (m and rad) is that of Newton's method."""
    method = Coefficients(rho_inf)
    alpha_m = method.alpha_m
    alpha_f = method.alpha_f
    beta = method.beta
    gamma = method.gamma

    b_old = old.b
    a = old.a
    if 0 < h <= MAX_GROWTH * old.h:
        b_old = old.b + recentring_time(method, h, old.h) * old.a_rate
        a = old.a + h * old.a_rate

    def auxiliary(a_new: Array) -> Array:
        return ((1 - alpha_f) * a_new + alpha_f * old.a - alpha_m * b_old) / (1 - alpha_m)

    b = auxiliary(a)
    q = old.q + h * old.v + h * h * ((0.5 - beta) * b_old + beta * b)
    v = old.v + h * ((1 - gamma) * b_old + gamma * b)
    held_q, held_v, held_a = equations.held_motion(old.t + h)
    q = np.where(equations.held, held_q, q)
    v = np.where(equations.held, held_v, v)
    a = np.where(equations.held, held_a, a)

    of_motion = newton_coefficients(method, h)
    found = solve(equations, Guess(q, v, a), of_motion, tolerance, prestress=old.q)
    if found.cause is not None:
        return Step(None, found.corrections, found.cause)
    a_rate = (found.a - old.a) / h
    motion = Motion(
        old.t + h, found.q, found.v, found.a, auxiliary(found.a), a_rate, h, found.reaction
    )
    return Step(motion, found.corrections, None)


def restart(equations: Equations, t: float, q: Array, v: Array) -> Motion | Failure:
    """Return the motion at ``t`` (s) with accelerations from equilibrium and without a history.

    The residual is linear in the accelerations: one correction finds them.  It fails if something
    that is free has no mass.
    """
    held_q, held_v, held_a = equations.held_motion(t)
    q = np.where(equations.held, held_q, q)
    v = np.where(equations.held, held_v, v)
    a = np.where(equations.held, held_a, 0.0)
    R, mass = equations.linearised(q, v, a, (0.0, 0.0, 1.0), prestress=q)
    if mass.singular:
        return Failure(Cause.SINGULAR, t, "a restart of the integrator")
    a = a + mass.solve(-R)
    return Motion(t, q, v, a, a, np.zeros_like(a), 0.0, equations.residual(q, v, a))


def largest_error(equations: Equations, old: Motion, new: Motion, rho_inf: float) -> float:
    """Return the largest local error (m and rad) of a step (docs/theory/time.md, eq-local)."""
    return float(local_error(Coefficients(rho_inf), new.h, equations.size(new.a - old.a)))
