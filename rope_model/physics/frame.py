"""Reference frame of the cross-section, and the twist it has of its own.

The angle theta of a cross-section is counted from the frame that the smallest rotation carries from a fixed unit
pole p to the tangent t.  Along the rope that frame turns about the tangent by

    twist = - p . (t x t') / (1 + p . t)           (per reference length; the same with t_t for the spin in time)

which is regular but where t = -p.  One pole serves the whole rope: the tangents of a rope trace a curve on the unit
sphere, so there is always a pole whose antipode that curve avoids.  ``best_pole`` finds it, ``pole_change_angle``
re-expresses theta from the old pole to the new.

Formulas take vectors with the components first: tuples, numpy arrays (3, n) or CasADi expressions.

The source measures theta from a frame built of Tait-Bryan angles Z-Y-X instead, singular at t parallel to Z: just
when the loop has yawed 90 degrees.  evidence.stability keeps it, to show it failing there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .elementary import atan2, cos, cross, dot, sin, sqrt

Array = NDArray[np.float64]

#: (pole, r', change of r') -> turning of the reference frame about the tangent, for the same change
FrameRate = Callable[[Any, Any, Any], Any]


def smallest_rotation_rate(p: Any, d: Any, change: Any) -> Any:
    """Turning of the smallest-rotation frame about the tangent while r' = ``d`` changes at rate ``change``."""
    length = sqrt(dot(d, d))
    return -dot(p, cross(d, change)) / (length * (length + p[0] * d[0] + p[1] * d[1] + p[2] * d[2]))


def pole_change_area(p_old: Any, p_new: Any, t: Any) -> Any:
    """Signed area of the spherical triangle (p_new, p_old, t), rad."""
    return 2.0 * atan2(dot(t, cross(p_new, p_old)), 1.0 + dot(p_old, p_new) + dot(t, p_old) + dot(t, p_new))


def pole_change_angle(p_old: Array, p_new: Array, t: Array) -> Array:
    """Angle (rad), shape (n,), to add to theta where the tangent is ``t`` (n, 3) when the pole changes.

    It is the area of the triangle of the poles and t, and is continuous along the rope.
    """
    return np.unwrap(pole_change_area(p_old, p_new, t.T), period=4.0 * np.pi)


def end_moment(p: Any, d: Any, f: Any, torque: Any) -> tuple[Any, Any, Any]:
    """Moment (N m) of the conveyance on the rope's end, from the reaction ``f`` to r' = ``d`` and the torque.

    theta is counted from a frame that turns when the tangent tilts, so the reaction to r' at fixed theta holds a
    part of the torque, which the last term gives back.
    """
    length = sqrt(dot(d, d))
    t = d[0] / length, d[1] / length, d[2] / length
    along = dot(p, t)
    x, y, z = (
        m + torque * (t_k + (p_k - t_k * along) / (1 + along)) for m, t_k, p_k in zip(cross(d, f), t, p, strict=True)
    )
    return x, y, z


def pole_margin(p: Array, t: Array) -> float:
    """Smallest 1 + p . t over the tangents ``t`` (n, 3): 0 is singular, 1 and more is comfortable."""
    return float(1.0 + np.min(t @ p))


def spread_over_sphere(k: Any, number: Any) -> tuple[Any, Any, Any]:
    """The unit vector of place ``k`` = 1/2, 3/2 ... of ``number`` that are spread evenly over the sphere."""
    z = 1.0 - 2.0 * k / number
    azimuth = k * math.pi * (3.0 - math.sqrt(5.0))
    radius = sqrt(1.0 - z * z)
    return radius * cos(azimuth), z, radius * sin(azimuth)


def best_pole(t: Array, candidates: int = 800) -> Array:
    """The unit vector (3,) of a fixed, even spread over the sphere with the largest margin to tangents ``t``."""
    poles = np.column_stack(spread_over_sphere(np.arange(candidates) + 0.5, candidates))
    best: Array = poles[np.argmax(np.min(poles @ t.T, axis=1))]
    return best
