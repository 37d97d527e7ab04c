"""Shapes at rest of a rope whose ends are clamped and turned."""

import numpy as np

from evidence.stability.chain import StaticBoundary
from evidence.tables import Array
from rope_model.parameters import Rope
from rope_model.simulation.rope_kernels import RopeKernels
from rope_model.simulation.rope_system import ANGLE, RopeSystem, parameter_vector
from rope_model.simulation.stepping.statics import Equilibrium, find_equilibrium


def clamped(q: Array) -> StaticBoundary:
    """Both ends of ``q`` held, place, direction and angle; they may stretch, along the axis that they lie on."""
    boundary = StaticBoundary.without_supports(q)
    boundary.held[[0, -1]] = True
    boundary.held[[0, -1], 3 + np.argmax(np.abs(q[[0, -1], 3:6]), axis=1)] = False
    return boundary


def rod(rope: Rope, gravity: float, q: Array, boundary: StaticBoundary) -> RopeSystem:
    """``rope`` on equal elements, near the shape ``q`` (nodes, 7)."""
    elements = len(q) - 1
    lengths = np.full(elements, rope.length / elements)
    return RopeSystem(RopeKernels(elements), lengths, parameter_vector(rope, gravity), boundary, q)


def turned(system: RopeSystem, q: Array, angle: float) -> Equilibrium:
    """At rest after the far end of ``q``, whose angles count along it, is turned by ``angle`` (rad) more."""
    guess = q.copy()
    guess[:, ANGLE] += angle * np.linspace(0.0, 1.0, len(q))
    return find_equilibrium(system.with_boundary(clamped(guess)), guess)
