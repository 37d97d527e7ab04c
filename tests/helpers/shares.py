"""Place of a value in a range of the catalogue of ropes."""

import math

from rope_model import Datum


def share_of(datum: Datum, value: float) -> float:
    """Return the fraction of the range at ``value``, the inverse of ``datum.at``."""
    if datum.logarithmic:
        return math.log(value / datum.low) / math.log(datum.high / datum.low)
    return (value - datum.low) / (datum.high - datum.low)
