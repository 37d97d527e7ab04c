"""What a host sends of a conveyance's motion: exact, from a table, rounded, repeated, late, or with gaps."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hoist_demo.control.trajectory import Trajectory

#: seed of what is drawn by chance
SEED = 27

Sample = tuple[float, float, float]
#: position, speed and acceleration that are sent for an instant
Source = Callable[[float], Sample]


class Signal(NamedTuple):
    """A kind of signal; ``make`` builds the source for a trip and a communication step."""

    name: str
    make: Callable[[Trajectory, float], Source]
    judged: bool = True  # whether the targets for forces hold for it
    told: bool = True  # whether a warning must name it where it does not fit
    estimated: bool = True  # whether the target for the error estimate holds


def _exact(trip: Trajectory, step: float) -> Source:
    def at(t: float) -> Sample:
        point = trip.at(t)
        return point.position, point.speed, point.acceleration

    return at


def _table(every: float) -> Callable[[Trajectory, float], Source]:
    def make(trip: Trajectory, step: float) -> Source:
        exact = _exact(trip, step)

        def at(t: float) -> Sample:
            k = math.floor(t / every + 1e-9)
            part = t / every - k
            before, after = exact(k * every), exact((k + 1) * every)
            x, v, a = ((1.0 - part) * p + part * q for p, q in zip(before, after, strict=True))
            return x, v, a

        return at

    return make


def _rounded(grid: float) -> Callable[[Trajectory, float], Source]:
    def make(trip: Trajectory, step: float) -> Source:
        exact = _exact(trip, step)

        def at(t: float) -> Sample:
            x, v, a = exact(t)
            return round(x / grid) * grid, v, a

        return at

    return make


def _repeated(times: int) -> Callable[[Trajectory, float], Source]:
    def make(trip: Trajectory, step: float) -> Source:
        exact, every = _exact(trip, step), times * step
        return lambda t: exact(math.floor(t / every + 1e-9) * every)

    return make


def _jittered(spread: float) -> Callable[[Trajectory, float], Source]:
    def make(trip: Trajectory, step: float) -> Source:
        exact, rng = _exact(trip, step), np.random.default_rng(SEED)
        return lambda t: exact(max(0.0, t + rng.uniform(-spread, spread)))

    return make


def _lost(part: float) -> Callable[[Trajectory, float], Source]:
    def make(trip: Trajectory, step: float) -> Source:
        exact, rng = _exact(trip, step), np.random.default_rng(SEED)
        latest = exact(0.0)

        def at(t: float) -> Sample:
            nonlocal latest
            if rng.random() >= part:
                latest = exact(t)
            return latest

        return at

    return make


SIGNALS = (
    Signal("exact", _exact, told=False),
    Signal("table of 20 ms", _table(0.02)),
    Signal("table of 50 ms", _table(0.05)),
    Signal("table of 100 ms", _table(0.1)),
    Signal("positions rounded to 1 mm", _rounded(1e-3)),
    Signal("positions rounded to 0.1 mm", _rounded(1e-4)),
    Signal("each sample sent twice", _repeated(2)),
    Signal("each sample sent five times", _repeated(5), judged=False, estimated=False),
    Signal("time stamps off by up to 10 ms", _jittered(0.01), judged=False),
    Signal("1 % of the samples lost", _lost(0.01), judged=False),
)
