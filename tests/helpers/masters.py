"""The loops that co-simulation masters run: when they step, and by how much."""

import math
from collections.abc import Callable, Iterator

import numpy as np

#: (t, h) of one step after another
Steps = Iterator[tuple[float, float]]


def remainder_steps(H: float, T: float) -> Steps:
    """``while t < T: h = min(H, T - t)``: what rounding leaves of T is a step of its own."""
    t = 0.0
    while t < T:
        h = min(H, T - t)
        yield t, h
        t += h


def adding_steps(H: float, T: float) -> Steps:
    """``t += H``, and one step back to the even instants every second."""
    t = 0.0
    second = 1.0
    while second <= T:
        while t + H < second:
            yield t, H
            t += H
        yield t, second - t
        t = second
        second += 1.0


def counted_steps(H: float, T: float) -> Steps:
    for k in range(round(T / H)):
        yield k * H, (k + 1) * H - k * H


LOOPS: dict[str, Callable[[float, float], Steps]] = {
    "remaining": remainder_steps,
    "adding": adding_steps,
    "counting": counted_steps,
}


def random_steps(seed: int, T: float, shortest: float, longest: float) -> Steps:
    """Steps over all sizes between, each decade alike, and every other one of the largest."""
    random = np.random.default_rng(seed)
    t = 0.0
    while t < T:
        if random.random() < 0.5:
            h = 10 ** random.uniform(math.log10(shortest), math.log10(longest))
        else:
            h = random.uniform(0.25 * longest, longest)
        yield t, h
        t += h


#: of y, vy and ay behind a jerk j that is extrapolated over steps up to H, over j H^3, j H^2 and j
#: H: in any steps
MISSED = np.array([1.2, 1.2, 5.9])
#: m and s, of the trip that the loops wind
TRAVEL = 90.0
DURATION = 25.0
#: m/s^3, of the trip at its start
JERK = 60 * TRAVEL / DURATION**3
