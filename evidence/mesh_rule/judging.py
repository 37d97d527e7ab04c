"""Asked against achieved errors of the loop's place."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from evidence.tables import Table


class Distribution(NamedTuple):
    """Of achieved over asked: how many, median, nine of ten, worst; share within; median number of elements."""

    number: int
    median: float
    most: float
    worst: float
    within: float
    elements: float


def is_resolved(t: Table) -> NDArray[np.bool_]:
    """Where two references differ by less than what is asked; the finer one, used, errs by less than half of that."""
    return np.asarray(t["reference [m]"] < t["asked [m]"])


def distribution(t: Table, kind: str, asked: float) -> Distribution:
    """Of one kind of trip."""
    mine = is_resolved(t) & (t["trip"] == kind) & np.isclose(t["asked [m]"], asked)
    ratio = t["achieved [m]"][mine] / asked
    if ratio.size == 0:
        return Distribution(0, *5 * (math.nan,))
    median, most = np.quantile(ratio, (0.5, 0.9))
    return Distribution(
        int(mine.sum()), median, most, ratio.max(), float(np.mean(ratio <= 1)), float(np.median(t["elements"][mine]))
    )


def swing(t: Table, kind: str) -> tuple[float, float]:
    """Largest error of a trip over that at rest before it: median, nine of ten."""
    mine = is_resolved(t) & (t["trip"] == kind) & (t["mesh"] == "tmn")
    median, most = np.quantile(t["achieved [m]"][mine] / t["at rest [m]"][mine], (0.5, 0.9))
    return float(median), float(most)


def misses(t: Table, asked: float) -> list[int]:
    """Rows that miss what was asked, the worst first."""
    missed = np.flatnonzero(is_resolved(t) & np.isclose(t["asked [m]"], asked) & (t["achieved [m]"] > t["asked [m]"]))
    return [int(i) for i in sorted(missed, key=lambda i: -t["achieved [m]"][i])]
