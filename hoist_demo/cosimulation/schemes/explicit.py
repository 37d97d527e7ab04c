"""Schemes that do each step once, with extrapolated data of the other partner.

A polynomial through the last samples is continued over the next step: order 0 holds the last value,
1 continues the line and 2 the parabola through the last two and three. The samples need not be
evenly spaced; as long as there are too few the order is lower. Source: M. Busch, Zur effizienten
Kopplung von Simulationsprogrammen, 2012, chapter 3. Schemes of order n are of the order n + 1 in H.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hoist_demo.cosimulation.schemes import interface
from hoist_demo.cosimulation.schemes.interface import (
    Advance,
    CoupledSystem,
    DriveLoad,
    SchemeState,
    Vector,
)

Coefficients = tuple[Vector, Vector, Vector]
#: Weights of the samples, latest first, in the extrapolated step's mean, by order
#: (Adams-Bashforth).
MEAN_WEIGHTS = ((1.0,), (1.5, -0.5), (23.0 / 12.0, -16.0 / 12.0, 5.0 / 12.0))


def extrapolation_coefficients(
    samples: Sequence[interface.Sample], name: str, order: int, h: float
) -> Coefficients:
    """Return c0, c1, c2 of c0 + c1 s + c2 s^2 over the next step of h [s], s = 0 .. 1.

    ``name`` is the field of Sample that is extrapolated.
    """
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
    quadratic = (slope - before) / -t_before
    return last, slope - quadratic * t, quadratic


@dataclass(frozen=True)
class Extrapolated:
    """Base of the schemes that extrapolate to ``order`` 0, 1 or 2."""

    order: int
    needs_rollback: bool = False
    needs_added_mass: bool = False

    @property
    def weights(self) -> tuple[float, ...]:
        return MEAN_WEIGHTS[self.order]

    def extrapolated_load(self, scheme_state: SchemeState, h: float) -> DriveLoad:
        """Return the rope's past forces, extrapolated over the next step of h [s]."""
        start, linear, quadratic = extrapolation_coefficients(
            scheme_state.samples, "force", self.order, h
        )
        return DriveLoad(start, linear, quadratic, added_mass=np.zeros(start.shape))


class GaussSeidel(Extrapolated):
    """The drive first with extrapolated forces, then the rope along the motion of the drive."""

    def advance(
        self, coupled: CoupledSystem, scheme_state: SchemeState, t: float, h: float
    ) -> Advance:
        return coupled.exchange(scheme_state, t, h, self.extrapolated_load(scheme_state, h))


class Jacobi(Extrapolated):
    """Both partners with extrapolated data of the other; they may run at the same time.

    The drive gets extrapolated forces. The rope gets the motion of extrapolated accelerations from
    the drive's place and speed at the step's start,

        y(1) = y + h v + h^2 (c0/2 + c1/6 + c2/12) ,
        v(1) = v + h (c0 + c1/2 + c2/3) ,   a(1) = c0 + c1 + c2 ;

    holding the place itself would move the rope's end by jumps.
    """

    def advance(
        self, coupled: CoupledSystem, scheme_state: SchemeState, t: float, h: float
    ) -> Advance:
        load = self.extrapolated_load(scheme_state, h)
        c0, c1, c2 = extrapolation_coefficients(scheme_state.samples, "acceleration", self.order, h)
        now = coupled.drive.motion(load, 0.0)
        expected = interface.InterfaceMotion(
            position=now.position + h * now.speed + h * h * (c0 / 2.0 + c1 / 6.0 + c2 / 12.0),
            speed=now.speed + h * (c0 + c1 / 2.0 + c2 / 3.0),
            acceleration=c0 + c1 + c2,
        )
        status = coupled.step_drive(t, h, load)
        if status.valid:
            status = coupled.step_rope(t, h, expected)
        if not status.valid:
            return Advance(scheme_state, status)
        force, _ = coupled.forces()
        return Advance(coupled.exchanged(scheme_state, t + h, DriveLoad.constant(force)))


@dataclass(frozen=True)
class SemiImplicit(Extrapolated):
    """The rope's force is expected to change with the acceleration of the step that is being done.

        F(s) = F_e(s) - m_a (a - a_e(s))

    with extrapolated F_e and a_e and the rope's added mass m_a. The difference a - a_e is 0 at the
    step's start and grows, as in the definition of the added mass. The drive solves for its own
    acceleration under this load, so that no step is taken twice. Source: the idea of B. Schweizer
    and D. Lu, Predictor/corrector co-simulation approaches for solver coupling with algebraic
    constraints, ZAMM 95 (2015), with the added mass in place of the coupling Jacobian.
    """

    needs_added_mass: bool = True

    def advance(
        self, coupled: CoupledSystem, scheme_state: SchemeState, t: float, h: float
    ) -> Advance:
        added = coupled.added_mass()
        force = extrapolation_coefficients(scheme_state.samples, "force", self.order, h)
        acceleration = extrapolation_coefficients(
            scheme_state.samples, "acceleration", self.order, h
        )
        start, linear, quadratic = (f + added * a for f, a in zip(force, acceleration, strict=True))
        return coupled.exchange(scheme_state, t, h, DriveLoad(start, linear, quadratic, added))


@dataclass(frozen=True)
class ImpulsePreserving:
    """Gauss-Seidel with the rope's mean force of the last step held; of first order.

    The mean carries the impulse of the step, which the force at its end does not: the impulse of
    one partner reaches the other one step late, and complete.
    """

    weights: tuple[float, ...] = (0.5, 0.5)  # weights of the forces at both ends of the last step
    needs_rollback: bool = False
    needs_added_mass: bool = False

    def advance(
        self, coupled: CoupledSystem, scheme_state: SchemeState, t: float, h: float
    ) -> Advance:
        return coupled.exchange(scheme_state, t, h, DriveLoad.constant(scheme_state.last.mean))
