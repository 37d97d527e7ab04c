"""What a host sends of a conveyance's motion: exact, from a table, rounded, repeated, late, or with gaps."""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from hoist_demo.control.trajectory import Trajectory

#: seed of what is drawn by chance
SEED = 27

Sample = tuple[float, float, float]
#: position, speed and acceleration that are sent for an instant
Source = Callable[[float], Sample]


class Signal(NamedTuple):
    """A kind of signal; ``make`` builds the source from the exact motion and a communication step."""

    name: str
    make: Callable[[Source, float], Source]
    judged: bool = True  # whether the targets for forces hold for it
    told: bool = True  # whether a warning must name it where it does not fit
    estimated: bool = True  # whether the target for the error estimate holds


def motion_of(trip: Trajectory, t: float) -> Sample:
    """Return the exact motion."""
    point = trip.at(t)
    return point.position, point.speed, point.acceleration


def _table(every: float, exact: Source, step: float) -> Source:
    def at(t: float) -> Sample:
        k = math.floor(t / every + 1e-9)
        part = t / every - k
        x, v, a = (
            (1.0 - part) * p + part * q
            for p, q in zip(exact(k * every), exact((k + 1) * every), strict=True)
        )
        return x, v, a

    return at


def _rounded(grid: float, exact: Source, step: float) -> Source:
    return lambda t: (round(exact(t)[0] / grid) * grid, *exact(t)[1:])


def _repeated(times: int, exact: Source, step: float) -> Source:
    return lambda t: exact(math.floor(t / (times * step) + 1e-9) * times * step)


def _jittered(spread: float, exact: Source, step: float) -> Source:
    rng = np.random.default_rng(SEED)
    return lambda t: exact(max(0.0, t + rng.uniform(-spread, spread)))


def _lost(part: float, exact: Source, step: float) -> Source:
    rng = np.random.default_rng(SEED)
    latest = [exact(0.0)]

    def at(t: float) -> Sample:
        if rng.random() >= part:
            latest[0] = exact(t)
        return latest[0]

    return at


SIGNALS = (
    Signal("exact", lambda exact, step: exact, told=False),
    Signal("table of 20 ms", partial(_table, 0.02)),
    Signal("table of 50 ms", partial(_table, 0.05)),
    Signal("table of 100 ms", partial(_table, 0.1)),
    Signal("positions rounded to 1 mm", partial(_rounded, 1e-3)),
    Signal("positions rounded to 0.1 mm", partial(_rounded, 1e-4)),
    Signal("each sample sent twice", partial(_repeated, 2)),
    Signal("each sample sent five times", partial(_repeated, 5), judged=False, estimated=False),
    Signal("time stamps off by up to 10 ms", partial(_jittered, 0.01), judged=False),
    Signal("1 % of the samples lost", partial(_lost, 0.01), judged=False),
)
