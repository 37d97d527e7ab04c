"""Shared by the tests: a rope held and loaded in any way, and sections that follow a curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rope_model.simulation.rope_system import RopeKernels, RopeSystem

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Chain:
    """A rope_system.Boundary at rest: what is held, at which values, and dead loads; arrays (nodes, 7)."""

    held: NDArray[np.bool_]
    values: Array
    loads: Array

    @staticmethod
    def unloaded(values: Array) -> Chain:
        """Nothing held yet, no loads."""
        return Chain(np.zeros(values.shape, dtype=bool), values, np.zeros(values.shape))

    def free(self, nodes: int) -> NDArray[np.bool_]:
        return ~self.held

    def prescribed(self, t: float, nodes: int) -> Array:
        return np.array([self.values, 0 * self.values, 0 * self.values])

    def load(self, nodes: int) -> Array:
        return self.loads

    def grip(self, nodes: int) -> Array:
        return np.zeros((nodes, 7))


def portable_system(lengths: Array, P: Array, boundary: Chain) -> RopeSystem:
    """A small chain that needs no compiler."""
    return RopeSystem(RopeKernels(lengths.size, "portable"), lengths, P, boundary)


def straight(s: Array) -> Array:
    """(nodes, 7): an unstrained rope along X."""
    q = np.zeros((s.size, 7))
    q[:, 0], q[:, 3] = s, 1.0
    return q


def rotation(vector: Array) -> Array:
    """(3, 3): turning by |vector| about ``vector``."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / angle if angle > 0 else vector
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
