"""Linear equations with a symmetric band, against the full matrix."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rope_model.numerics.banded import solve_banded


@given(rows=st.integers(1, 30), width=st.integers(0, 4), columns=st.integers(1, 3), seed=st.integers(0, 1000))
@settings(max_examples=100, deadline=None)
def test_it_solves_what_the_full_matrix_solves(rows: int, width: int, columns: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    band = rng.normal(size=(rows, width + 1))
    band[:, 0] = 2 * (width + 1) * np.abs(band).max()  # dominant, so positive definite
    A = np.zeros((rows, rows))
    for i in range(rows):
        for k in range(min(width, rows - 1 - i) + 1):
            A[i, i + k] = A[i + k, i] = band[i, k]
    b, before = rng.normal(size=(rows, columns)), band.copy()
    np.testing.assert_allclose(A @ solve_banded(band, b), b, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(band, before)


def test_entries_beyond_the_matrix_are_not_looked_at() -> None:
    band = np.array([[2.0, 1.0], [2.0, np.nan]])
    assert solve_banded(band, np.array([[3.0], [3.0]])) == pytest.approx(np.ones((2, 1)))
