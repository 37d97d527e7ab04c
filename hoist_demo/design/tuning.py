"""Search for the values that minimise a weighted sum of metrics: differential evolution over complete runs.

A generation is evaluated as a whole, so that its runs share the cluster; the same seed makes the same runs, so that
an interrupted search is resumed from the runs that are there.
Source: R. Storn and K. Price, Differential evolution, J. Global Optimization 11, 1997; scipy.optimize carries it out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution
from scipy.stats import qmc

Array = NDArray[np.float64]

Evaluate = Callable[[Array], Sequence[float]]
"""Costs of points, shape (points, dimensions), each coordinate between 0 and 1; infinite where a run failed."""


def search(evaluate: Evaluate, dimensions: int, generations: int, population: int, seed: int) -> Array:
    """The best point found, shape (dimensions,), each coordinate between 0 and 1."""
    start = qmc.LatinHypercube(d=dimensions, rng=np.random.default_rng(seed)).random(population)

    def whole_generation(_: object, points: Iterable[Array]) -> Sequence[float]:
        costs = evaluate(np.array(list(points)))
        return [cost if math.isfinite(cost) else math.inf for cost in costs]

    found = differential_evolution(
        lambda x: math.inf,  # never called: generations are evaluated by `whole_generation`
        [(0.0, 1.0)] * dimensions,
        init=start,
        maxiter=generations - 1,
        updating="deferred",
        workers=whole_generation,
        polish=False,
        tol=0.0,
        rng=np.random.default_rng(seed),
    )
    if not math.isfinite(found.fun):
        raise RuntimeError("search: no run of it completed: look at the causes in the results, or narrow the ranges")
    return np.asarray(found.x, dtype=np.float64)
