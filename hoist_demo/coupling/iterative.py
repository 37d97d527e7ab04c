"""Iteration with rollback: the step is repeated until the forces that the drive got are those that the rope gives.

Over the step the drive's load is the parabola through the rope's force at its start, its mean and its force at its
end. Unknown are mean and end, x = (mean, end). With the rope's added mass m_a and the drive's mobility B = da/dF

    d end / d mean = -m_a B ,   d mean / d mean = -m_a B / 2 ,

because the force follows the speed, and the speed at the end follows the mean.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .accelerators import Accelerator, Aitken, InterfaceJacobian, Secant
from .extrapolation import extrapolated
from .interface import Advance, Books, Load, Memory, Pair, Vector

AcceleratorName = Literal["jacobian", "aitken", "secant"]
ACCELERATORS: tuple[AcceleratorName, ...] = ("jacobian", "aitken", "secant")

MOST_EXCHANGES = 30
"""Tries of one step, after which it fails."""


@dataclass(frozen=True)
class Iterative:
    """Repeats a step until no force changes by more than `tolerance` [N]."""

    accelerator: AcceleratorName
    tolerance: float = 1.0  # N
    limit: float = math.inf
    needs_rollback: bool = True

    @property
    def needs_added_mass(self) -> bool:
        """Whether the Jacobian comes from it."""
        return self.accelerator == "jacobian"

    def advance(self, pair: Pair, memory: Memory, t: float, h: float) -> Advance:
        """As many exchanges as it takes."""
        drive, rope = pair.drive.save(), pair.rope.save()
        try:
            return self._iterated(pair, memory, t, h, (drive, rope))
        finally:
            pair.rope.free(rope)

    def _iterated(self, pair: Pair, memory: Memory, t: float, h: float, start: tuple[object, object]) -> Advance:
        force = memory.last.force
        n = force.size
        _, rise, bend = extrapolated(memory.samples, "force", 2, h)
        x = np.concatenate([force + rise / 2.0 + bend / 3.0, force + rise + bend])
        accelerator = self._accelerator(pair, n)
        for tried in range(MOST_EXCHANGES):
            if tried:
                pair.drive.restore(start[0])
                pair.rope.restore(start[1])
            load = Load.through(force, x[:n], x[n:])
            books = Books(pair, load)
            if cause := pair.drive_then_rope(t, h, load):
                return Advance(memory, cause)
            end, mean = pair.rope.forces()
            answer = np.concatenate([mean, end])
            change = float(np.max(np.abs(answer - x)))
            if change <= self.tolerance:
                return Advance(
                    memory.with_taken_back(tried).with_sample(pair.sampled(t + h), books.closed(mean)),
                )
            x = accelerator.next(x, answer)
        return Advance(
            memory,
            f"coupling: after {MOST_EXCHANGES} exchanges the forces still change by {change:.3g} N, "
            f"tolerance {self.tolerance:g} N: take the accelerator secant, a shorter step or a larger tolerance",
        )

    def _accelerator(self, pair: Pair, n: int) -> Accelerator:
        if self.accelerator == "aitken":
            return Aitken()
        if self.accelerator == "secant":
            return Secant()
        response: Vector = -pair.added_mass()[:, None] * pair.drive.mobility()
        none = np.zeros((n, n))
        return InterfaceJacobian(np.block([[response / 2.0, none], [response, none]]))
