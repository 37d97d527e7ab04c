"""Jacobi: both partners at once, each with what it expects of the other.

The drive gets extrapolated forces. The rope gets the motion of extrapolated accelerations from the drive's place and
speed at the step's start,

    y(1) = y + h v + h^2 (c0/2 + c1/6 + c2/12) ,   v(1) = v + h (c0 + c1/2 + c2/3) ,   a(1) = c0 + c1 + c2 ;

holding the place itself would move the rope's end by jumps. Drive and rope may run at the same time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hoist_demo.cosimulation.schemes.extrapolation import Extrapolated, extrapolation_coefficients
from hoist_demo.cosimulation.schemes.interface import Advance, InterfaceMotion, Load, Memory, Pair


@dataclass(frozen=True)
class Jacobi(Extrapolated):
    """Forces and accelerations extrapolated to `order` 0, 1 or 2; of the order `order` + 1 in H."""

    def advance(self, pair: Pair, memory: Memory, t: float, h: float) -> Advance:
        start, rise, bend = extrapolation_coefficients(memory.samples, "force", self.order, h)
        c0, c1, c2 = extrapolation_coefficients(memory.samples, "acceleration", self.order, h)
        load = Load(start, rise, bend, np.zeros_like(start))
        now = pair.drive.motion(load, 0.0)
        expected = InterfaceMotion(
            now.place + h * now.speed + h * h * (c0 / 2.0 + c1 / 6.0 + c2 / 12.0),
            now.speed + h * (c0 + c1 / 2.0 + c2 / 3.0),
            c0 + c1 + c2,
        )
        if cause := pair.step_drive(t, h, load) or pair.step_rope(t, h, expected):
            return Advance(memory, cause)
        return Advance(pair.exchanged(memory, t + h, Load.constant(pair.forces()[0])))
