"""Shares and distributions of a table of scenes, and the targets that they are held against."""

import numpy as np

from evidence.claims import Measurement, above, below
from evidence.promise.wind import REQUESTS
from evidence.tables import Array, Table, rows

#: factor within which an estimate is to be of the error, and the share of those that are to be
NEAR = 2.0
NEAR_SHARE = 0.85
#: share of scenes that are to be within what was asked, and the worst one over what was asked
WITHIN = 0.97
WORST = 2.0
#: estimates: columns of error and estimate
ESTIMATES = {
    "end force": ("end force", "end force, estimated"),
    "loop": ("loop [m]", "loop, estimated [m]"),
}


def completed(t: Table, asked: str = "default") -> Table:
    """The scenes with one request whose runs went through."""
    return rows(t, asked=asked, failure="")


def over_asked(t: Table, asked: str = "default") -> Array:
    """Error over what was asked, the worse one of end force and loop."""
    return np.maximum(
        t["end force"] / REQUESTS[asked].end_force, t["loop [m]"] / REQUESTS[asked].loop
    )


def near(t: Table, estimate: str) -> float:
    """Share of the estimates within a factor of NEAR of the error."""
    error, estimated = (t[name] for name in ESTIMATES[estimate])
    return float(np.mean((estimated < NEAR * error) & (error < NEAR * estimated)))


def claims(t: Table) -> list[Measurement]:
    """What was found, and the targets."""
    found = []
    for asked in REQUESTS:
        over = over_asked(completed(t, asked), asked)
        within = float(np.mean(over <= 1))
        found.append(above(f"share of scenes within the {asked} request", within, WITHIN - 1e-9))
        found.append(below(f"largest error / request, {asked} request", over.max(), WORST))
    done = completed(t)
    for estimate in ESTIMATES:
        what = f"share of {estimate} estimates within a factor of {NEAR:g}"
        found.append(above(what, near(done, estimate), NEAR_SHARE - 1e-9))
    found.append(below("failed runs", float(np.count_nonzero(t["failure"])), 0.5))
    return found
