"""Reference frame of the cross-section, and the twist it has of its own.

The angle theta of a cross-section is counted from the frame that the smallest rotation carries from a fixed unit
pole p to the tangent t.  Along the rope that frame turns about the tangent by

    twist = - p . (t x t') / (1 + p . t)           (per reference length; the same with t_t for the spin in time)

which is regular but where t = -p.  One pole serves the whole rope: the tangents of a rope trace a curve on the unit
sphere, so there is always a pole whose antipode that curve avoids.  ``best_pole`` finds it, ``pole_change_angle``
re-expresses theta from the old pole to the new.

The source measures theta from a frame built of Tait-Bryan angles Z-Y-X instead, singular at t parallel to Z: just
when the loop has yawed 90 degrees.  benchmarks.stability keeps it, to show it failing there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: (pole, r', change of r') -> turning of the reference frame about the tangent, for the same change
FrameRate = Callable[[Any, Any, Any], Any]


def smallest_rotation_rate(p: Any, d: Any, change: Any) -> Any:
    """Turning of the smallest-rotation frame about the tangent while r' = ``d`` changes at rate ``change``.

    Components come first: CasADi vectors (3,) or numpy arrays (3, n).
    """
    length = (d[0] ** 2 + d[1] ** 2 + d[2] ** 2) ** 0.5
    triple = (
        p[0] * (d[1] * change[2] - d[2] * change[1])
        + p[1] * (d[2] * change[0] - d[0] * change[2])
        + p[2] * (d[0] * change[1] - d[1] * change[0])
    )
    return -triple / (length * (length + p[0] * d[0] + p[1] * d[1] + p[2] * d[2]))


def pole_change_angle(p_old: Array, p_new: Array, t: Array) -> Array:
    """Angle (rad), shape (n,), to add to theta where the tangent is ``t`` (n, 3) when the pole changes.

    It is the signed area of the spherical triangle (p_new, p_old, t) and is continuous along the rope.
    """
    triple = t @ np.cross(p_new, p_old)
    angle = 2.0 * np.arctan2(triple, 1.0 + p_old @ p_new + t @ p_old + t @ p_new)
    return np.unwrap(angle, period=4.0 * np.pi)


def pole_margin(p: Array, t: Array) -> float:
    """Smallest 1 + p . t over the tangents ``t`` (n, 3): 0 is singular, 1 and more is comfortable."""
    return float(1.0 + np.min(t @ p))


def best_pole(t: Array, candidates: int = 800) -> Array:
    """The unit vector (3,) of a fixed, even spread over the sphere with the largest margin to tangents ``t``."""
    k = np.arange(candidates) + 0.5
    z = 1.0 - 2.0 * k / candidates
    azimuth = k * np.pi * (3.0 - np.sqrt(5.0))
    radius = np.sqrt(1.0 - z * z)
    poles = np.column_stack((radius * np.cos(azimuth), z, radius * np.sin(azimuth)))
    best: Array = poles[np.argmax(np.min(poles @ t.T, axis=1))]
    return best
