"""Slip of the head ropes on the sheave: when it begins and ends, for hoists with a lining.

Ropes of the mass mu_r per length and the speed w hold while (Euler and Eytelwein)

    T_1 - mu_r w^2 <= exp(mu alpha) max(T_2 - mu_r w^2, 0) ,     T_1 >= T_2 .

Then they slide towards T_1, under the friction of `SlidingFriction`, until their speed on the sheave has come to 0.
Both instants are located. What has slid goes over into the free lengths when they hold again, so that ropes that hold
have the same equations before and after, and the same as in a hoist without a lining.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hoist_demo.drive.integrator import Integrator, Vector, Watch
from hoist_demo.drive.outputs import SHOWN
from hoist_demo.parameters import Hoist
from rope_model.numerics.kernels import KernelForm

_TENSIONS = SHOWN["tension_left"], SHOWN["tension_right"]


class Slide(NamedTuple):
    """Slip of the head ropes, positive as the sheave's rotation."""

    sense: float = 0.0  # 1 or -1 while they slide, 0 while they hold
    speed: float = 0.0  # m/s, of the ropes on the sheave
    way: float = 0.0  # m, that they have slid since the start
    slip: float = 0.0  # m, the part of it that is not in the free lengths: since they hold no longer


class Sliding:
    """The drive while its head ropes slide: its integrator, whose state has slip, its rate and its sense beside."""

    def __init__(self, hoist: Hoist, form: KernelForm, held: Sequence[str]) -> None:
        """`held` are the names of the states of ropes that hold."""
        self.integrator = Integrator(hoist, form)
        names = self.integrator.names
        self._held = [names.index(name) for name in held]
        self._slip, self._rate, self._sense = (names.index(name) for name in ("slip", "slip_rate", "sense"))

    def state(self, x: Vector, slide: Slide) -> Vector:
        """Return the integrator's state, from that of ropes that hold."""
        whole = np.zeros(len(self.integrator.names))
        whole[self._held], whole[self._sense] = x, slide.sense
        whole[self._slip], whole[self._rate] = slide.slip, slide.speed
        return whole

    def parts(self, x: Vector, before: Slide) -> tuple[Vector, Slide]:
        """The state of ropes that hold, and how they slide, in a state of the integrator."""
        slip = x.item(self._slip)
        return x[self._held], Slide(before.sense, x.item(self._rate), before.way + (slip - before.slip), slip)

    def ends(self, sense: float) -> Watch:
        """Positive once they slide no longer."""
        rate = self._rate
        return lambda y: -sense * y.item(rate)


def begins(hoist: Hoist, held: Integrator) -> Watch:
    """Tension that the friction does not hold [N], of ropes that hold."""
    left, right = (held.result["shown"].start + k for k in _TENSIONS)
    rate, most = held.names.index("phi_rate"), hoist.tension_ratio_limit

    def excess(y: Vector) -> float:
        off = hoist.rope_mass * (hoist.sheave_radius * y.item(rate)) ** 2
        low, high = sorted((y.item(left), y.item(right)))
        return high - off - most * max(low - off, 0.0)

    return excess


def sense_of(shown: Vector) -> float:
    """Return the sense in which ropes begin to slide: towards the larger tension."""
    left, right = (shown.item(k) for k in _TENSIONS)
    return 1.0 if right > left else -1.0
