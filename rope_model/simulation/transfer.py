"""Nodal values carried from one partition of the rope to another.

A new node takes what the old elements interpolate at its place: cubic Hermite for r (and r' from it), linear for
theta.  So a node that stays keeps its values to the bit, an element that splits is reproduced exactly, and where two
elements merge the middle node is dropped.  Velocities and accelerations are carried in the same way.
"""

from __future__ import annotations

import numpy as np

from .rope_system import ANGLE, POSITION, SLOPE, Array


def transferred(x: Array, old_s: Array, new_s: Array) -> Array:
    """Values ``x`` (old nodes, 7) at arc lengths ``old_s``, carried to the nodes at ``new_s``: (new nodes, 7)."""
    tolerance = 1e-9 * old_s[-1]
    i = np.clip(np.searchsorted(old_s, new_s + tolerance) - 1, 0, old_s.size - 2)
    l = (old_s[i + 1] - old_s[i])[:, None]
    xi = np.clip((new_s - old_s[i])[:, None] / l, 0.0, 1.0)
    r1, r2, d1, d2 = x[i, POSITION], x[i + 1, POSITION], l * x[i, SLOPE], l * x[i + 1, SLOPE]
    y = np.empty((new_s.size, x.shape[1]))
    y[:, POSITION] = r1 + xi**2 * (3 - 2 * xi) * (r2 - r1) + xi * (1 - xi) ** 2 * d1 + xi**2 * (xi - 1) * d2
    y[:, SLOPE] = (6 * xi * (1 - xi) * (r2 - r1) + (1 - xi) * (1 - 3 * xi) * d1 + xi * (3 * xi - 2) * d2) / l
    y[:, ANGLE] = (1 - xi[:, 0]) * x[i, ANGLE] + xi[:, 0] * x[i + 1, ANGLE]
    # nodes that stay keep their values exactly
    nearest = np.where(new_s - old_s[i] < old_s[i + 1] - new_s, i, i + 1)
    same = np.abs(old_s[nearest] - new_s) <= tolerance
    y[same] = x[nearest[same]]
    return y
