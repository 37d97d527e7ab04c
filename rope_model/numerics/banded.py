"""Direct solver for symmetric positive definite band matrices."""

import numpy as np

from rope_model.arrays import Array


def solve_banded(band: Array, b: Array) -> Array:
    """Solve A x = b for all columns of b (rows, columns).

    ``band`` (rows, width + 1) contains the diagonal of A and the entries right of it, nearest first; entries outside of
    A are not read.
    """
    rows, width = band.shape[0], band.shape[1] - 1
    rest, x = band.tolist(), b.copy()
    factors = np.zeros((rows, width, 1))
    # plain numbers are faster than arrays as short as the band
    for i, row in enumerate(rest):
        for k in range(1, min(width, rows - 1 - i) + 1):
            factors[i, k - 1] = factor = row[k] / row[0]
            below = rest[i + k]
            for j in range(width + 1 - k):
                below[j] -= factor * row[j + k]
        x[i + 1 : i + 1 + width] -= factors[i, : rows - 1 - i] * x[i]
    band = np.array(rest)
    for i in reversed(range(rows)):
        below = min(width, rows - 1 - i)
        x[i] = (x[i] - band[i, 1 : below + 1] @ x[i + 1 : i + below + 1]) / band[i, 0]
    return x
