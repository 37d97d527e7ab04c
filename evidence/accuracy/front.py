"""Pareto fronts, and what is read off them."""

import numpy as np
from numpy.typing import NDArray

from evidence.tables import Array


def pareto(cost: Array, error: Array) -> NDArray[np.intp]:
    """Indices, by rising cost, of the points that no other point beats in both; points that are not finite never."""
    order = np.lexsort((error, cost))
    kept = []
    best = np.inf
    for i in order:
        if np.isfinite(cost[i]) and error[i] < best:
            kept.append(i)
            best = error[i]
    return np.array(kept, dtype=np.intp)


def cost_at(cost: Array, error: Array, bound: float) -> float:
    """What an error of ``bound`` costs on the points' front: interpolated linearly in the logarithms.

    The cheapest point's cost where that is better than asked for, NaN where no point is good enough.
    """
    front = pareto(cost, error)
    if front.size == 0 or error[front].min() > bound:
        return float("nan")
    x = np.log(np.maximum(error[front][::-1], np.finfo(float).tiny))
    return float(np.exp(np.interp(np.log(bound), x, np.log(cost[front][::-1]))))


def cheapest(cost: Array, error: Array, bound: float) -> int | None:
    """Index of the cheapest point within ``bound``."""
    front = pareto(cost, error)
    good = front[error[front] <= bound]
    return int(good[0]) if good.size else None
