"""Polynomials through the last samples, continued over the next step.

Order 0 holds the last value, 1 continues the line and 2 the parabola through the last two and three. The samples need
not be evenly spaced; as long as there are too few the order is lower. Source: M. Busch, Zur effizienten Kopplung von
Simulationsprogrammen, 2012, chapter 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hoist_demo.cosimulation.schemes.interface import Sample, Vector

#: Weights of the samples, latest first, in the mean of the extrapolated step, by order (Adams-Bashforth).
MEAN_WEIGHTS = ((1.0,), (1.5, -0.5), (23.0 / 12.0, -16.0 / 12.0, 5.0 / 12.0))


@dataclass(frozen=True)
class Extrapolated:
    """Base of the schemes that extrapolate to `order` 0, 1 or 2."""

    order: int
    needs_rollback: bool = False
    needs_added_mass: bool = False

    @property
    def weights(self) -> tuple[float, ...]:
        return MEAN_WEIGHTS[self.order]


def extrapolation_coefficients(
    samples: Sequence[Sample], name: str, order: int, h: float
) -> tuple[Vector, Vector, Vector]:
    """Coefficients c0, c1, c2 of s = 0 .. 1 over the step of h [s] that follows the last sample; `name` is a field."""
    latest = samples[-1]
    last: Vector = getattr(latest, name)
    order = min(order, len(samples) - 1)
    zero = np.zeros(last.shape)
    if order == 0:
        return last, zero, zero
    # Newton's divided differences, from the last sample backwards
    second: Vector = getattr(samples[-2], name)
    t = (samples[-2].t - latest.t) / h
    slope = (last - second) / -t
    if order == 1:
        return last, slope, zero
    t_before = (samples[-3].t - latest.t) / h
    before = (second - getattr(samples[-3], name)) / (t - t_before)
    bend = (slope - before) / -t_before
    return last, slope - bend * t, bend
