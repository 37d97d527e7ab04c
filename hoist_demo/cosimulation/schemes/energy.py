"""Step-size control by the power bond: what one partner gives and the other does not get.

In each step the drive gets the work of its load, the rope gives its mean force times the distance. Their difference
over the step's length, a power, is kept below a bound: a step with more is taken back and repeated shorter, and the
next step follows from what the last one had. Source: S. Sadjina, L. T. Kyllingstad, S. Skjong and E. Pedersen, Energy
conservation and power bonds in co-simulations, Engineering with Computers 33 (2017), with rollback added.
"""

import math
from dataclasses import dataclass

from hoist_demo.cosimulation.schemes.interface import Advance, CoupledSystem, Scheme, SchemeState

SAFETY = 0.8  #: Factor on the step that the power allows.
MAX_CHANGE = 2.0  #: Largest factor from one step to the next.


@dataclass(frozen=True)
class EnergyControlled:
    """Divides the host's steps so that `inner` makes up no more than `bound` [W] in any of its own."""

    inner: Scheme
    bound: float = 20.0  # W
    smallest: float = 1e-4  # s
    order: int = 2  # order in h of the power that `inner` makes up
    needs_rollback: bool = True

    @property
    def needs_added_mass(self) -> bool:
        return self.inner.needs_added_mass

    @property
    def weights(self) -> tuple[float, ...]:
        return self.inner.weights

    def advance(
        self, coupled: CoupledSystem, scheme_state: SchemeState, t: float, h: float
    ) -> Advance:
        """Steps of the scheme's own, the last of which ends at t + h."""
        done = 0.0
        target_step = scheme_state.step_next or h
        while done < h:
            parts = max(math.ceil((h - done) / target_step - 1e-9), 1)
            step = (h - done) / parts
            before = coupled.save()
            advance = self.inner.advance(coupled, scheme_state, t + done, step)
            if advance.cause:
                return advance
            power = abs(advance.scheme_state.residual - scheme_state.residual) / step
            factor = (
                SAFETY * (self.bound / power) ** (1.0 / self.order) if power > 0.0 else math.inf
            )
            if power > self.bound:
                target_step = step * min(max(factor, 0.1), 0.5)
                coupled.restore(before)
                scheme_state = scheme_state.with_taken_back(
                    advance.scheme_state.exchanges - scheme_state.exchanges
                )
                if target_step < self.smallest:
                    return Advance(
                        scheme_state,
                        f"coupling: {power:.3g} W between drive and rope in a step of {step:.3g} s, bound "
                        f"{self.bound:g} W, smallest step {self.smallest:g} s: allow more power or a smaller step",
                    )
                continue
            scheme_state, done = advance.scheme_state, h if parts == 1 else done + step
            # a step that was cut to end at t + h says nothing against a longer one
            target_step = max(step * min(factor, MAX_CHANGE), min(target_step, step * factor))
        return Advance(scheme_state._replace(step_next=min(target_step, h)))
