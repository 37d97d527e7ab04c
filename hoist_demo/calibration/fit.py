"""Weighted least squares with bounds over shares of ranges, and how much the data tell.

With the residuals r = (model - measured) / sigma and J = dr/du in the shares u of the ranges, the information of the
data is J^T J = V diag(s^2) V^T.  Along V_k the data give the standard error 1 / s_k; where that is more than a range
has by itself, 1 / sqrt(12), the data do not tell, and the range stands:

    covariance = V diag(min(1 / s_k^2, 1/12)) V^T          interval of 90 %: u +- 1.645 sqrt(covariance_ii)

A further measurement with the sensitivity j (in its standard errors) leaves (covariance^-1 + j j^T)^-1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import chi2, norm

Array = NDArray[np.float64]

#: of a number of which only the range is known, in shares of it
RANGE_VARIANCE = 1 / 12
#: of the intervals that are stated
CONFIDENCE = 0.9
#: standard errors to either side of it
REACH = float(norm.ppf(0.5 + 0.5 * CONFIDENCE))
#: shares by which the sensitivities are taken
DIFFERENCE = 5e-3
#: standard errors per share by which the first fit holds all shares at the middle of their ranges
PULL = 0.1
#: probability below which the model is said to miss the measurements
UNLIKELY = 0.01


@dataclass(frozen=True)
class Fit:
    """The shares found (n,), residuals (m,) in standard errors, and their sensitivities (m, n)."""

    shares: Array
    residuals: Array
    sensitivities: Array

    @property
    def covariance(self) -> Array:
        """Of the shares, no larger than that of the ranges."""
        s, directions = self._directions()
        variances = np.full(s.size, RANGE_VARIANCE)
        told = s * s > 1 / RANGE_VARIANCE
        variances[told] = 1 / s[told] ** 2
        return np.asarray((directions * variances) @ directions.T)

    def untold(self) -> list[Array]:
        """Directions in the shares about which the data say less than the ranges."""
        s, directions = self._directions()
        return [directions[:, k] for k in np.flatnonzero(s * s <= 1 / RANGE_VARIANCE)]

    def _directions(self) -> tuple[Array, Array]:
        """Information along each direction, as standard errors per share, and the directions in columns."""
        n = self.shares.size
        _, s, rows = np.linalg.svd(np.vstack((self.sensitivities, np.zeros((n, n)))), full_matrices=False)
        return s, rows.T

    @property
    def reaches(self) -> Array:
        """Half widths of the intervals, in shares."""
        return np.asarray(REACH * np.sqrt(np.diag(self.covariance)))

    @property
    def correlations(self) -> Array:
        """Of the shares."""
        error = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(error, error))

    @property
    def likelihood(self) -> float:
        """Probability of residuals at least this large by chance; 1 without more values than what was found."""
        spare = self.residuals.size - (self.shares.size - len(self.untold()))
        return float(chi2.sf(self.residuals @ self.residuals, spare)) if spare > 0 else 1.0


def fit(predict: Callable[[Array], Array], values: Array, sigmas: Array, count: int) -> Fit:
    """The ``count`` shares that predict the values best; what is not told stays at the middle of its range."""
    middle = np.full(count, 0.5)

    def solve(start: Array, held: Array) -> Fit:
        """From ``start``, with the shares held at the middle as far as the rows of ``held`` say."""

        def residuals(u: Array) -> Array:
            return np.concatenate(((predict(u) - values) / sigmas, held @ (u - middle)))

        def slopes(u: Array) -> Array:
            return np.vstack((sensitivities(predict, u) / sigmas[:, None], held))

        found = least_squares(residuals, start, slopes, (0.0, 1.0), xtol=1e-6, ftol=1e-8)
        return Fit(found.x, found.fun[: values.size], found.jac[: values.size])

    first = solve(middle, PULL * np.eye(count))
    if not (untold := first.untold()):
        return first
    return solve(np.clip(first.shares, 1e-3, 1 - 1e-3), np.array(untold) / np.sqrt(RANGE_VARIANCE))


def sensitivities(predict: Callable[[Array], Array], shares: Array) -> Array:
    """d(prediction)/d(share) by central differences within the ranges, (m, n)."""
    columns = []
    for k in range(shares.size):
        below, above = shares.copy(), shares.copy()
        below[k], above[k] = max(shares[k] - DIFFERENCE, 0.0), min(shares[k] + DIFFERENCE, 1.0)
        columns.append((predict(above) - predict(below)) / (above[k] - below[k]))
    return np.array(columns).T


def error_of(covariance: Array, gradient: Array) -> float:
    """Standard error of an output with this gradient."""
    return float(np.sqrt(gradient @ covariance @ gradient))


def with_measurement(covariance: Array, sensitivity: Array) -> Array:
    """The covariance that a further measurement leaves; ``sensitivity`` in its standard errors per share."""
    along = covariance @ sensitivity
    return np.asarray(covariance - np.outer(along, along) / (1 + sensitivity @ along))
