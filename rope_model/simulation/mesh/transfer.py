"""Transfer of nodal fields between meshes, and interpolation between nodes.

A transformation carries q, the velocities and the accelerations to new elements: the new fields are those nearest to
the old ones in the mean square along the rope.  So the momentum stays where two elements merge, except for the part
that the clamped ends take up.  Dropping the middle node alone would lose its excess over its neighbours: a blow to the
leg at every transformation.
"""

import numpy as np
from numpy.typing import NDArray

from rope_model.arrays import Array
from rope_model.numerics.banded import solve_banded
from rope_model.physics import hermite
from rope_model.physics.node import ANGLE

Indices = NDArray[np.intp]


def interpolate(x: Array, s: Array, at: Array) -> Array:
    """Interpolate values ``x`` (..., nodes, 7) at ``s`` (m) to the arc lengths ``at`` (m): (..., points, 7).

    r and its derivative r' are cubic Hermite, theta is linear.  At a node its values are returned to the bit.
    """
    i = _element_at(s, at)
    l, of_axis = s[i + 1] - s[i], np.moveaxis(x, -1, 0)
    nodes = (*of_axis[..., i], *of_axis[..., i + 1])
    y = np.stack(hermite.node_values(np.clip((at - s[i]) / l, 0.0, 1.0), l, nodes), axis=-1)
    nearest = np.where(at - s[i] < s[i + 1] - at, i, i + 1)
    same = np.abs(s[nearest] - at) <= _tolerance(s)
    y[..., same, :] = x[..., nearest[same], :]
    return y


def transfer_fields(fields: Array, old_s: Array, new_s: Array) -> Array:
    """Carry ``fields`` (number, old nodes, 7) from arc lengths ``old_s`` (m) to ``new_s``: (number, new nodes, 7).

    The ends of the rope keep their values; where no elements merge, so does every node that stays.
    """
    y = interpolate(fields, old_s, new_s)
    # both are polynomials between neighbours among all nodes, old and new
    knots = np.union1d(old_s, new_s)
    knots = knots[np.append(True, np.diff(knots) > _tolerance(old_s))]
    middle = 0.5 * (knots[:-1] + knots[1:])
    old, new = _element_at(old_s, middle), _element_at(new_s, middle)
    # a new element within an old one is exact
    merges = old_s[old] > new_s[new] + _tolerance(old_s)
    merges |= old_s[old + 1] < new_s[new + 1] - _tolerance(old_s)
    if not merges.any():
        return y
    old, new = old[merges], new[merges]
    elements = new_s[new], new_s[new + 1] - new_s[new], old_s[old], old_s[old + 1] - old_s[old]
    before, after = _element_values(fields, old), _element_values(y, new)
    load = np.array(
        hermite.missing_load(knots[:-1][merges], knots[1:][merges], *elements, before, after)
    )
    nodes, lengths = new_s.size, np.diff(new_s)
    # band, rows of a node, their columns, and their slice of the fields
    for band, rows, columns, part in (
        (_cubic_products(lengths), 2, 3, slice(0, 6)),
        (_linear_products(lengths), 1, 1, slice(ANGLE, None)),
    ):
        sums = np.zeros((rows * nodes, columns, len(fields)))
        own, load = np.split(load, [2 * rows * columns])
        for k, part_load in enumerate(own.reshape(2 * rows, columns, *own.shape[1:])):
            np.add.at(sums, rows * new + k, part_load.transpose(2, 0, 1))
        inner = slice(rows, -rows)
        change = solve_banded(band[inner], sums[inner].reshape(rows * (nodes - 2), -1))
        y[:, 1:-1, part] += change.reshape(nodes - 2, rows * columns, -1).transpose(2, 0, 1)
    return y


def _tolerance(s: Array) -> float:
    """Return the difference (m) below which two arc lengths are equal."""
    return 1e-9 * float(s[-1])


def _element_at(s: Array, at: Array) -> Indices:
    """Return the elements in which the arc lengths ``at`` lie."""
    return np.clip(np.searchsorted(s, at + _tolerance(s)) - 1, 0, s.size - 2)


def _element_values(fields: Array, elements: Indices) -> Array:
    """Return the values of both nodes of the elements (14, fields, elements)."""
    return np.concatenate((fields[:, elements], fields[:, elements + 1]), axis=2).transpose(2, 0, 1)


def _cubic_products(l: Array) -> Array:
    """Return the integrals of products of shape functions, as a band for solve_banded (2 nodes, 4)."""
    band = np.zeros((2 * l.size + 2, 4))
    products = iter(hermite.shape_products(l))
    for m in range(4):
        for k in range(m + 1):
            band[m - k : m - k + 2 * l.size : 2, k] += next(products)
    return band


def _linear_products(l: Array) -> Array:
    """Return the products for theta, as a band for solve_banded (nodes, 2)."""
    band = np.zeros((l.size + 1, 2))
    band[:-1, 0] += l / 3
    band[1:, 0] += l / 3
    band[:-1, 1] = l / 6
    return band
