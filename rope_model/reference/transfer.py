"""Interpolation between nodes, and the transfer of fields to a new mesh.

A transformation replaces each field u of the nodes by the nearest one on the new mesh,

    min over w of  int |w - u|^2 ds             (docs/theory/mesh.md, eq-transfer)

where r is a cubic between nodes and theta is linear.  The ends of the rope keep their values.  So
the momentum stays where elements merge, except for what the held ends take up; elements that split
represent the same field.
"""

import numpy as np
from numpy.typing import NDArray

from rope_model.arrays import Array
from rope_model.physics.hermite import GAUSS, shape_functions
from rope_model.physics.node import ANGLE, POSITION, SLOPE


def interpolated(x: Array, s: Array, at: Array) -> Array:
    """Return r (points, 3), or its rate, at arc lengths ``at`` (m) between nodes at ``s``."""
    return _cubic_shapes(s, at) @ _cubic_values(x)


def transferred(fields: Array, old_s: Array, new_s: Array) -> Array:
    """Return ``fields`` (number, nodes, 7) of nodes at ``old_s`` (m) on nodes at ``new_s`` (m)."""
    knots = np.union1d(old_s, new_s)  # all fields are polynomials between neighbours of these
    pieces = np.diff(knots)
    points = np.array([knots[:-1] + xi * pieces for xi, _ in GAUSS]).ravel()
    weights = np.sqrt(np.array([weight * pieces for _, weight in GAUSS]).ravel())[:, None]
    old_cubic = _cubic_shapes(old_s, points)
    new_cubic = _cubic_shapes(new_s, points)
    old_linear = _linear_shapes(old_s, points)
    new_linear = _linear_shapes(new_s, points)

    new = np.zeros((len(fields), new_s.size, fields.shape[2]))
    new[:, [0, -1]] = fields[:, [0, -1]]
    # the fields are columns side by side: one search for all of them
    old_r = np.hstack([_cubic_values(x) for x in fields])
    new_r = np.hstack([_cubic_values(x) for x in new])
    missing = old_cubic @ old_r - new_cubic @ new_r
    inner = np.linalg.lstsq(weights * new_cubic[:, 2:-2], weights * missing)[0]
    for k, new_x in enumerate(new):
        new_x[1:-1, POSITION] = inner[0::2, 3 * k : 3 * k + 3]
        new_x[1:-1, SLOPE] = inner[1::2, 3 * k : 3 * k + 3]
    missing = old_linear @ fields[:, :, ANGLE].T - new_linear @ new[:, :, ANGLE].T
    inner = np.linalg.lstsq(weights * new_linear[:, 1:-1], weights * missing)[0]
    new[:, 1:-1, ANGLE] = inner.T
    return new


def elements_at(s: Array, at: Array) -> NDArray[np.intp]:
    """Return the elements between nodes at ``s`` in which the arc lengths ``at`` lie."""
    return np.clip(np.searchsorted(s, at, side="right") - 1, 0, s.size - 2)


def _cubic_values(x: Array) -> Array:
    """Return r and r' of each node in turn (2 nodes, 3)."""
    return np.stack((x[:, POSITION], x[:, SLOPE]), axis=1).reshape(-1, 3)


def _cubic_shapes(s: Array, at: Array) -> Array:
    """Return the shape functions of r and r' of each node (points, 2 nodes)."""
    element = elements_at(s, at)
    l = s[element + 1] - s[element]
    shapes = np.zeros((at.size, 2 * s.size))
    points = np.arange(at.size)
    for k, values in enumerate(shape_functions((at - s[element]) / l, l)):
        shapes[points, 2 * element + k] = values
    return shapes


def _linear_shapes(s: Array, at: Array) -> Array:
    """Return the shape functions of theta of each node (points, nodes)."""
    element = elements_at(s, at)
    xi = (at - s[element]) / (s[element + 1] - s[element])
    shapes = np.zeros((at.size, s.size))
    points = np.arange(at.size)
    shapes[points, element] = 1 - xi
    shapes[points, element + 1] = xi
    return shapes
