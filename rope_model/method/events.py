"""Location of an event within a step: a bracket that a safeguarded secant narrows."""

import math
from typing import NamedTuple

from rope_model.physics.elementary import Scalar, logical_and, maximum, minimum, where


class Bracket(NamedTuple):
    """Interval, and the values at its ends, f_low < 0 <= f_high.

    ``side`` is the end that moved last, -1 or 1, or 0; ``stalled`` the number of rounds in a row
    that did not halve it.
    """

    low: float
    high: float
    f_low: float
    f_high: float
    side: float
    stalled: float


def trial_x(bracket: Bracket, width: Scalar) -> Scalar:
    """Return the next trial point; it is not between the ends if there is no number between them."""
    low = bracket.low
    high = bracket.high
    f_low = bracket.f_low
    falls = _converges(bracket)
    middle = 0.5 * (low + high)
    x = low + (high - low) * f_low / where(falls, f_low - bracket.f_high, 1.0)
    x = where(falls, minimum(maximum(x, low + 0.4 * width), high - 0.4 * width), middle)
    return where(logical_and(low < x, x < high), x, middle)


def narrowed_bracket(bracket: Bracket, x: Scalar, value: Scalar) -> Bracket:
    """Return the remaining interval if the function has this ``value`` at ``x``."""
    low, high, f_low, f_high, side, stalled = (getattr(bracket, name) for name in Bracket._fields)
    below = value < 0
    new_low = where(below, x, low)
    new_high = where(below, high, x)
    stalls = 0.5 * (high - low) < new_high - new_low
    return Bracket(
        new_low,
        new_high,
        where(below, value, where(side > 0, 0.5 * f_low, f_low)),
        where(below, where(side < 0, 0.5 * f_high, f_high), value),
        where(below, -1.0, 1.0),
        where(stalls, where(_converges(bracket), stalled, 0.0) + 1.0, 0.0),
    )


def _converges(bracket: Bracket) -> Scalar:
    """Return whether the secant of its values may be used."""
    finite = abs(bracket.f_low - bracket.f_high) < math.inf
    return logical_and(bracket.stalled < 2, finite, bracket.f_low < bracket.f_high)
