"""Semi-implicit: the rope's force is expected to change with the acceleration of the step that is being done.

    F(s) = F_e(s) - m_a (a - a_e(s))

with extrapolated F_e and a_e and the rope's added mass m_a. The drive solves for its own acceleration under this
load, so that no step is taken twice. Source: the idea of B. Schweizer and D. Lu, Predictor/corrector co-simulation
approaches for solver coupling with algebraic constraints, ZAMM 95 (2015), with the added mass in place of the
coupling Jacobian.
"""

from __future__ import annotations

from dataclasses import dataclass

from hoist_demo.cosimulation.schemes.extrapolation import Extrapolated, extrapolation_coefficients
from hoist_demo.cosimulation.schemes.interface import Advance, Load, Memory, Pair


@dataclass(frozen=True)
class SemiImplicit(Extrapolated):
    """Extrapolation to `order` 0, 1 or 2; of the order `order` + 1 in H."""

    needs_added_mass: bool = True

    def advance(self, pair: Pair, memory: Memory, t: float, h: float) -> Advance:
        added = pair.added_mass()
        force = extrapolation_coefficients(memory.samples, "force", self.order, h)
        acceleration = extrapolation_coefficients(memory.samples, "acceleration", self.order, h)
        start, rise, bend = (f + added * a for f, a in zip(force, acceleration, strict=True))
        return pair.exchange(memory, t, h, Load(start, rise, bend, added))
