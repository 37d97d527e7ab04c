"""Weighted least squares with bounds over shares of ranges, and the information of the data.

With the residuals r = (model - measured) / sigma and J = dr/du in the normalised parameters u,
shares of the ranges, the information of the data is J^T J = V diag(s^2) V^T.  Along V_k the data
give the standard error 1 / s_k; where that is more than a range has by itself, 1 / sqrt(12), the
data do not tell, and the range stands:

    covariance = V diag(min(1 / s_k^2, 1/12)) V^T

The interval of a share ends where the least sum of squares that the other shares can reach, with
this one held, has grown by 1.645^2 (profile likelihood; D. J. Venzon and S. H. Moolgavkar, Applied
Statistics 37, 1988, 87-94), or at the end of the range: for a linear model u +- 1.645
sqrt(covariance_ii).  sigma is stated and not estimated, so that the quantile is the normal one.

A share whose best value lies beyond its range is held at that end: it is no degree of freedom of
the fit, the data give it no interval, and its range stands.

A further measurement with the sensitivity j (in its standard errors) leaves (covariance^-1 + j
j^T)^-1.
"""

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, lsq_linear
from scipy.special import chdtrc, ndtri  # scipy.stats is slow to load

from rope_model.arrays import Array

Signs = NDArray[np.int_]
#: (norm_params (n,)) -> prediction less measurement in standard errors (m,).
Residuals = Callable[[Array], Array]
MIDDLE = 0.5  #: Value of all shares before anything is measured.
RANGE_VARIANCE = 1 / 12  #: Variance of a share of which only the range is known.
CONFIDENCE = 0.9  #: Confidence of the intervals.
REACH = float(ndtri(0.5 + 0.5 * CONFIDENCE))  #: Half width of an interval in standard errors.
DIFFERENCE = 5e-3  #: Change of a share by which the sensitivities are taken.
END_TOLERANCE = 0.02  #: Tolerance of an interval's ends, in parts of its half width.
END_TRIALS = 6  #: Most trials for each end of an interval.
CORRECTIONS = 2  #: Corrections of the other shares in each trial.
#: Standard errors per share by which the first fit holds all shares at the middle of their ranges.
PULL = 0.1
#: Distance of a share from an end of its range within which it is held there, if its next step
#: leads beyond that end; the search stays within the ranges and comes this near and nearer.
AT_END = 0.01
#: Least distance of a share from an end of its range as a second search begins.
FROM_END = 1e-3
#: Relative tolerance of the shares.
XTOL = 1e-6
SIGNIFICANCE = 0.01  #: p-value below which the measurements contradict the model.


class NotComputed(RuntimeError):
    """Rope that cannot be computed with these values: a search turns back from them."""


@dataclass(frozen=True)
class Fit:
    """Least-squares fit.

    norm_params (n,), residuals (m,) in standard errors, and their sensitivities (m, n).

    ``prior_rows`` (k, n) hold the shares at the middle of their ranges in directions that the data
    do not tell. ``held`` (n,) is 1 for a share at the upper end of its range, beyond which the data
    ask for more, -1 at the lower end, and 0 for a free one.
    """

    norm_params: Array
    residuals: Array
    sensitivities: Array
    prior_rows: Array
    held: Signs
    nuisance: int = 0  # other unknowns, each found by the residuals

    def of_first_params(self, count: int) -> "Fit":
        """Return the fit of the first ``count`` shares; the others are fitted for each value."""
        first, others = np.hsplit(self.sensitivities, [count])
        others = others[:, self.held[count:] == 0]
        first = first - others @ np.linalg.lstsq(others, first, rcond=None)[0]
        return replace(
            self,
            norm_params=self.norm_params[:count],
            sensitivities=first,
            prior_rows=self.prior_rows[:, :count],
            held=self.held[:count],
        )

    @property
    def covariance(self) -> Array:
        """Covariance of the shares, no larger than that of the ranges.

        Shares that are held have the covariance of their ranges.
        """
        s, directions = self._directions()
        variances = np.full(s.size, RANGE_VARIANCE)
        determined = s * s > 1 / RANGE_VARIANCE
        variances[determined] = 1 / s[determined] ** 2
        of_held = np.where(self.held == 0, 0.0, RANGE_VARIANCE)
        return np.asarray((directions * variances) @ directions.T + np.diag(of_held))

    def undetermined_directions(self) -> list[Array]:
        """Return directions in the free shares that the data determine less than the ranges."""
        s, directions = self._directions()
        return [directions[:, k] for k in np.flatnonzero(s * s <= 1 / RANGE_VARIANCE)]

    def _directions(self) -> tuple[Array, Array]:
        """Information along each direction of the free shares, in standard errors per share.

        Directions in columns.
        """
        free = np.flatnonzero(self.held == 0)
        directions = np.zeros((self.held.size, free.size))
        if not free.size:
            return np.zeros(0), directions
        rows_of_free = np.vstack((self.sensitivities[:, free], np.zeros((free.size, free.size))))
        _, s, rows = np.linalg.svd(rows_of_free, full_matrices=False)
        directions[free] = rows.T
        return s, directions

    @property
    def reaches(self) -> Array:
        """Half widths of the intervals, in shares, if the model were linear."""
        return np.asarray(REACH * np.sqrt(np.diag(self.covariance)))

    @property
    def correlations(self) -> Array:
        """Correlation matrix of the shares, (n, n)."""
        error = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(error, error))

    @property
    def p_value(self) -> float:
        """Probability of residuals at least this large by chance.

        As many values as were found leave no residual; one that is left, where no rope could be
        computed, counts as of one degree of freedom.
        """
        determined = np.count_nonzero(self.held == 0) - len(self.undetermined_directions())
        degrees_of_freedom = max(1, self.residuals.size - self.nuisance - determined)
        return float(chdtrc(degrees_of_freedom, self.residuals @ self.residuals))

    @property
    def contradicted(self) -> bool:
        """Return True if the measurements contradict the model, or one another, beyond chance."""
        return self.p_value < SIGNIFICANCE


def fit(residuals: Residuals, count: int, ftol: float = 1e-8) -> Fit:
    """Return the ``count`` shares with the least squares, to the relative tolerance ``ftol``.

    Undetermined shares stay at the middle of their ranges.
    """
    start = np.full(count, MIDDLE)
    residuals = _where_computed(residuals, residuals(start).size)
    first = _solve(residuals, start, np.zeros(count, dtype=int), PULL * np.eye(count), ftol)
    undetermined = first.undetermined_directions()
    if not undetermined:
        return first
    start = np.clip(first.norm_params, FROM_END, 1 - FROM_END)
    prior_rows = np.array(undetermined) / np.sqrt(RANGE_VARIANCE)
    return _solve(residuals, start, first.held, prior_rows, ftol)


def _where_computed(residuals: Residuals, size: int) -> Residuals:
    """Return infinite residuals for NotComputed, so that a search turns back.

    Any other error ends the search, with its traceback.
    """

    def residuals_or_infinity(norm_params: Array) -> Array:
        try:
            return residuals(norm_params)
        except NotComputed:
            return np.full(size, np.inf)

    return residuals_or_infinity


def _solve(residuals: Residuals, start: Array, held: Signs, prior_rows: Array, ftol: float) -> Fit:
    """Solve from ``start``.

    ``prior_rows`` hold shares at the middle; shares that reach an end of their range are held
    there.
    """
    while True:
        found = _solve_free(residuals, start, held, prior_rows, ftol)
        reached = np.where(held == 0, _ends_reached(found), held)
        if (reached == held).all():
            break
        start = found.norm_params
        held = reached
    if held.any():  # a profile lets a held share come back from its end
        found = replace(found, sensitivities=sensitivities(residuals, found.norm_params))
    return found


def _solve_free(
    residuals: Residuals, start: Array, held: Signs, prior_rows: Array, ftol: float
) -> Fit:
    """Solve for the shares that are not held; sensitivities to the others are 0."""
    free = np.flatnonzero(held == 0)
    norm_params = np.where(held > 0, 1.0, 0.0)

    def with_free(of_free: Array) -> Array:
        whole = norm_params.copy()
        whole[free] = of_free
        return whole

    def remaining(of_free: Array) -> Array:
        return _all(residuals, prior_rows, with_free(of_free))

    def slopes(of_free: Array) -> Array:
        of_data = sensitivities(lambda u: residuals(with_free(u)), of_free)
        return np.vstack((of_data, prior_rows[:, free]))

    if not free.size:
        values = residuals(norm_params)
        return Fit(norm_params, values, np.zeros((values.size, held.size)), prior_rows, held)
    solution = least_squares(remaining, start[free], slopes, (0.0, 1.0), xtol=XTOL, ftol=ftol)
    if not solution.success:
        raise RuntimeError(
            f"the fit does not converge ({solution.message}): narrow the ranges, or fix some values"
        )
    count = solution.fun.size - len(prior_rows)
    jacobian = np.zeros((count, held.size))
    jacobian[:, free] = solution.jac[:count]
    return Fit(with_free(solution.x), solution.fun[:count], jacobian, prior_rows, held)


def _ends_reached(found: Fit) -> Signs:
    """Return 1 or -1 for a share at the upper or lower end whose next step leads beyond, else 0."""
    jacobian = np.vstack((found.sensitivities, found.prior_rows))
    prior = found.prior_rows @ (found.norm_params - MIDDLE)
    slope = jacobian.T @ np.concatenate((found.residuals, prior))
    curvature = np.maximum((jacobian**2).sum(axis=0), np.finfo(float).tiny)
    beyond = found.norm_params - slope / curvature
    above = (found.norm_params > 1.0 - AT_END) & (beyond > 1.0)
    below = (found.norm_params < AT_END) & (beyond < 0.0)
    return np.asarray(above.astype(int) - below.astype(int))


def _all(residuals: Residuals, prior_rows: Array, norm_params: Array) -> Array:
    """Concatenate the residuals and the rows that hold the shares at the middle, (m + k,)."""
    return np.concatenate((residuals(norm_params), prior_rows @ (norm_params - MIDDLE)))


def intervals(residuals: Residuals, best_fit: Fit) -> Array:
    """Return the lower and upper end of each share's interval, (n, 2).

    The interval of a share that is held is its whole range.
    """
    residuals = _where_computed(residuals, best_fit.residuals.size)
    free = np.flatnonzero(best_fit.held == 0)
    ends = np.tile([0.0, 1.0], (best_fit.held.size, 1))
    shares = np.repeat(free, 2).tolist()
    sides = [-1.0, 1.0] * free.size
    # the native rope computes outside of Python's lock
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(partial(_end, residuals, best_fit), shares, sides))
    ends[free] = np.reshape(found, (-1, 2))
    return ends


def _end(residuals: Residuals, best_fit: Fit, k: int, side: float) -> float:
    """Return the value of share ``k`` at which the squares have grown by REACH^2.

    After END_TRIALS it is the nearest value at which they have grown by more, or, if no rope could
    be computed there, the farthest at which one could; where they never grew by as much, it is the
    range's end.
    """
    column = best_fit.covariance[:, k]
    # a standard error of share k, and how the others follow
    along = side * column / np.sqrt(column[k])
    # standard errors to the end of the range
    limit = float(0.5 * (1 + side) - best_fit.norm_params[k]) / along[k]
    reach = REACH
    inside = 0.0  # the farthest at which the squares have grown by less
    outside = math.inf  # the nearest at which they have grown by more
    computed = True  # a rope could be computed there
    for _ in range(END_TRIALS):
        reach = min(reach, limit)
        increase = _root_of_increase(residuals, best_fit, k, reach * along)
        if reach == limit and increase <= REACH:
            return 0.5 * (1 + side)
        if abs(increase - REACH) < END_TOLERANCE * REACH:
            return float(best_fit.norm_params[k] + reach * along[k])
        if increase < REACH:
            inside = reach
        else:
            outside = reach
            computed = math.isfinite(increase)
        # the root of the growth is close to linear; a fit that creeps on has none
        reach *= float(np.clip(REACH / max(increase, 1e-9), 0.5, 2.0))
        if not inside < reach < outside:
            reach = 0.5 * (inside + outside)
    if math.isinf(outside):  # the squares hardly grow: no end was found within the range
        return 0.5 * (1 + side)
    nearest = outside if computed else inside
    return float(best_fit.norm_params[k] + nearest * along[k])


def _root_of_increase(residuals: Residuals, best_fit: Fit, k: int, step: Array) -> float:
    """Return the root of the growth of the squares ``step`` away from the fit.

    The other shares are corrected first.
    """
    jacobian = np.vstack((best_fit.sensitivities, best_fit.prior_rows))
    others = np.arange(best_fit.norm_params.size) != k
    prior = best_fit.prior_rows @ (best_fit.norm_params - MIDDLE)
    smallest_sum = float(best_fit.residuals @ best_fit.residuals + prior @ prior)
    norm_params = np.clip(best_fit.norm_params + step, 0.0, 1.0)
    squares: list[float] = []
    for _ in range(CORRECTIONS + 1):
        r = _all(residuals, best_fit.prior_rows, norm_params)
        squares.append(float(r @ r))
        if not math.isfinite(squares[-1]):
            break
        if not others.any():
            break
        bounds = (-norm_params[others], 1.0 - norm_params[others])
        correction = lsq_linear(jacobian[:, others], -r, bounds, method="bvls").x
        norm_params = norm_params.copy()
        norm_params[others] = np.clip(norm_params[others] + correction, 0.0, 1.0)
    return math.sqrt(max(min(squares) - smallest_sum, 0.0))


def sensitivities(predict: Callable[[Array], Array], norm_params: Array) -> Array:
    """Return d(prediction)/d(share) by differences within the ranges, (m, n).

    The differences are central where both sides are finite.
    """
    steps = DIFFERENCE * np.eye(norm_params.size)
    above = np.clip(norm_params + steps, 0.0, 1.0)
    below = np.clip(norm_params - steps, 0.0, 1.0)
    # the native rope computes outside of Python's lock
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        values = np.array(list(pool.map(predict, [*above, *below])))
    missing = ~np.isfinite(values).all(axis=1)
    if missing.any():
        values[missing] = predict(norm_params)
        above[missing[: norm_params.size]] = norm_params
        below[missing[norm_params.size :]] = norm_params
        if not np.diag(above - below).all():
            raise RuntimeError(
                "no rope on either side of the one found can be computed: narrow the ranges"
            )
    differences = values[: norm_params.size] - values[norm_params.size :]
    return np.asarray((differences / np.diag(above - below)[:, None]).T)


def error_of(covariance: Array, gradient: Array) -> float:
    """Return the standard error of an output with this gradient (n,) in the shares."""
    return float(np.sqrt(gradient @ covariance @ gradient))


def with_measurement(covariance: Array, sensitivity: Array) -> Array:
    """Return the covariance after one more measurement.

    Its ``sensitivity`` (n,) is in its standard errors per share.
    """
    along = covariance @ sensitivity
    return np.asarray(covariance - np.outer(along, along) / (1 + sensitivity @ along))
