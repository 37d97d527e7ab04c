"""A rope held in any way, its energy and its stability: what scenes without conveyances share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evidence.tables import Array
from rope_model.simulation.outputs.modal import ROUNDING, softest
from rope_model.simulation.rope_system import RopeSystem


@dataclass(frozen=True)
class StaticBoundary:
    """A rope_system.Boundary at rest: what is held, and at which values; arrays (nodes, 7)."""

    held: NDArray[np.bool_]
    values: Array

    @staticmethod
    def without_supports(values: Array) -> StaticBoundary:
        return StaticBoundary(np.zeros(values.shape, dtype=bool), values)

    def free(self, nodes: int) -> NDArray[np.bool_]:
        return ~self.held

    def prescribed_motion(self, t: float, nodes: int) -> Array:
        return np.array([self.values, 0 * self.values, 0 * self.values])

    def load(self, nodes: int) -> Array:
        return np.zeros_like(self.values)

    def friction_load(self, nodes: int) -> Array:
        return np.zeros_like(self.values)


def potential(balance: dict[str, float]) -> float:
    """Strain and potential energy, J."""
    return sum(balance[name] for name in ("axial", "coupling", "torsion", "bending", "gravity"))


def is_stable(system: RopeSystem, q: Array) -> bool:
    """Whether no small motion lowers the energy; the angles count along ``q``."""
    return softest(system.with_reference(q), q) > -ROUNDING
