"""Modes of a large sparse model in a band of frequencies, by shift and invert.

The eigenvalues of K x = lambda M x below a shift are counted by the signs of the pivots of K - shift M (Sylvester's law
of inertia). The band is halved until each part has few; ARPACK finds those of a part around its middle, and their
number must be the counted one: equal ropes have equal modes, of which an iteration may miss some.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh, splu

from rope_model.arrays import Array

BandProgress = Callable[[float], None]  #: Hears which part of the band is done.
#: Modes that one run of ARPACK finds: more take longer each, fewer need more factorisations.
MAX_MODES_PER_RUN = 40
#: First lower bound of the eigenvalues [1/s^2], below the rounding of motions without stiffness.
_BEGIN = -0.1
_LOWER = 16.0  #: Factor by which the lower bound sinks while eigenvalues are below it.
_NUDGE = 1e-7  #: Relative change of a shift that is an eigenvalue.
_TRIES = 6  #: Shifts that are tried, and runs of ARPACK for one part.
_BASIS = 2.0  #: ARPACK's vectors over the modes that it finds, at first.


@dataclass(frozen=True)
class _Shifted:
    """Factors of K - shift M."""

    shift: float
    below: int  # number of eigenvalues below the shift
    solve: Callable[[Array], Array]


def sparse_modes(
    K: sp.csc_matrix, M: sp.csc_matrix, highest: float, progress: BandProgress
) -> tuple[Array, Array]:
    """Return ascending eigenvalues up to ``highest`` [1/s^2], and vectors (n, modes) of unit mass.

    Raises RuntimeError, with the band, where ARPACK does not find all that are there.
    """
    bottom = _factorised(K, M, _BEGIN)
    while bottom.below:
        bottom = _factorised(K, M, _LOWER * bottom.shift)
    top = _factorised(K, M, highest)
    if top.below == 0:
        return np.zeros(0), np.zeros((K.shape[0], 0))
    parts: list[tuple[Array, Array]] = []
    waiting = [(bottom, top)]
    while waiting:
        low, high = waiting.pop()
        count = high.below - low.below
        if count > MAX_MODES_PER_RUN:
            # modes lie evenly over the frequency
            roots = [np.sqrt(max(one.shift, 0.0)) for one in (low, high)]
            middle = _factorised(K, M, float(np.mean(roots)) ** 2)
            waiting += [(middle, high), (low, middle)]
        elif count:
            parts.append(_part(K, M, low, high))
        if count <= MAX_MODES_PER_RUN:
            progress(high.below / top.below)
    values = np.concatenate([part for part, _ in parts])
    vectors = np.hstack([part for _, part in parts])
    order = np.argsort(values)
    return values[order], vectors[:, order]


def _part(K: sp.csc_matrix, M: sp.csc_matrix, low: _Shifted, high: _Shifted) -> tuple[Array, Array]:
    """Return the eigenvalues between two shifts and their vectors of unit mass."""
    count = high.below - low.below
    at = _factorised(K, M, 0.5 * (low.shift + high.shift))
    inverse = LinearOperator(K.shape, at.solve, dtype=np.float64)
    random = np.random.default_rng(count)
    found = 0
    for k in range(_TRIES):
        wanted = min(count + 2 + k * count, K.shape[0] - 1)
        vectors = min(round(_BASIS * wanted) + 20, K.shape[0])
        start = random.standard_normal(K.shape[0])
        try:
            values, shapes = eigsh(
                K,
                wanted,
                M,
                sigma=at.shift,
                which="LM",
                ncv=vectors,
                v0=start,
                OPinv=inverse,
                tol=1e-8,
            )
        except ArpackNoConvergence as error:
            values = error.eigenvalues
            shapes = error.eigenvectors
        inside = (low.shift < values) & (values <= high.shift)
        found = int(np.count_nonzero(inside))
        if found == count:
            return values[inside], shapes[:, inside]
    edges = " to ".join(f"{np.sqrt(max(one.shift, 0.0)) / (2 * np.pi):.4g}" for one in (low, high))
    raise RuntimeError(
        f"of {count} modes within {edges} Hz only {found} are found: choose another --band or --at"
    )


def _factorised(K: sp.csc_matrix, M: sp.csc_matrix, shift: float) -> _Shifted:
    """Factorise K - shift M without exchange of rows, so that the pivots' signs count; RuntimeError where none fits."""
    for k in range(_TRIES):
        near = shift * (1.0 + k * _NUDGE)
        try:
            factors = splu(
                (K - near * M).tocsc(),
                "MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError:  # singular: the shift is an eigenvalue
            continue
        if np.array_equal(factors.perm_r, factors.perm_c):
            return _Shifted(near, int(np.count_nonzero(factors.U.diagonal() < 0.0)), factors.solve)
    raise RuntimeError(
        f"the model at {shift:.6g} 1/s^2 has no factors with pivots on the diagonal: change --band"
    )
