"""Search for the values that minimise a cost within bounds: a Latin hypercube, then COBYQA from its best points.

COBYQA is a trust-region method by quadratic models without derivatives, which keeps bounds and takes constraints, and
costs some ten complete runs per value that is varied. The hypercube's points are evaluated at once and the searches go
on side by side, so that runs share the cluster; all of them are the same ones again with the same seed, so that an
interrupted search is resumed from the runs that are there.
Source: T. M. Ragonneau, Model-based derivative-free optimization methods and software, PhD thesis, The Hong Kong
Polytechnic University, 2022; scipy.optimize carries it out.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rope_model.arrays import Array

FIRST_STEP = 0.2  #: Radius of the trust region at the start, in parts of the ranges.
LAST_STEP = 5e-3  #: Radius of the trust region at the end, in parts of the ranges.


class Score(NamedTuple):
    """Score of a point; cost and violations are infinite where a run failed."""

    cost: float
    violations: tuple[float, ...] = ()  # of each bound, as a part of it; 0 or less where it is kept

    @property
    def finite(self) -> bool:
        """True if the score can be compared."""
        return all(map(math.isfinite, (self.cost, *self.violations)))

    @property
    def feasible(self) -> bool:
        """True if all bounds are kept."""
        return self.finite and max(self.violations, default=0.0) <= 0.0

    @property
    def rank(self) -> tuple[float, float]:
        """Key by which scores are sorted, smaller is better: bounds come before the cost."""
        return max(0.0, *self.violations, 0.0), self.cost


#: Judges points, shape (points, dimensions), each coordinate between 0 and 1; called from several threads.
Evaluate = Callable[[Array], Sequence[Score]]


@dataclass(frozen=True)
class Plan:
    """Sizes of the hypercube and of the searches."""

    sample: int  # points of the hypercube
    searches: int  # number of searches, from the best points
    steps: int  # points of each search at most
    seed: int


@dataclass(frozen=True)
class SearchResult:
    """Points of a search in their order, the same at each repetition, and their scores."""

    points: Array  # (points, dimensions)
    scores: tuple[Score, ...]

    @property
    def best(self) -> int:
        """Place of the best point, which need not keep its bounds."""
        return min(range(len(self.scores)), key=lambda k: self.scores[k].rank)


def search(evaluate: Evaluate, dimensions: int, plan: Plan) -> SearchResult:
    """Minimise by a Latin hypercube and COBYQA from its best ``plan.searches`` points; return all points tried."""
    # slow to load, as the methods of minimise: most studies search nothing
    from scipy.stats import (
        qmc,
    )

    points = qmc.LatinHypercube(d=dimensions, rng=np.random.default_rng(plan.seed)).random(
        plan.sample
    )
    judged = list(evaluate(points))
    finite = [k for k, point in enumerate(judged) if point.finite]
    if not finite:
        raise RuntimeError(
            "search: no run of it completed: look at the causes in the results, or narrow the ranges"
        )
    starts = sorted(finite, key=lambda k: judged[k].rank)[: plan.searches]
    walks = _walks(
        [_Walk(evaluate, points[k], judged[k], [judged[i] for i in finite]) for k in starts],
        plan.steps,
    )
    return SearchResult(
        np.vstack([points, *(x for walk in walks for x in walk.points)]),
        (*judged, *(point for walk in walks for point in walk.scores)),
    )


def _walks(walks: Sequence[_Walk], steps: int) -> Sequence[_Walk]:
    """Run the searches, one thread each; when one is interrupted, the others end with their next point."""
    with ThreadPoolExecutor(len(walks)) as threads:
        running = [threads.submit(walk.minimise, steps) for walk in walks]
        try:
            for one in running:
                one.result()
        except BaseException:
            for walk in walks:
                walk.stopped.set()
            raise
    return walks


class _Walk:
    """One search from a point, and the points that it tries beyond that."""

    def __init__(
        self, evaluate: Evaluate, start: Array, judged: Score, sample: Sequence[Score]
    ) -> None:
        costs = [point.cost for point in sample]
        # a run that failed scores worse than any, but makes no cliff for the quadratic models
        self._failed = Score(2.0 * max(costs) - min(costs), tuple(1.0 for _ in judged.violations))
        self._evaluate = evaluate
        self._start = start
        self._seen = {start.tobytes(): judged}
        self.points: list[Array] = []
        self.scores: list[Score] = []
        self.stopped = threading.Event()

    def minimise(self, steps: int) -> None:
        from scipy.optimize import Bounds, NonlinearConstraint, minimize

        bounds = len(self._failed.violations)
        within = NonlinearConstraint(
            lambda x: self._at(x).violations, np.full(bounds, -np.inf), np.zeros(bounds)
        )
        minimize(
            lambda x: self._at(x).cost,
            self._start,
            method="COBYQA",
            bounds=Bounds(np.zeros(self._start.size), np.ones(self._start.size)),
            constraints=[within] if bounds else [],
            options={
                "maxfev": steps,
                "initial_tr_radius": FIRST_STEP,
                "final_tr_radius": LAST_STEP,
            },
        )

    def _at(self, x: Array) -> Score:
        key = np.asarray(x, dtype=np.float64).tobytes()
        if key not in self._seen:
            if self.stopped.is_set():
                raise InterruptedError("the search is given up")
            (self._seen[key],) = self._evaluate(x[None].copy())
            self.points.append(x.copy())
            self.scores.append(self._seen[key])
        return self._seen[key] if self._seen[key].finite else self._failed
