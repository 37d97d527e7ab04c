"""What the table of points tells: rows of a family, and how far the reference solution is to be trusted."""

import numpy as np

from evidence.accuracy.measure import ERRORS
from evidence.tables import Array, Table, rows

FORCE, LOOP, TWIST = ERRORS


def finest(t: Table, coupling: str) -> tuple[float, float]:
    """Elements and step (s) of the reference solution."""
    r = rows(t, family="reference", coupling=coupling)
    return float(r["elements"].max()), float(r["largest step [s]"].min())


def finest_error(differences: Array) -> float:
    """Error left in the finest of solutions, each twice as fine as the one before, from their differences to it.

    An error that goes with h^p makes the two last differences stand as 2^p + 1 to 1 and leaves the last one over
    2^p - 1.  p is taken as 1 at least and 2 at most, and as 1 where there are no three solutions.
    """
    last = float(differences[-1])
    factor = float(differences[-2]) / last - 1.0 if differences.size > 1 and last > 0 else 2.0
    return last / (float(np.clip(factor, 2.0, 4.0)) - 1.0)


def limit(t: Table, coupling: str, error: str) -> float:
    """Error of the reference solution itself: of its mesh and of its step together."""
    r = rows(t, family="reference", coupling=coupling)
    n, h = finest(t, coupling)
    in_mesh = r["largest step [s]"] == h
    in_step = r["elements"] == n
    parts = []
    for line, size in ((in_mesh, -r["elements"]), (in_step, r["largest step [s]"])):
        order = np.argsort(-size[line])[:-1]  # the last is the reference itself
        parts.append(finest_error(r[error][line][order]) if order.size else 0.0)
    return sum(parts)
