"""Iteration with rollback: the step is repeated until drive and rope agree on the forces.

Over the step the drive's load is the parabola through the rope's force at its start, its mean and
its force at its end: unknown are x = (mean, end). Or the mean is held: unknown is x = mean. With
the rope's added mass m_a and the drive's accelerance B = da/dF

    d mean / d mean = -m_a B ,   d end / d mean = -m_a B ,   d end / d end = -m_a B / 2 ,

and the mean hardly follows the end. The first is exact for an end that is a mass and for one that
is an impedance, whose speed the mean determines. The other two are the middle between both: 0 and 2
m_a B, m_a B and 0. The parabola is of high order, but its force is continuous from step to step and
damps nothing: with a drive lighter than the rope's added mass the solution itself alternates. The
held mean is of first order and stable with any mass.

An accelerator gives the next x to try from those tried and the responses g(x) of the rope, with
r = g(x) - x.
"""

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from hoist_demo.cosimulation.schemes.explicit import extrapolation_coefficients
from hoist_demo.cosimulation.schemes.interface import (
    Advance,
    CoupledSystem,
    DriveLoad,
    SchemeState,
    Vector,
)
from rope_model import Status

AcceleratorName = Literal["jacobian", "aitken", "secant"]
ACCELERATORS: tuple[AcceleratorName, ...] = ("jacobian", "aitken", "secant")
MAX_EXCHANGES = 30  #: Tries of one step, after which it fails.
RANK_TOLERANCE = 1e-10  #: Singular values below this part of the largest one count as 0.


class Accelerator(Protocol):
    """Proposes the next x; one object serves one step."""

    def next(self, x: Vector, response: Vector) -> Vector:
        """Return the forces to try after x, whose response is known."""


class InterfaceJacobian:
    """Newton's method with a Jacobian dg/dx that is known beforehand, x + (1 - dg/dx)^-1 r."""

    def __init__(self, jacobian: Vector) -> None:
        self._matrix = np.eye(jacobian.shape[0]) - jacobian

    def next(self, x: Vector, response: Vector) -> Vector:
        return np.asarray(x + np.linalg.solve(self._matrix, response - x))


class Aitken:
    """Relaxation with a factor from the last two residuals.

    Source: U. Kuettler and W. A. Wall, Fixed-point fluid-structure interaction solvers with dynamic
    relaxation, Computational Mechanics 43 (2008).
    """

    def __init__(self) -> None:
        self._factor = 1.0
        self._last_residual: Vector | None = None

    def next(self, x: Vector, response: Vector) -> Vector:
        r = response - x
        if self._last_residual is not None:
            change = r - self._last_residual
            size = float(change @ change)
            if size > 0.0:
                self._factor *= -float(self._last_residual @ change) / size
        self._last_residual = r
        return np.asarray(x + self._factor * r)


class Secant:
    """IQN-ILS: the inverse Jacobian by least squares from all tries of this step.

    Source: J. Degroote, K.-J. Bathe and J. Vierendeels, Performance of a new partitioned procedure
    versus a monolithic procedure in fluid-structure interaction, Computers and Structures 87
    (2009).
    """

    def __init__(self) -> None:
        self._responses: list[Vector] = []
        self._residuals: list[Vector] = []

    def next(self, x: Vector, response: Vector) -> Vector:
        r = response - x
        self._responses.append(response)
        self._residuals.append(r)
        if len(self._residuals) == 1:
            return response
        # newest differences first; least squares of least norm drops those that add nothing new
        V = np.array([old - r for old in self._residuals[-2::-1]][: x.size]).T
        W = np.array([old - response for old in self._responses[-2::-1]][: x.size]).T
        return np.asarray(response + W @ np.linalg.lstsq(V, -r, rcond=RANK_TOLERANCE)[0])


@dataclass(frozen=True)
class Iterative:
    """Repeats a step until no force changes by more than ``tolerance`` [N]."""

    accelerator: AcceleratorName
    tolerance: float = 1.0  # N
    hold_mean: bool = False  # the mean over the step, instead of a parabola
    needs_rollback: bool = True

    @property
    def needs_added_mass(self) -> bool:
        """True if the Jacobian comes from the added mass."""
        return self.accelerator == "jacobian"

    @property
    def weights(self) -> tuple[float, ...]:
        """No weights when the mean is held; a parabola's bound is about that of a held force."""
        return () if self.hold_mean else (1.0,)

    def advance(
        self, coupled: CoupledSystem, scheme_state: SchemeState, t: float, h: float
    ) -> Advance:
        before = coupled.save()
        force = scheme_state.last.force
        x = self._first_guess(scheme_state, h)
        accelerator = self._accelerator(coupled)
        for trials in range(MAX_EXCHANGES):
            if trials:
                coupled.restore(before)
            load = self._load(force, x)
            status = coupled.step(t, h, load)
            if not status.valid:
                return Advance(scheme_state, status)
            end, mean = coupled.forces()
            response = self._unknown(mean, end)
            change = float(np.max(np.abs(response - x)))
            if change <= self.tolerance:
                return Advance(coupled.exchanged(scheme_state.with_taken_back(trials), t + h, load))
            x = accelerator.next(x, response)
        message = (
            f"coupling: after {MAX_EXCHANGES} exchanges the forces still change by {change:.3g} N, "
            f"tolerance {self.tolerance:g} N: take the accelerator secant, a shorter step or "
            "a larger tolerance"
        )
        return Advance(scheme_state, Status(False, message))

    def _first_guess(self, scheme_state: SchemeState, h: float) -> Vector:
        """Return the unknown forces that the past ones suggest."""
        order = 1 if self.hold_mean else 2
        force, linear, quadratic = extrapolation_coefficients(
            scheme_state.samples, "force", order, h
        )
        mean = force + linear / 2.0 + quadratic / 3.0
        return self._unknown(mean, force + linear + quadratic)

    def _load(self, start: Vector, x: Vector) -> DriveLoad:
        """Return the load of the unknown forces x in a step from the force ``start`` on."""
        if self.hold_mean:
            return DriveLoad.constant(x)
        mean, end = np.split(x, 2)
        return DriveLoad.through(start, mean, end)

    def _unknown(self, mean: Vector, end: Vector) -> Vector:
        """Return the unknown forces of a step with this mean and this force at its end."""
        if self.hold_mean:
            return mean
        return np.concatenate([mean, end])

    def _accelerator(self, coupled: CoupledSystem) -> Accelerator:
        if self.accelerator == "aitken":
            return Aitken()
        if self.accelerator == "secant":
            return Secant()
        response: Vector = -coupled.added_mass()[:, None] * coupled.drive.accelerance()
        if self.hold_mean:
            return InterfaceJacobian(response)
        no_response = np.zeros_like(response)
        return InterfaceJacobian(np.block([[response, no_response], [response, 0.5 * response]]))
