"""Motions of the ends as Exudyn's user functions, of arithmetic that it can evaluate itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import exudyn as exu
import numpy as np

from hoist_demo.control.trajectory import Trajectory


def s_curve(reference: Trajectory, sense: float, symbolic: bool) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Offset and its rate, as Exudyn's user functions: each change of the jerk adds a truncated cubic."""
    jerks = np.array([p.jerk for p in reference.points])
    terms = [(float(t), sense * float(j)) for t, j in zip(reference.starts, np.diff(jerks, prepend=0.0), strict=True)]
    largest = exu.symbolic.max if symbolic else max

    def offset(mbs: Any, t: Any, item: Any, start: Any) -> Any:
        y = start
        for begin, jerk in terms:
            since = largest(t - begin, 0.0)
            y = y + jerk / 6 * since * since * since
        return y

    def rate(mbs: Any, t: Any, item: Any, start: Any) -> Any:
        v = 0.0 * t
        for begin, jerk in terms:
            since = largest(t - begin, 0.0)
            v = v + jerk / 2 * since * since
        return v

    return offset, rate


def swing(amplitude: float, duration: float) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """A sin^4(pi t/T) until T, and its rate."""
    w, least = float(np.pi / duration), exu.symbolic.min

    def offset(mbs: Any, t: Any, item: Any, start: Any) -> Any:
        x = exu.symbolic.sin(w * least(t, duration))
        return start + amplitude * x * x * x * x

    def rate(mbs: Any, t: Any, item: Any, start: Any) -> Any:
        s = w * least(t, duration)
        x = exu.symbolic.sin(s)
        return 4 * amplitude * w * x * x * x * exu.symbolic.cos(s)

    return offset, rate
