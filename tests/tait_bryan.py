"""The source's frame of the section, kept to show where it fails."""

from __future__ import annotations

from typing import Any


def tait_bryan_rate(p: Any, d: Any, change: Any) -> Any:
    """Turning of the Z-Y-X frame about the tangent while r' = ``d`` changes; singular at r' parallel to Z.

    A physics.frame.FrameRate; the pole is not used.
    """
    length = (d[0] ** 2 + d[1] ** 2 + d[2] ** 2) ** 0.5
    return d[2] * (d[0] * change[1] - d[1] * change[0]) / ((d[0] ** 2 + d[1] ** 2) * length)
