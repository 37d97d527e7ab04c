"""Ropes and trips from a seed: those that fit are others than those that judge.

The published case has none of them.  Lengths, EI and jerk are drawn evenly in their logarithms.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

from evidence.sampling import (
    ACCELERATION,
    BENDING,
    JERK,
    LENGTH,
    MASS,
    NEAR,
    SPACING,
    SPEED,
    STIFFNESS,
    Draws,
)
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model.parameters import Layout, Rope, Scene
from rope_model.physics.estimates import bending_length
from rope_model.solver_parameters import Mesh, Model, Solver

FIT = 20  # seed
JUDGE = 21  # seed
#: when an emergency stop begins, in parts of the smooth trip's duration
STOP = (0.3, 0.6)
STEP = 0.01  # s
KINDS = ("smooth", "emergency stop")


@dataclass(frozen=True)
class Sample:
    """An uncoupled rope between locked ends, and its trip, without and with an emergency stop."""

    number: int
    rope: Rope
    layout: Layout
    smooth: Trip
    stopped: Trip

    @cached_property
    def w(self) -> float:
        """(EI / rho g)^(1/3), m."""
        return float(bending_length(self.scene(Mesh())))

    def scene(self, mesh: Mesh, step: float = STEP) -> Scene:
        """With the planar model, which leaves nothing out of it; steps that no error measure shortens."""
        solver = Solver(step_max=step, tolerance=1e6)
        return Scene(self.rope, self.layout, mesh=mesh, solver=solver, model=Model("planar"))


def draw(seed: int, number: int) -> Iterator[Sample]:
    """The first ``number`` of a seed."""
    draws = Draws(seed)
    evenly = draws.evenly
    in_logarithms = draws.in_logarithms
    for k in range(number):
        length = in_logarithms(LENGTH)
        mass = evenly(MASS)
        rope = Rope(
            length=length,
            mass_per_length=mass,
            EI=in_logarithms(BENDING),
            Qa=mass * in_logarithms(STIFFNESS),
            Qb=0.0,
            Qc=0.0,
        )
        layout = Layout(evenly(SPACING))
        travel = length * (1 - 2 * evenly(NEAR))
        speed = evenly(SPEED)
        acceleration = evenly(ACCELERATION)
        jerk = in_logarithms(JERK)
        smooth = Trip(
            travel=travel, speed=speed, acceleration=acceleration, jerk=jerk, start_delay=0.0
        )
        stopped = replace(smooth, emergency_at=evenly(STOP) * s_curve(smooth).duration)
        yield Sample(k, rope, layout, smooth, stopped)
