"""Nodal values between the nodes, and carried from one partition of the rope to another.

A transformation carries q, the velocities and the accelerations to those fields on the new elements that differ least
from the old ones in the mean square along the rope.  So the momentum stays where two elements merge, but for what the
clamped ends take up.  Dropping the middle node alone would lose what it had more than its neighbours: a blow to the
leg at every transformation.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..numerics.banded import solve_banded
from ..physics import hermite
from .rope_system import ANGLE, POSITION, SLOPE, Array

Indices = NDArray[np.intp]

#: on [-1, 1]; exact for the product of two cubics
_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)


def interpolate(x: Array, s: Array, at: Array) -> Array:
    """What the elements between nodes at ``s`` (m) with the values ``x`` (nodes, 7) have at ``at`` (m): (places, 7).

    Cubic Hermite for r and, its derivative, r'; linear for theta.  A node's own place has its values to the bit.
    """
    i, xi, l = _within(s, at)
    xi, l = xi[:, None], l[:, None]
    y = np.empty((at.size, x.shape[1]))
    nodes = x[i, POSITION], x[i, SLOPE], x[i + 1, POSITION], x[i + 1, SLOPE]
    y[:, POSITION], y[:, SLOPE] = hermite.interpolate(xi, l, *nodes)
    y[:, ANGLE] = (1 - xi[:, 0]) * x[i, ANGLE] + xi[:, 0] * x[i + 1, ANGLE]
    nearest = np.where(at - s[i] < s[i + 1] - at, i, i + 1)
    same = np.abs(s[nearest] - at) <= _tolerance(s)
    y[same] = x[nearest[same]]
    return y


def transfer_fields(fields: Array, old_s: Array, new_s: Array) -> Array:
    """``fields`` (number, old nodes, 7) at arc lengths ``old_s`` (m), carried to ``new_s``: (number, new nodes, 7).

    The ends of the rope keep their values; where no elements merge, every node that stays does.
    """
    y = np.array([interpolate(x, old_s, new_s) for x in fields])
    # between neighbours among all nodes, old and new, both are polynomials
    knots = np.union1d(old_s, new_s)
    knots = knots[np.append(True, np.diff(knots) > _tolerance(old_s))]
    middle = 0.5 * (knots[:-1] + knots[1:])
    (old, _, _), (new, _, _) = _within(old_s, middle), _within(new_s, middle)
    # a new element that lies within an old one is the same
    merges = old_s[old] > new_s[new] + _tolerance(old_s)
    merges |= old_s[old + 1] < new_s[new + 1] - _tolerance(old_s)
    if not merges.any():
        return y
    half = 0.5 * np.diff(knots)[merges, None]
    at, weights = (middle[merges, None] + half * _GAUSS_POINTS).ravel(), (half * _GAUSS_WEIGHTS).ravel()
    lost = np.array([interpolate(x, old_s, at) - interpolate(z, new_s, at) for x, z in zip(fields, y, strict=True)])
    e, xi, l = _within(new_s, at)
    nodes, lengths = new_s.size, np.diff(new_s)
    for band, shares, part, changed in (
        (_cubic_products(lengths), hermite.shares(xi, l), POSITION, slice(ANGLE)),
        (_linear_products(lengths), (1 - xi, xi), slice(ANGLE, None), slice(ANGLE, None)),
    ):
        rows = len(shares) // 2  # of a node
        load = np.zeros((rows * nodes, *lost[:, 0, part].shape))
        for k, share in enumerate(shares):
            np.add.at(load, rows * e + k, ((weights * share)[:, None] * lost[:, :, part]).swapaxes(0, 1))
        inner = slice(rows, -rows)
        change = solve_banded(band[inner], load[inner].reshape(rows * (nodes - 2), -1))
        of_fields = change.reshape(nodes - 2, rows, len(fields), -1).transpose(2, 0, 1, 3)
        y[:, 1:-1, changed] += of_fields.reshape(len(fields), nodes - 2, -1)
    return y


def _tolerance(s: Array) -> float:
    """Within which two arc lengths are the same, m."""
    return 1e-9 * float(s[-1])


def _within(s: Array, at: Array) -> tuple[Indices, Array, Array]:
    """Elements in which ``at`` lies, place in them from 0 to 1, and their lengths."""
    i = np.clip(np.searchsorted(s, at + _tolerance(s)) - 1, 0, s.size - 2)
    l = s[i + 1] - s[i]
    return i, np.clip((at - s[i]) / l, 0.0, 1.0), l


def _cubic_products(l: Array) -> Array:
    """Integrals of the products of hermite.shares over the elements, as banded.solved takes them: (2 nodes, 4)."""
    band = np.zeros((2 * l.size + 2, 4))
    products = iter(hermite.share_products(l))
    for m in range(4):
        for k in range(m + 1):
            band[m - k : m - k + 2 * l.size : 2, k] += next(products)
    return band


def _linear_products(l: Array) -> Array:
    """The same for theta: (nodes, 2)."""
    band = np.zeros((l.size + 1, 2))
    band[:-1, 0] += l / 3
    band[1:, 0] += l / 3
    band[:-1, 1] = l / 6
    return band
