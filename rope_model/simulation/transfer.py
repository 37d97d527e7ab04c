"""Nodal values between the nodes, and carried from one partition of the rope to another.

A transformation carries q, the velocities and the accelerations to those fields on the new elements that differ least
from the old ones in the mean square along the rope.  So the momentum stays where two elements merge, but for what the
clamped ends take up.  Dropping the middle node alone would lose what it had more than its neighbours: a blow to the
leg at every transformation.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

from .rope_system import ANGLE, POSITION, SLOPE, Array

Indices = NDArray[np.intp]

#: on [-1, 1]; exact for the product of two cubics
_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)


def interpolated(x: Array, s: Array, at: Array) -> Array:
    """What the elements between nodes at ``s`` (m) with the values ``x`` (nodes, 7) have at ``at`` (m): (places, 7).

    Cubic Hermite for r and, its derivative, r'; linear for theta.  A node's own place has its values to the bit.
    """
    i, xi, l = _within(s, at)
    xi, l = xi[:, None], l[:, None]
    r1, r2, d1, d2 = x[i, POSITION], x[i + 1, POSITION], l * x[i, SLOPE], l * x[i + 1, SLOPE]
    y = np.empty((at.size, x.shape[1]))
    y[:, POSITION] = r1 + xi**2 * (3 - 2 * xi) * (r2 - r1) + xi * (1 - xi) ** 2 * d1 + xi**2 * (xi - 1) * d2
    y[:, SLOPE] = (6 * xi * (1 - xi) * (r2 - r1) + (1 - xi) * (1 - 3 * xi) * d1 + xi * (3 * xi - 2) * d2) / l
    y[:, ANGLE] = (1 - xi[:, 0]) * x[i, ANGLE] + xi[:, 0] * x[i + 1, ANGLE]
    nearest = np.where(at - s[i] < s[i + 1] - at, i, i + 1)
    same = np.abs(s[nearest] - at) <= _tolerance(s)
    y[same] = x[nearest[same]]
    return y


def transferred(x: Array, old_s: Array, new_s: Array) -> Array:
    """Nodal values ``x`` (old nodes, 7) at arc lengths ``old_s`` (m), carried to the nodes at ``new_s``: (nodes, 7).

    The ends of the rope keep their values; without an element that merges, every node that stays does.
    """
    y = interpolated(x, old_s, new_s)
    knots = np.union1d(old_s, new_s)
    knots = knots[np.append(True, np.diff(knots) > _tolerance(old_s))]
    h = 0.5 * np.diff(knots)
    at = ((knots[:-1] + h)[:, None] + h[:, None] * _GAUSS_POINTS).ravel()
    weights = sp.diags_array((h[:, None] * _GAUSS_WEIGHTS).ravel())
    lost = interpolated(x, old_s, at) - interpolated(y, new_s, at)
    (old, _, _), (new, _, _) = _within(old_s, at), _within(new_s, at)
    # a new element that lies within an old one is the same
    starts, ends = old_s[old] - new_s[new], old_s[old + 1] - new_s[new + 1]
    lost[(starts <= _tolerance(old_s)) & (ends >= -_tolerance(old_s))] = 0.0
    if not lost.any():
        return y
    for basis, missing, columns in (
        (_cubic(new_s, at)[:, 2:-2], lost[:, POSITION], slice(ANGLE)),
        (_linear(new_s, at)[:, 1:-1], lost[:, ANGLE:], slice(ANGLE, None)),
    ):
        change = spsolve(sp.csc_array(basis.T @ weights @ basis), basis.T @ weights @ missing)
        y[1:-1, columns] += change.reshape(new_s.size - 2, -1)  # of r and then r' of every node, or of theta
    return y


def _tolerance(s: Array) -> float:
    """Within which two arc lengths are the same, m."""
    return 1e-9 * float(s[-1])


def _within(s: Array, at: Array) -> tuple[Indices, Array, Array]:
    """Elements in which ``at`` lies, place in them from 0 to 1, and their lengths."""
    i = np.clip(np.searchsorted(s, at + _tolerance(s)) - 1, 0, s.size - 2)
    l = s[i + 1] - s[i]
    return i, np.clip((at - s[i]) / l, 0.0, 1.0), l


def _cubic(s: Array, at: Array) -> sp.csc_array:
    """What the places ``at`` take of every node's r and r': (places, 2 nodes)."""
    i, xi, l = _within(s, at)
    shapes = (1 - xi**2 * (3 - 2 * xi), xi * (1 - xi) ** 2 * l, xi**2 * (3 - 2 * xi), xi**2 * (xi - 1) * l)
    return _shares(2 * i, shapes, 2 * s.size)


def _linear(s: Array, at: Array) -> sp.csc_array:
    """What the places ``at`` take of every node's theta: (places, nodes)."""
    i, xi, _ = _within(s, at)
    return _shares(i, (1 - xi, xi), s.size)


def _shares(first: Indices, shapes: tuple[Array, ...], size: int) -> sp.csc_array:
    rows, columns = np.tile(np.arange(first.size), len(shapes)), np.concatenate([first + k for k in range(len(shapes))])
    return sp.csc_array((np.concatenate(shapes), (rows, columns)), shape=(first.size, size))
