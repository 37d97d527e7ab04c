"""Geometry of the rope's centre line: where it is sampled, and how far points are from it.

Works on numbers, numpy arrays and CasADi expressions; vectors have their components first.
"""

from __future__ import annotations

from typing import Any

from .elementary import dot, larger, smaller


def suspension_points(layout: Any, left: Any, right: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """(2, 3): where ends are whose motions count from their nominal points."""
    half = 0.5 * layout.spacing
    return (-half + left.x, left.y, left.z), (half + right.x, right.y, right.z)


def place(bottom: Any, reach: Any, part: Any, loop: Any) -> Any:
    """Arc length (m) of the sample at ``part`` from 0 to 1 of the ``reach`` from ``bottom`` to an end of the rope.

    Around the bottom the samples stand as densely as if they had the width of the ``loop`` (m) twice to share, however
    deep the legs hang; from there their distance grows.
    """
    even = smaller(2.0 * loop / larger(abs(reach), loop), 1.0)
    return bottom + reach * (even * part + (1.0 - even) * part**4)


def squared_distance(point: Any, start: Any, along: Any) -> Any:
    """Square (m^2) of the distance of ``point`` from the straight piece from ``start`` to ``start`` + ``along``."""
    across = point[0] - start[0], point[1] - start[1], point[2] - start[2]
    part = smaller(larger(dot(across, along) / dot(along, along), 0.0), 1.0)
    x, y, z = across[0] - part * along[0], across[1] - part * along[1], across[2] - part * along[2]
    return x * x + y * y + z * z
