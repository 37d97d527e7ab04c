"""Newton's method for a chain with forces between nodes far apart: (J + C) x = -R.

J is the chain's block tridiagonal matrix, for which the chain has a solver; C contains the tangents of forces between
far nodes.  analysis.conjugate_gradients finds x.  Factorizations and corrections are controlled as in numerics.newton.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rope_model.analysis.conjugate_gradients import conjugate_gradients
from rope_model.arrays import Array
from rope_model.numerics import newton as control
from rope_model.numerics.newton import NewtonReport
from rope_model.rules.newton import NewtonLimits


class Iterate(NamedTuple):
    """Coordinates q, v, a and the residual."""

    q: Array
    v: Array
    a: Array
    R: Array


class Coupled(NamedTuple):
    """Functions of a coupled system for ``newton``.

    factorized: iterate -> solver of J x = -R for x
    coupling:   iterate -> function that multiplies with C, None where C = 0
    residual:   q, v, a, previous R -> R
    norm:       norm of a correction
    """

    factorized: Callable[[Iterate], Callable[[Array], Array]]
    coupling: Callable[[Iterate], Callable[[Array], Array] | None]
    residual: Callable[[Array, Array, Array, Array], Array]
    norm: Callable[[Array], float]


def newton(
    system: Coupled,
    x: Iterate,
    c: Array,
    tolerance: float,
    limits: NewtonLimits,
    error_fraction: float,
) -> tuple[Iterate, NewtonReport]:
    """Correct ``x`` until its residual is zero where free; v and a follow by c[1] and c[2] times the corrections."""
    progress = control.initial_progress(error_fraction)
    for _ in range(int(limits.rounds)):
        solve = system.factorized(x)
        for k in range(int(limits.per_round)):
            if k > 0 and not (
                progress[control.STATUS] == control.RUNNING
                and progress[control.CONTRACTION] < limits.slow
            ):
                break
            coupling = system.coupling(x)
            dx = solve(x.R) if coupling is None else conjugate_gradients(solve, coupling, x.R)
            progress = control.judge(limits)(progress, system.norm(dx), tolerance, k == 0)
            if progress[control.APPLIES] != 0:
                q, v, a = (
                    part + factor * dx for part, factor in zip(x[:3], c.tolist(), strict=True)
                )
                x = Iterate(q, v, a, system.residual(q, v, a, x.R))
        if progress[control.STATUS] != control.RUNNING:
            break
    return x, control.report(np.array(progress).ravel().tolist())
