"""Step-size control by the power bond: the power that one partner gives and the other does not get.

In each step the drive gets the work of its load, the rope gives its mean force times the distance.
Their difference over the step's length, a power, is kept below a bound: a step with more is taken
back and repeated shorter, and the power of a step decides the length of the next one. Source:
S. Sadjina, L. T. Kyllingstad, S. Skjong and E. Pedersen, Energy conservation and power bonds in
co-simulations, Engineering with Computers 33 (2017), with rollback added.
"""

import math
from dataclasses import dataclass

from hoist_demo.cosimulation.schemes.interface import Advance, CoupledSystem, Scheme, SchemeState
from rope_model import Status

SAFETY = 0.8  #: Factor on the step that the power allows.
MAX_CHANGE = 2.0  #: Largest factor from one step to the next.
MIN_RETRY = 0.1  #: Smallest factor from a step that is taken back to its repetition.
MAX_RETRY = 0.5  #: Largest factor from a step that is taken back to its repetition.
_ROUNDING = 1e-9  #: Part of a step by which the rest may exceed it through rounding alone.


@dataclass(frozen=True)
class EnergyControlled:
    """Divides the host's steps so that each step of ``inner`` has a power below ``bound`` [W]."""

    inner: Scheme
    bound: float = 20.0  # W
    smallest: float = 1e-4  # s
    order: int = 2  # order in h of the difference of powers
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
        """Advance by steps of the scheme's choice, the last of which ends at t + h."""
        done = 0.0
        target_step = scheme_state.step_next or h
        while done < h:
            parts = max(math.ceil((h - done) / target_step - _ROUNDING), 1)
            step = (h - done) / parts
            before = coupled.save()
            advance = self.inner.advance(coupled, scheme_state, t + done, step)
            if not advance.status.valid:
                return advance
            power = abs(advance.scheme_state.residual - scheme_state.residual) / step
            factor = self._step_factor(power)
            if power > self.bound:
                target_step = step * min(max(factor, MIN_RETRY), MAX_RETRY)
                coupled.restore(before)
                exchanges = advance.scheme_state.exchanges - scheme_state.exchanges
                scheme_state = scheme_state.with_taken_back(exchanges)
                if target_step < self.smallest:
                    return Advance(scheme_state, self._failure(power, step))
                continue
            scheme_state = advance.scheme_state
            done += step
            if parts == 1:
                done = h
            # the step may have been cut to end at t + h: a longer one may be allowed all the same
            target_step = max(step * min(factor, MAX_CHANGE), min(target_step, step * factor))
        return Advance(scheme_state._replace(step_next=min(target_step, h)))

    def _step_factor(self, power: float) -> float:
        """Return the factor from a step with this power [W] to the step that the bound allows."""
        if power <= 0.0:
            return math.inf
        return float(SAFETY * (self.bound / power) ** (1.0 / self.order))

    def _failure(self, power: float, step: float) -> Status:
        """Return the status of a step [s] with too much power [W], which may not be shortened."""
        return Status(
            False,
            f"coupling: {power:.3g} W between drive and rope in a step of {step:.3g} s, "
            f"bound {self.bound:g} W, smallest step {self.smallest:g} s: "
            "allow more power or a smaller step",
        )
