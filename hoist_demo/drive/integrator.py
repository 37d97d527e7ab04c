"""The drive's compiled equations in one form, integrated by steps of their own choice.

Steps are chosen so that none errs by more than the tolerance,

    h_new = 0.9 h (tolerance / error)^(1/5) ,   from half of h to half as much again ,

and not beyond h after one that was taken back: a step at the bound of stability errs little, and a longer one much.
What is watched ends them: the last one is then shortened by bisection until what is watched has just become positive.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hoist_demo.drive.equations import numbers_of, parts_of
from hoist_demo.drive.kernels import CHUNK, ORDER, drive_kernels
from hoist_demo.parameters import Hoist
from rope_model.numerics.kernels import Kernel, KernelForm

Vector = NDArray[np.float64]
Watch = Callable[[Vector], float]  #: Of a state and OUTPUTS there, as one vector; positive once the steps are to end.

SHORTEST = 1e-7  #: Step of the integrator [s] below which it gives up.
SAFETY, SHRINKS, GROWS = 0.9, 0.5, 1.5  #: Of its steps: factor from the error, and its bounds.
LOCATED = 1e-9  #: How long before the end of the steps what is watched may have become positive [s].


#: Where steps have ended: all that `advance` of kernels.py gives there, size of the next one, s.
Reached = tuple[Vector, float, float]


class Integrator:
    """Integrator for all hoists with the same parts; not to be shared between threads."""

    def __init__(self, hoist: Hoist, form: KernelForm) -> None:
        kernels = drive_kernels(parts_of(hoist), form)
        self.names, given, self.result = kernels.names, kernels.given, kernels.result
        self._error, self._reached = self.result["error"].start, slice(0, self.result["works"].stop)
        self._advance = Kernel(kernels.advance, [(self.result["shown"].stop,)])
        self._z, self._y = self._advance.inputs[0], self._advance.outputs[0]
        self._s, self._h, self._H, self._l0 = (given[name].start for name in ("s", "h", "H", "l0"))
        self._x, self._works, self._path = (self._z[given[name]] for name in ("x", "works", "path"))
        self._added_mass, self._numbers = self._z[given["added_mass"]], self._z[given["p"]]
        self._start = self._z[self._reached]
        self.load(hoist)
        self.evaluations = 0  # of `advance`, so far
        self._hold, self._mobility = kernels.hold, Kernel(kernels.mobility, [(2, 2)])

    def load(self, hoist: Hoist) -> None:
        """Go on with the numbers of a hoist of the same parts."""
        self._numbers[:] = numbers_of(hoist)

    def give(
        self, x: Vector, works: Vector, lengths: tuple[float, float], h: float, path: Vector, added_mass: Vector
    ) -> None:
        """Give the start: state, work so far, free lengths, communication step, and loads in it."""
        z, l0 = self._z, self._l0
        z[self._H], z[l0], z[l0 + 1] = h, *lengths
        self._x[...], self._works[...], self._path[...], self._added_mass[...] = x, works, path, added_mass

    def holding_torque(self, x: Vector, lengths: tuple[float, float]) -> float:
        """Return the motor's torque that holds the state at rest [N m]."""
        return float(self._hold(x, lengths, self._numbers))

    def mobility(self, x: Vector, u: Vector, lengths: tuple[float, float]) -> Vector:
        """Change of (a_left, a_right) per force on either conveyance, shape (2, 2) [1/kg]."""
        (columns,) = self._mobility(x, u, np.array(lengths), self._numbers)
        return columns.T

    def at(self, s: float) -> Vector:
        """All that `advance` gives in the state given, without a step."""
        self._z[self._s], self._z[self._h] = s, 0.0
        self._advance.evaluate()
        return self._y.copy()

    def integrate(self, h: float, size: float, s: float, end: float, watch: Watch | None = None) -> Reached | None:
        """Integrate to the end, or to where the watched function becomes positive; None on failure.

        Begins with steps of this size, a share of h [s].
        """
        growth = GROWS
        while size * h > SHORTEST:
            calls = max(1, math.ceil((end - s) / (CHUNK * size) - 1e-9))
            used = (end - s) / (CHUNK * calls)
            y = self._evaluated(s, used)
            error = y.item(self._error)
            size = min(used * _change(error), size * growth)
            if error <= 1.0:
                if watch is not None and watch(y) > 0.0:
                    y, used = self._first(y, s, used, h, watch)
                    return y, size, s + CHUNK * used
                if calls == 1:
                    return y, size, end
                self._start[...] = y[self._reached]
                s += CHUNK * used
            else:
                growth = 1.0
        return None

    def _evaluated(self, s: float, used: float) -> Vector:
        """CHUNK steps of the size used from the state given, at s."""
        self._z[self._s], self._z[self._h] = s, used
        self._advance.evaluate()
        self.evaluations += 1
        return self._y.copy()

    def _first(self, y: Vector, s: float, used: float, h: float, watch: Watch) -> tuple[Vector, float]:
        """The result where what is watched has just become positive, and the size of the steps to there."""
        low = 0.0
        while CHUNK * (used - low) * h > LOCATED:
            middle = (low + used) / 2.0
            there = self._evaluated(s, middle)
            if watch(there) > 0.0:
                y, used = there, middle
            else:
                low = middle
        return y, used


def _change(error: float) -> float:
    """Factor to the next step of the integrator, after one of this error over the tolerance."""
    if not math.isfinite(error):
        return SHRINKS
    factor: float = SAFETY * max(error, 1e-20) ** (-1.0 / ORDER)
    return max(SHRINKS, factor)
