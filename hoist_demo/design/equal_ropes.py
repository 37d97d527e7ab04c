"""Modes and responses of a model some of whose ropes are equal, from problems with one rope of each kind.

Equal ropes couple with the hoist alone, and in the same way. The coordinates of n of them are replaced by their mean
times sqrt(n) and by n - 1 differences, which are orthogonal. K and M then fall apart: into the model with one rope,
whose coupling is sqrt(n) times as strong, and n - 1 times into the same rope between ends that do not move.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from scipy.linalg import null_space

from rope_model.arrays import Array

#: Eigenvalues in ascending order, and vectors (coordinates, modes) of unit mass.
Eigenpairs = tuple[Array, Array]
Eigensolver = Callable[[sp.csc_matrix, sp.csc_matrix], Eigenpairs]


def equal_ropes(names: Sequence[str], matrices: Sequence[sp.csc_matrix]) -> list[list[range]]:
    """Return the coordinates of ropes that are equal to the bit in all matrices, in groups of two or more ropes."""
    groups: list[list[range]] = []
    for rope in _ropes(names):
        for group in groups:
            if all(_are_alike(A, group[0], rope) for A in matrices):
                group.append(rope)
                break
        else:
            groups.append([rope])
    return [group for group in groups if len(group) > 1]


def modes_of_fewer(
    K: sp.csc_matrix, M: sp.csc_matrix, groups: Sequence[Sequence[range]], solve: Eigensolver
) -> Eigenpairs:
    """Return the modes that ``solve`` finds; those of equal ropes follow from one of them."""
    merged = merged_coordinates(K.shape[0], groups)
    squares, shapes = solve((merged.T @ K @ merged).tocsc(), (merged.T @ M @ merged).tocsc())
    all_squares = [squares]
    all_shapes = [merged @ shapes]
    for group in groups:
        first = group[0]
        squares, shapes = solve(_block(K, first), _block(M, first))
        differences = null_space(np.ones((1, len(group))))
        for weights in differences.T:
            moved = np.zeros((K.shape[0], squares.size))
            for rope, weight in zip(group, weights, strict=True):
                moved[rope.start : rope.stop] = weight * shapes
            all_squares.append(squares)
            all_shapes.append(moved)
    values = np.concatenate(all_squares)
    order = np.argsort(values, kind="stable")
    return values[order], np.hstack(all_shapes)[:, order]


def _ropes(names: Sequence[str]) -> list[range]:
    """Return the coordinates of each rope: those whose names begin alike, but for node and direction."""
    begins = [name.rsplit(".", 2)[0] if name.startswith("rope.") else "" for name in names]
    changes = (k for k in range(1, len(begins)) if begins[k] != begins[k - 1])
    pieces = pairwise([0, *changes, len(begins)])
    return [range(start, stop) for start, stop in pieces if begins[start]]


def _block(A: sp.csc_matrix, rope: range) -> sp.csc_matrix:
    return A[rope.start : rope.stop, rope.start : rope.stop].tocsc()


def _are_alike(A: sp.csc_matrix, one: range, other: range) -> bool:
    """Return True if two ropes have the same matrix and the same coupling with all else."""
    if len(one) != len(other):
        return False
    outside = np.ones(A.shape[0], dtype=bool)
    outside[[*one, *other]] = False
    columns = A[:, outside]
    unequal = _block(A, one) != _block(A, other)
    coupling = columns[[*one]] != columns[[*other]]
    between = A[one.start : one.stop, other.start : other.stop]
    return not (unequal.nnz or coupling.nnz or between.nnz)


def merged_coordinates(size: int, groups: Sequence[Sequence[range]]) -> sp.csc_matrix:
    """Return all coordinates by those of the model with one rope of each group, as columns of unit length.

    Equal ropes move alike.
    """
    factor = np.ones(size)
    column = np.arange(size)
    kept = np.ones(size, dtype=bool)
    for group in groups:
        for rope in group:
            factor[rope.start : rope.stop] = 1.0 / np.sqrt(len(group))
            column[rope.start : rope.stop] = column[group[0].start : group[0].stop]
        for rope in group[1:]:
            kept[rope.start : rope.stop] = False
    place = np.cumsum(kept) - 1
    entries = (factor, (np.arange(size), place[column]))
    return sp.csc_matrix(entries, shape=(size, int(kept.sum())))
