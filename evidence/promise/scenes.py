"""Ropes, swivels, trips and communication steps from a seed: one seed tunes, another judges.

The published case has none of them.  Lengths, EI and jerk are drawn evenly in their logarithms.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from evidence.sampling import ACCELERATION, BENDING, JERK, LENGTH, MASS, NEAR, SPACING, SPEED, STIFFNESS, Draws
from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model.parameters import Layout, Rope, Scene, Swivel, SwivelMode

from .sine_stop import SineStop, sine_stop

#: seeds; scenes of 31 and 33 showed what waves on the legs ask of the mesh, one of 32 what torsional waves ask of it
TUNE, JUDGE = 30, 34
#: of steel wire ropes: d^2 (m^2) per mass per length; Qd (N m^2) over EA d^2
SECTION, TORSION = 2.42e-4, (0.008, 0.02)
#: Qb and Qc over EA d, at most as published; and over sqrt(EA Qd), beyond which the energy is not positive
COUPLING, MOST_COUPLED = 2.336e5 / (1.2e8 * 0.044), 0.8
#: shares of trips with an emergency stop and with a release; when they begin, in parts of the trip's duration
STOPPED, RELEASED, BEGIN = 0.35, 0.2, (0.2, 0.8)
BRAKE = (2.0, 5.0)  # m/s^2
MODES: tuple[SwivelMode, ...] = ("locked", "free", "coulomb")
STEPS = (0.005, 0.01, 0.02)  # s
KINDS = ("smooth", "emergency stop", "release")


@dataclass(frozen=True)
class Sample:
    """A rope, what it is to do, and how often it is asked."""

    number: int
    scene: Scene
    trip: Trip
    interval: float  # s
    by_sine: bool = False  # an emergency stop whose deceleration is half a wave

    @property
    def trajectory(self) -> Trajectory | SineStop:
        """How the left end moves."""
        return sine_stop(self.trip) if self.by_sine else s_curve(self.trip)

    @property
    def is_stopped(self) -> bool:
        """By the safety brake."""
        return self.trip.emergency_at is not None

    @property
    def is_released(self) -> bool:
        """One end's swivel, on the way."""
        return self.scene.right.release_time > 0

    @property
    def kind(self) -> str:
        """What happens on the way."""
        return KINDS[1 if self.is_stopped else 2 if self.is_released else 0]


def draw(seed: int, number: int) -> Iterator[Sample]:
    """The first ``number`` of a seed."""
    draws = Draws(seed)
    evenly, in_logarithms = draws.evenly, draws.in_logarithms
    for k in range(number):
        length, mass = in_logarithms(LENGTH), evenly(MASS)
        diameter, stiffness = math.sqrt(SECTION * mass), mass * in_logarithms(STIFFNESS)
        torsion = stiffness * diameter**2 * in_logarithms(TORSION)
        coupling = min(evenly((0, COUPLING)) * stiffness * diameter, MOST_COUPLED * math.sqrt(stiffness * torsion))
        rope = Rope(
            length=length,
            mass_per_length=mass,
            EI=in_logarithms(BENDING),
            Qa=stiffness,
            Qb=coupling,
            Qc=coupling,
            Qd=torsion,
            rhoJ=mass * diameter**2 / 8,
            diameter=diameter,
        )
        layout, mode = Layout(evenly(SPACING)), MODES[draws.one_of(len(MODES))]
        travel = length * (1 - 2 * evenly(NEAR))
        speed, acceleration, jerk = evenly(SPEED), evenly(ACCELERATION), in_logarithms(JERK)
        trip = Trip(travel=travel, speed=speed, acceleration=acceleration, jerk=jerk, start_delay=0.0)
        stopped, released = evenly() < STOPPED, evenly() < RELEASED
        begin, brake, interval = evenly(BEGIN) * s_curve(trip).duration, evenly(BRAKE), STEPS[draws.one_of(len(STEPS))]
        if stopped:
            trip = replace(trip, emergency_at=begin, emergency_deceleration=brake)
        if released and not stopped:
            mode = "free" if mode == "locked" else mode
        swivel = Swivel(mode=mode, inertia=max(0.05 * mass / 8, 1e-3))
        right = replace(swivel, release_time=begin) if released and not stopped else swivel
        yield Sample(k, Scene(rope, layout, swivel, right), trip, interval)
