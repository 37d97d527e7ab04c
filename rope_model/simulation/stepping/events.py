"""Root search for events: the instant at which a function of time first leaves the negative side.

It is the regula falsi with the Illinois modification.  It bisects after two rounds in a row that do not halve the
interval, or where a value is infinite (the function may be kinked).  C has the formulas from here.
"""

from collections.abc import Callable

from rope_model.rules.events import Bracket, narrowed, trial_x


def locate(
    f: Callable[[float], float], low: float, high: float, f_low: float, f_high: float, width: float
) -> float:
    """Return the right end of an interval of ``width`` in which ``f`` changes from negative to not negative.

    ``f_low`` < 0 <= ``f_high`` are the values at the ends.  Neighbouring floating-point numbers may be further apart
    than ``width``; then they are the interval.
    """
    bracket = Bracket(low, high, f_low, f_high, 0.0, 0.0)
    while bracket.high - bracket.low > width:
        x = trial_x(bracket, width)
        if not bracket.low < x < bracket.high:
            break
        bracket = narrowed(bracket, x, f(x))
    return bracket.high
