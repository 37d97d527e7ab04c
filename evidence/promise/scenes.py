"""Ropes, swivels, trips and communication steps from a seed: one seed tunes, another judges.

The published case has none of them.  Lengths, EI, jerk and friction are drawn evenly in their logarithms.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from evidence.promise.sine_stop import SineStop, sine_stop
from evidence.sampling import ACCELERATION, JERK, MASS, NEAR, SPACING, SPEED, STIFFNESS, Draws
from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model.parameters import Layout, Rope, Scene, Swivel, SwivelMode

#: seeds; scenes that are wound with the default, and how many of them with the other requests, too
TUNE = 60
JUDGE = 271
SCENES = 44
REQUESTED = 30
LENGTH = (40.0, 1200.0)  # m
BENDING = (40.0, 3000.0)  # N m^2
#: of steel wire ropes: d^2 (m^2) per mass per length; Qd (N m^2) over EA d^2
SECTION = 2.42e-4
TORSION = (0.008, 0.02)
#: Qb and Qc over EA d, at most as published; and over sqrt(EA Qd), beyond which the energy is not positive
COUPLING = 2.336e5 / (1.2e8 * 0.044)
MOST_COUPLED = 0.8
#: shares of trips that are stopped, of those by a sine, of releases, of ropes twisted when they were installed
STOPPED = 0.4
BY_SINE = 0.5
RELEASED = 0.2
TWISTED = 0.5
#: when stop and release begin, in parts of the trip's duration
BEGIN = (0.2, 0.8)
#: of an emergency stop, m/s^2 and m/s^3; of the rope, rad/m
BRAKE = (2.0, 5.0)
BRAKE_JERK = (5.0, 50.0)
TWIST = (-0.002, 0.002)
MODES: tuple[SwivelMode, ...] = ("locked", "free", "coulomb")
#: kinetic friction of swivels, from healthy to degraded bearings, and the static one over it
FRICTION = (0.0013, 0.08)
STATIC = 1.3
STEPS = (0.005, 0.01, 0.02, 0.04, 0.05)  # s
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
    def kind(self) -> str:
        """What happens on the way."""
        stopped = self.trip.emergency_at is not None
        released = self.scene.right.release_time > 0
        if stopped:
            return KINDS[1]
        if released:
            return KINDS[2]
        return KINDS[0]


def draw(seed: int, number: int) -> Iterator[Sample]:
    """The first ``number`` of a seed."""
    draws = Draws(seed)
    evenly = draws.evenly
    in_logarithms = draws.in_logarithms
    for k in range(number):
        length = in_logarithms(LENGTH)
        mass = evenly(MASS)
        diameter = math.sqrt(SECTION * mass)
        stiffness = mass * in_logarithms(STIFFNESS)
        torsion = stiffness * diameter**2 * in_logarithms(TORSION)
        coupling = min(
            evenly((0, COUPLING)) * stiffness * diameter,
            MOST_COUPLED * math.sqrt(stiffness * torsion),
        )
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
            installed_twist=evenly(TWIST) * length if evenly() < TWISTED else 0.0,
        )
        layout = Layout(evenly(SPACING))
        modes = [MODES[draws.one_of(len(MODES))] for _ in ("left", "right")]
        trip = Trip(
            travel=length * (1 - 2 * evenly(NEAR)),
            speed=evenly(SPEED),
            acceleration=evenly(ACCELERATION),
            jerk=in_logarithms(JERK),
            start_delay=0.0,
        )
        stopped = evenly() < STOPPED
        by_sine = evenly() < BY_SINE
        released = evenly() < RELEASED
        begin = evenly(BEGIN) * s_curve(trip).duration
        brake = evenly(BRAKE)
        jerk = in_logarithms(BRAKE_JERK)
        interval = STEPS[draws.one_of(len(STEPS))]
        if stopped:
            trip = replace(
                trip, emergency_at=begin, emergency_deceleration=brake, emergency_jerk=jerk
            )
        friction = in_logarithms(FRICTION)
        swivel = Swivel(
            mu_static=STATIC * friction,
            mu_kinetic=friction,
            inertia=max(0.05 * mass / 8, 1e-3),
            start="locked",
        )
        left, right = (replace(swivel, mode=mode) for mode in modes)
        if released and not stopped:
            right = replace(
                right, mode="free" if right.mode == "locked" else right.mode, release_time=begin
            )
        yield Sample(k, Scene(rope, layout, left, right), trip, interval, stopped and by_sine)
