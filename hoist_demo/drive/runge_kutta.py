"""One step of an explicit Runge-Kutta method of fifth order, and its error, as text for CasADi.

    k_i = f(t + c_i h, y + h sum_j a_ij k_j) ,   y_new = y + h sum_i b_i k_i ,   error = h sum_i (b_i - b*_i) k_i

The last stage is the first of the next step. Source: J. R. Dormand and P. J. Prince, A family of embedded Runge-Kutta
formulae, Journal of Computational and Applied Mathematics 6 (1980), RK5(4)7M; the coefficients are SciPy's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from scipy.integrate import RK45

ORDER = RK45.order

_A = (*(tuple(map(float, row[:i])) for i, row in enumerate(RK45.A) if i), tuple(map(float, RK45.B)))
_C = (*map(float, RK45.C[1:]), 1.0)
_ERROR = tuple(-float(e) for e in RK45.E)


def runge_kutta_step(f: Callable[[Any, Any], Any], t: Any, y: Any, k: Any, h: Any) -> tuple[Any, Any, Any]:
    """State after h, f there, and the error; k is f(t, y)."""
    stages = [k]
    new = y
    for a, c in zip(_A, _C, strict=True):
        new = y + h * _sum(a, stages)
        stages.append(f(t + c * h, new))
    return new, stages[-1], h * _sum(_ERROR, stages)


def _sum(weights: Sequence[float], stages: Sequence[Any]) -> Any:
    """Weighted sum of the stages, without those of no weight."""
    terms = [weight * stage for weight, stage in zip(weights, stages, strict=True) if weight]
    return sum(terms[1:], terms[0])
