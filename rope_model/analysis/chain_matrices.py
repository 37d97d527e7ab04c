"""Sparse matrices of a chain of elements, whose nodes couple with their neighbours only."""

import numpy as np
import scipy.sparse as sp

from rope_model.arrays import Array


def of_elements(parts: Array, elements: int) -> sp.csc_matrix:
    """Return the sum of the elements' matrices, which CasADi's ``map`` puts side by side (2 dof, 2 dof elements)."""
    both = parts.shape[0]
    dof = both // 2
    blocks = parts.reshape(both, elements, both).transpose(1, 0, 2)
    local = dof * np.arange(elements)[:, None] + np.arange(both)
    rows = np.broadcast_to(local[:, :, None], blocks.shape)
    columns = np.broadcast_to(local[:, None, :], blocks.shape)
    size = dof * (elements + 1)
    entries = (blocks.ravel(), (rows.ravel(), columns.ravel()))
    return sp.csc_matrix(entries, shape=(size, size))


def of_blocks(nodes: Array, following: Array) -> sp.csc_matrix:
    """Return a symmetric matrix of the blocks (nodes, dof, dof) on its diagonal and those right of it."""
    count = len(nodes)
    diagonal = sp.bsr_matrix((nodes, np.arange(count), np.arange(count + 1)))
    begins = np.append(np.arange(count), count - 1)
    right = sp.bsr_matrix((following, np.arange(1, count), begins), shape=diagonal.shape)
    return (diagonal + right + right.T).tocsc()
