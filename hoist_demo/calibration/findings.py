"""Finding of a fit on a property.

Words, statuses and the exit code follow from it.
"""

from enum import Enum

from hoist_demo.calibration.fit import Fit
from rope_model.arrays import Array

#: Half width of an interval in shares from which on a property is undetermined: half that of a
#: range.
OPEN = 0.25


class Finding(Enum):
    """Finding about one property, or about one parameter that is sought."""

    CALIBRATED = "calibrated"  # within an interval that is narrower than its range
    UNDETERMINED = "undetermined"  # the data say no more than the range
    AT_LOWER_END = "at the lower end of its range"  # the data ask for less than the range allows
    AT_UPPER_END = "at the upper end of its range"  # the data ask for more than the range allows
    # a compromise between measurements that contradict the model or one another
    CONTRADICTED = "contradicted"

    @property
    def at_end(self) -> bool:
        """True at an end of the range, which stands."""
        return self in (Finding.AT_LOWER_END, Finding.AT_UPPER_END)


def findings_of(fit: Fit, intervals: Array) -> list[Finding]:
    """Return the finding of each share with its interval, (n, 2)."""
    widths = (intervals[:, 1] - intervals[:, 0]).tolist()
    rows = zip(fit.held.tolist(), fit.reaches.tolist(), widths, strict=True)
    return [_finding(held, reach, width, fit.contradicted) for held, reach, width in rows]


def _finding(held: int, reach: float, width: float, contradicted: bool) -> Finding:
    """Return the finding of a share, from its linear reach and the width of its interval."""
    if contradicted and (held or reach < OPEN):
        return Finding.CONTRADICTED
    if contradicted:
        return Finding.UNDETERMINED
    if held > 0:
        return Finding.AT_UPPER_END
    if held < 0:
        return Finding.AT_LOWER_END
    if 0.5 * width < OPEN:
        return Finding.CALIBRATED
    return Finding.UNDETERMINED
