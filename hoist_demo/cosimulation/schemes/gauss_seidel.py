"""Gauss-Seidel: the drive first with extrapolated forces, then the rope along the motion that the drive made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hoist_demo.cosimulation.schemes.extrapolation import Extrapolated, extrapolation_coefficients
from hoist_demo.cosimulation.schemes.interface import Advance, Load, Memory, Pair


@dataclass(frozen=True)
class GaussSeidel(Extrapolated):
    """Forces extrapolated to `order` 0, 1 or 2; of the order `order` + 1 in H."""

    def advance(self, pair: Pair, memory: Memory, t: float, h: float) -> Advance:
        start, rise, bend = extrapolation_coefficients(memory.samples, "force", self.order, h)
        return pair.exchange(memory, t, h, Load(start, rise, bend, np.zeros(start.shape)))


@dataclass(frozen=True)
class ImpulsePreserving:
    """Gauss-Seidel with the rope's mean force of the last step held; of first order.

    The mean carries the impulse of the step, which the force at its end does not: what one partner gives arrives at
    the other one step late, and complete.
    """

    weights: tuple[float, ...] = (0.5, 0.5)  # of the forces at both ends of the last step
    needs_rollback: bool = False
    needs_added_mass: bool = False

    def advance(self, pair: Pair, memory: Memory, t: float, h: float) -> Advance:
        return pair.exchange(memory, t, h, Load.constant(memory.last.mean))
