"""Accelerators of an iteration: the next forces to try from those tried and those that the rope answered.

x is what was tried and g(x) the answer, r = g(x) - x; each is a vector of forces in N. One object serves one step.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from hoist_demo.cosimulation.schemes.interface import Vector


class Accelerator(Protocol):
    """Proposes the next x."""

    def next(self, x: Vector, answer: Vector) -> Vector:
        """Return the forces to try after x, whose answer is known."""


class InterfaceJacobian:
    """Newton's method with a Jacobian dg/dx that is known beforehand, x + (1 - dg/dx)^-1 r."""

    def __init__(self, jacobian: Vector) -> None:
        self._matrix = np.eye(jacobian.shape[0]) - jacobian

    def next(self, x: Vector, answer: Vector) -> Vector:
        new: Vector = x + np.linalg.solve(self._matrix, answer - x)
        return new


class Aitken:
    """Relaxation with a factor from the last two residuals.

    Source: U. Kuettler and W. A. Wall, Fixed-point fluid-structure interaction solvers with dynamic relaxation,
    Computational Mechanics 43 (2008).
    """

    def __init__(self) -> None:
        self._factor, self._before = 1.0, np.zeros(0)

    def next(self, x: Vector, answer: Vector) -> Vector:
        r = answer - x
        if self._before.size:
            change = r - self._before
            size = float(change @ change)
            if size > 0.0:
                self._factor *= -float(self._before @ change) / size
        self._before = r
        new: Vector = x + self._factor * r
        return new


class Secant:
    """IQN-ILS: the inverse Jacobian by least squares from the differences of all tries of this step.

    Source: J. Degroote, K.-J. Bathe and J. Vierendeels, Performance of a new partitioned procedure versus a
    monolithic procedure in fluid-structure interaction, Computers and Structures 87 (2009).
    """

    def __init__(self) -> None:
        self._answers: list[Vector] = []
        self._residuals: list[Vector] = []

    def next(self, x: Vector, answer: Vector) -> Vector:
        r = answer - x
        self._answers.append(answer)
        self._residuals.append(r)
        if len(self._residuals) == 1:
            return answer
        # newest differences first; least squares of least norm forgets those that tell nothing new
        V = np.array([old - r for old in self._residuals[-2::-1]][: x.size]).T
        W = np.array([old - answer for old in self._answers[-2::-1]][: x.size]).T
        weights = np.linalg.lstsq(V, -r, rcond=1e-10)[0]
        new: Vector = answer + W @ weights
        return new
