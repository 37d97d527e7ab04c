"""Bending along the rope, from the curve that is recorded.

The rope's outputs tell its largest bending stress only. Its curvature follows from three neighbouring points of the
recorded curve (Menger), kappa = 2 sin(angle between the chords) / distance of the outer points. It is proportional to
the nominal bending stress. The points are dense around the loop; the bend at a clamped end, some 0.2 m long, lies
between the outermost points and is not seen.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SPREAD = 0.05
"""How uneven the ratio of largest stress and largest curvature may be, range over median; 0.01 with rope-120."""


def curvature(curve: Array) -> Array:
    """Curvature [1/m] at the points of a curve of shape (n, 3) [m]; zero at its two ends."""
    before, after, across = curve[1:-1] - curve[:-2], curve[2:] - curve[1:-1], curve[2:] - curve[:-2]
    product = np.prod([np.linalg.norm(side, axis=1) for side in (before, after, across)], axis=0)
    twice_area = np.linalg.norm(np.cross(before, after), axis=1)
    inner = np.divide(2.0 * twice_area, product, out=np.zeros_like(product), where=product > 0.0)
    return np.concatenate([[0.0], inner, [0.0]])


def arc_length(curve: Array) -> Array:
    """Length along a curve of shape (n, 3) from its first point [m]."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])


def curvature_map(curves: Array, rows: int) -> tuple[Array, float]:
    """Curvature [1/m] of curves (frames, n, 3) over even arc lengths, shape (rows, frames), and the full length [m]."""
    length = max(float(arc_length(curve)[-1]) for curve in curves)
    places = (np.arange(rows) + 0.5) * length / rows
    columns = [np.interp(places, arc_length(curve), curvature(curve)) for curve in curves]
    return np.array(columns).T, length


def stress_per_curvature(stress_max: Array, curvature_max: Array) -> float | None:
    """Factor [Pa m] that turns curvature into nominal stress, 32 EI / (pi d^3), from both maxima at many instants.

    None unless their ratio is even within SPREAD: then the largest bend lies where the points do not see it.
    """
    if not bool(np.all(curvature_max > 0.0) and np.all(np.isfinite(stress_max))):
        return None
    ratio = stress_max / curvature_max
    factor = float(np.median(ratio))
    return factor if float(np.ptp(ratio)) <= SPREAD * factor else None
