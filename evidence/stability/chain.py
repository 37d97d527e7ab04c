"""A rope held in any way, plain Newton on it, and its stability: what scenes without conveyances share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rope_model.simulation.outputs.modal import ROUNDING, softest
from rope_model.simulation.rope_system import ANGLE, RopeSystem
from rope_model.simulation.stepping.statics import find_equilibrium

from .entry import Array

STATIC = np.array([1.0, 0.0, 0.0])  # the stiffness alone

#: the shape at rest from a guess, or None; the angles of both count along them
Solve = Callable[[RopeSystem, Array], Array | None]


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


@dataclass(frozen=True)
class NewtonResult:
    """Where plain Newton arrived, whether it converged, and the largest unbalanced force (N, N m) before each step."""

    q: Array
    converged: bool
    unbalanced: Array


def plain_newton(system: RopeSystem, guess: Array, tolerance: float = 1e-9, most: int = 100) -> NewtonResult:
    """Full corrections with the tangent stiffness from ``guess``, until one is below ``tolerance``.

    The frame is that of the system all the way.
    """
    q = np.where(system.free, guess, system.prescribed_motion(0.0)[0])
    rest, unbalanced = np.zeros_like(q), []
    with np.errstate(all="ignore"):  # divergence is what the caller looks for
        for _ in range(most):
            x, R = system.newton_step(q, rest, rest, rest, STATIC)
            unbalanced.append(float(np.max(np.abs(np.where(system.free, R, 0.0)))))
            if not np.all(np.isfinite(x)):
                break
            q = q + x
            if np.max(np.abs(x)) < tolerance:
                return NewtonResult(q, True, np.array(unbalanced))
    return NewtonResult(q, False, np.array(unbalanced))


def by_newton(system: RopeSystem, q: Array) -> Array | None:
    found = plain_newton(system, q)
    if not found.converged:
        return None
    found.q[:, ANGLE] += system.frame_turn(found.q)
    return found.q


def by_continuation(system: RopeSystem, q: Array) -> Array | None:
    return find_equilibrium(system, q).q


def potential(balance: dict[str, float]) -> float:
    """Strain and potential energy, J."""
    return sum(balance[name] for name in ("axial", "coupling", "torsion", "bending", "gravity"))


def is_stable(system: RopeSystem, q: Array) -> bool:
    """Whether no small motion lowers the energy; the angles count along ``q``."""
    return softest(system.with_reference(q), q) > -ROUNDING
