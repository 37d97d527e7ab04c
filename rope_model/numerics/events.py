"""Where a function of time first leaves the negative side."""

from __future__ import annotations

import math
from collections.abc import Callable


def locate(f: Callable[[float], float], low: float, high: float, f_low: float, f_high: float, width: float) -> float:
    """The right end of an interval in which ``f`` goes from negative to not negative, not wider than ``width``.

    ``f_low`` < 0 <= ``f_high`` are the values at the ends.  Neighbouring numbers may be further apart
    than ``width``; then they are the interval.  Regula falsi with the Illinois modification, and a
    bisection whenever that does not halve the interval twice in a row, or a value is infinite (f may be kinked).
    """
    side, stalled = 0, 0
    while high - low > width:
        before = high - low
        if stalled >= 2 or not math.isfinite(f_low - f_high) or f_high <= f_low:
            x, stalled = 0.5 * (low + high), 0
        else:
            x = low + (high - low) * f_low / (f_low - f_high)
            x = min(max(x, low + 0.4 * width), high - 0.4 * width)
        if not low < x < high:
            x = 0.5 * (low + high)
        if not low < x < high:  # there is no number between them
            break
        value = f(x)
        if value < 0:
            low, f_low = x, value
            f_high = 0.5 * f_high if side < 0 else f_high
            side = -1
        else:
            high, f_high = x, value
            f_low = 0.5 * f_low if side > 0 else f_low
            side = 1
        stalled = stalled + 1 if high - low > 0.5 * before else 0
    return high
