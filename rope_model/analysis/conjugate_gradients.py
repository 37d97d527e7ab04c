"""Conjugate gradients for (J + C) x = -R, preconditioned with J, for which there is a solver.

C is symmetric and positive semidefinite.  J^-1 C has rank r, so that exact arithmetic ends after
r + 1 steps.  Each step takes one solution with J and no product, because J p follows from the
recurrence of p.
"""

from collections.abc import Callable

import numpy as np

from rope_model.arrays import Array
from rope_model.method.newton import CG_MAX_STEPS, CG_TOLERANCE


def conjugate_gradients(
    solve: Callable[[Array], Array], coupling: Callable[[Array], Array], R: Array
) -> Array:
    """Solve (J + C) x = -R, where ``solve`` solves J x = -R and ``coupling`` multiplies with C."""
    p = solve(R)
    error = first = -float(np.vdot(R, p))
    g = R
    Jp = -R
    x = np.zeros_like(R)
    for _ in range(CG_MAX_STEPS):
        Ap = Jp + coupling(p)
        curvature = float(np.vdot(p, Ap))
        if not curvature > 0:
            return x if x.any() else p
        alpha = error / curvature
        x = x + alpha * p
        g = g + alpha * Ap
        z = solve(g)
        before = error
        error = -float(np.vdot(g, z))
        if not error > CG_TOLERANCE * first:
            break
        p = z + error / before * p
        Jp = error / before * Jp - g
    return x
