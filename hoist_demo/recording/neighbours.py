"""Smallest distance between the recorded shapes of neighbouring ropes, with time and place.

Shapes are chains of straight sides through points of the rope. Two sides p + a d, q + b e, a and b within 0 and 1, are
nearest where both derivatives vanish, or at a bound (C. Ericson, Real-Time Collision Detection, 2005,
section 5.1.9). An arc of the radius r cut short by a side of the length l is missed by l^2 / (8 r) at most.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hoist_demo.recording.time_series import Array


@dataclass(frozen=True)
class Nearest:
    """The smallest distance of two ropes in a run."""

    clearance: float  # m, between their surfaces
    t: float  # s
    place: tuple[float, float, float]  # m, half-way between both


NEVER = Nearest(np.nan, np.nan, (np.nan, np.nan, np.nan))
"""Of ropes that have no shapes to compare."""


def nearest(times: Array, one: Array, other: Array, radii: float) -> Nearest:
    """Return the nearest approach of two ropes: points (instants, points, 3) [m], and the sum of their radii [m]."""
    found = Nearest(np.inf, float(times[0]), (np.nan, np.nan, np.nan))
    for k, t in enumerate(times):
        distance, place = polygon_distance(one[k], other[k])
        if distance - radii < found.clearance:
            x, y, z = place.tolist()
            found = Nearest(distance - radii, float(t), (x, y, z))
    return found


def polygon_distance(one: Array, other: Array) -> tuple[float, Array]:
    """Smallest distance of two chains of straight sides through points (n, 3), and the place half-way [m]."""
    p, d = one[:-1, None], np.diff(one, axis=0)[:, None]
    q, e = other[None, :-1], np.diff(other, axis=0)[None]
    r = p - q
    dd, ee, de = (d * d).sum(-1), (e * e).sum(-1), (d * e).sum(-1)
    dr, er = (d * r).sum(-1), (e * r).sum(-1)
    across = dd * ee - de * de
    # parallel sides are nearest at an end, too
    a = np.where(across > 1e-12 * dd * ee, (de * er - dr * ee) / np.where(across > 0.0, across, 1.0), 0.0)
    b = np.clip((de * np.clip(a, 0.0, 1.0) + er) / ee, 0.0, 1.0)
    a = np.clip((de * b - dr) / dd, 0.0, 1.0)
    gap = r + a[..., None] * d - b[..., None] * e
    distance = np.linalg.norm(gap, axis=-1)
    k = np.unravel_index(np.argmin(distance), distance.shape)
    at = (p + a[..., None] * d)[k] - 0.5 * gap[k]
    return float(distance[k]), at
