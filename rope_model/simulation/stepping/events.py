"""Instant at which a function of time first leaves the negative side."""

from __future__ import annotations

from collections.abc import Callable

from rope_model.simulation.stepping.bracket import Bracket, narrowed, trial_place


def locate(f: Callable[[float], float], low: float, high: float, f_low: float, f_high: float, width: float) -> float:
    """The right end of an interval in which ``f`` goes from negative to not negative, not wider than ``width``.

    ``f_low`` < 0 <= ``f_high`` are the values at the ends.  Neighbouring numbers may be further apart
    than ``width``; then they are the interval.
    """
    at = Bracket(low, high, f_low, f_high, 0.0, 0.0)
    while at.high - at.low > width:
        x = trial_place(at, width)
        if not at.low < x < at.high:
            break
        at = narrowed(at, x, f(x))
    return at.high
