"""One step of an explicit Runge-Kutta method of fifth order, and its error, as text for CasADi.

    k_i = f(t + c_i h, y + h sum_j a_ij k_j) ,   y_new = y + h sum_i b_i k_i ,   error = h sum_i (b_i - b*_i) k_i

The last stage is the first of the next step. Source: J. R. Dormand and P. J. Prince, A family of embedded Runge-Kutta
formulae, Journal of Computational and Applied Mathematics 6 (1980), RK5(4)7M.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

ORDER = 5

#: of the last stage, which is the result
_B = (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84)
_A = (
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    _B,
)
_C = (1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
#: b - b*
_ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)


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
