"""Linear equations with a symmetric band."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def solve_banded(band: Array, b: Array) -> Array:
    """x of A x = b for a positive definite A: (rows, columns), as ``b``.

    ``band`` (rows, width + 1) holds the diagonal of A and the entries right of it, nearest first; what lies outside of
    A is not looked at.
    """
    rows, width = band.shape[0], band.shape[1] - 1
    band, x = band.copy(), b.copy()
    for i in range(rows):
        for k in range(1, min(width, rows - 1 - i) + 1):
            factor = band[i, k] / band[i, 0]
            band[i + k, : width + 1 - k] -= factor * band[i, k:]
            x[i + k] -= factor * x[i]
    for i in reversed(range(rows)):
        below = min(width, rows - 1 - i)
        x[i] = (x[i] - band[i, 1 : below + 1] @ x[i + 1 : i + below + 1]) / band[i, 0]
    return x
