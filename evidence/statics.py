"""Ropes held in any way, without conveyances, and their shapes at rest: what validation and contact share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evidence.tables import Array
from rope_model.parameters import Rope
from rope_model.physics.element import parameters
from rope_model.physics.node import ANGLE
from rope_model.reference.equations import Equations, Mask
from rope_model.simulation.rope_kernels import RopeKernels
from rope_model.simulation.rope_system import RopeSystem
from rope_model.simulation.stepping.statics import Equilibrium, find_equilibrium


@dataclass(frozen=True)
class StaticBoundary:
    """A rope_system.Boundary at rest: what is held, and at which values; arrays (nodes, 7)."""

    held: NDArray[np.bool_]
    values: Array

    @staticmethod
    def at(values: Array, *places: Any) -> StaticBoundary:
        """Return the boundary that holds these ``places`` of ``values``, given as indices."""
        held = np.zeros(values.shape, dtype=bool)
        for place in places:
            held[place] = True
        return StaticBoundary(held, values.copy())

    def free(self, nodes: int) -> NDArray[np.bool_]:
        return ~self.held

    def prescribed_motion(self, t: float, nodes: int) -> Array:
        return np.array([self.values, 0 * self.values, 0 * self.values])

    def load(self, nodes: int) -> Array:
        return np.zeros_like(self.values)

    def slanted_friction(self, q: Array, reaction: Array) -> None:
        return None

    def friction_load(self, nodes: int) -> Array:
        return np.zeros_like(self.values)


def held_at(q: Array, *places: Any) -> Mask:
    """Return what is held: these ``places`` of ``q`` (nodes, 7), given as indices."""
    held = np.zeros(q.shape, dtype=bool)
    for place in places:
        held[place] = True
    return held


def held_rod(rope: Rope, gravity: float, q: Array, held: Mask) -> Equations:
    """``rope`` on equal elements, held as it is in the shape ``q`` (nodes, 7)."""
    lengths = np.full(len(q) - 1, rope.length / (len(q) - 1))
    return Equations.of(rope, gravity, lengths, q, held)


#: index of what moves a rope out of its plane
OUT_OF_PLANE = np.s_[:, [2, 5, 6]]


def clamped(q: Array) -> StaticBoundary:
    """Both ends of ``q`` held, place, direction and angle; they may stretch, along the axis that they lie on."""
    boundary = StaticBoundary.at(q, [0, -1])
    boundary.held[[0, -1], 3 + np.argmax(np.abs(q[[0, -1], 3:6]), axis=1)] = False
    return boundary


def rod(rope: Rope, gravity: float, q: Array, boundary: StaticBoundary) -> RopeSystem:
    """``rope`` on equal elements, near the shape ``q`` (nodes, 7)."""
    elements = len(q) - 1
    lengths = np.full(elements, rope.length / elements)
    return RopeSystem(
        RopeKernels(elements), lengths, np.array(parameters(rope, gravity)), boundary, q
    )


def turned(system: RopeSystem, q: Array, angle: float) -> Equilibrium:
    """At rest after the far end of ``q``, whose angles count along it, is turned by ``angle`` (rad) more."""
    guess = q.copy()
    guess[:, ANGLE] += angle * np.linspace(0.0, 1.0, len(q))
    return find_equilibrium(system.with_boundary(clamped(guess)), guess)
