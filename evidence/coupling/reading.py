"""Observed orders of the schemes against theory, and how often stability happened as the growth predicts."""

from __future__ import annotations

import math

import numpy as np

from evidence.tables import Table, rows

#: order that each scheme's theory promises for smooth motion
ORDERS = {
    "0": 1,
    "1": 2,
    "2": 3,
    "preserving": 1,
    "impulse": 1,
    "controlled": 2,
    "jacobian": 4,
    "aitken": 4,
    "secant": 4,
}
#: bound of the acceptance: RMS error of the end forces over the largest
PROMISED = 0.005


def theory(scheme: str) -> int:
    """Order in H of a scheme."""
    return ORDERS[scheme.rpartition("-")[2]]


def order(t: Table, scheme: str, longer: float, shorter: float) -> float:
    """Observed order between two communication steps [s]; NaN where a run stopped."""
    r = rows(t, scheme=scheme)
    e = [float(r["force error"][np.isclose(r["H [s]"], H)][0]) for H in (longer, shorter)]
    if not all(math.isfinite(x) and x > 0.0 for x in e):
        return math.nan
    return math.log(e[0] / e[1]) / math.log(longer / shorter)


def order_on_hoist(t: Table, scheme: str) -> float:
    """Order on the hoist; of the iterative schemes at long steps, where the reference's tolerance does not show."""
    longer, shorter = (0.04, 0.02) if scheme.startswith("iterative") else (0.02, 0.005)
    return order(t, scheme, longer, shorter)


def correct_predictions(t: Table, margin: float) -> tuple[int, int]:
    """How many points of the map happened as the growth says, and how many there are."""
    agree = (t["predicted growth"] < margin) == (t["stable"] > 0)
    return int(np.sum(agree)), agree.size
