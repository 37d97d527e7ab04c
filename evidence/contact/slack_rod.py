"""A slack rod without weight, clamped at both ends, that is turned until it throws a loop which lies on itself.

The ends of the rod are on one axis, nearer to each other than it is long; one is turned, slowly.  Its slack gathers in
a buckle (evidence.validation.buckle has that of a long rod), which jumps into a loop where its torque no longer grows
with the turn, and the loop's legs press each other; evidence.contact.elastica_rod has the same in another code.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from evidence.stability.chain import StaticBoundary
from evidence.tables import Table, table
from evidence.validation.buckle import planar
from evidence.validation.statics import clamped, turned
from rope_model.numerics.generalized_alpha import Coefficients, Motion, restart, step
from rope_model.parameters import Rope, Scene
from rope_model.physics.rope_on_rope import APART
from rope_model.shaft_parameters import Contact, Shaft
from rope_model.simulation.contact.self_contact import SelfTouchingRope
from rope_model.simulation.mesh.transfer import interpolate
from rope_model.simulation.rope_kernels import RopeKernels
from rope_model.simulation.rope_system import ANGLE, POSITION, RopeSystem, arc_lengths, parameter_vector
from rope_model.simulation.stepping.statics import find_equilibrium

from .scenes import Array

#: m, and m by which the ends are nearer
LENGTH, SLACK = 12.0, 4.0
#: kg/m, N, N m^2, N m^2
MASS, AXIAL, BEND, TORSION = 8.0, 3e5, 200.0, 400.0
DIAMETER = Rope().diameter
#: turns at which the rod is looked at: twice with its buckle, twice with its loop
STATIONS = (0.5, 1.0, 1.75, 2.0)
#: turns: from here on ours moves, with this damping (s) and so many turns a second, in steps (s) of these at most,
#: until nothing is faster than that (m/s)
MOVING, DAMPING, RATE, STEP, STILL = 1.25, 1.0, 0.05, 0.1, 2e-4
#: N/m^2, of our contact, and our elements
STIFFNESS, ELEMENTS = 1e7, 60
#: of a table of such rods
COLUMNS = ("elements", "turns", "torque", "pull", "pressed", "first", "second")


@dataclass(frozen=True)
class Held:
    """The rod at rest: ``turns`` of its end, torque and pull at the clamps (N m, N), and the force of its legs (N).

    ``places`` are the arc lengths (m) at which its legs are nearest to each other.
    """

    turns: float
    torque: float
    pull: float
    pressed: float
    places: tuple[float, float]


@dataclass(frozen=True)
class Turning(StaticBoundary):
    """Held as a StaticBoundary, the angle of the far end growing at ``rate`` (rad/s)."""

    rate: float = 0.0

    def prescribed_motion(self, t: float, nodes: int) -> Array:
        v = np.zeros_like(self.values)
        v[-1, ANGLE] = self.rate
        return np.array([self.values, v, 0 * v])


def nearest(points: Array, s: Array) -> tuple[float, float]:
    """Arc lengths of the two places, farther apart along the rod than contact looks for, that are nearest."""
    gaps = np.linalg.norm(points[:, None] - points[None], axis=2)
    gaps[np.abs(s[:, None] - s[None]) < APART * DIAMETER] = math.inf
    first, second = np.unravel_index(np.argmin(gaps), gaps.shape)
    return float(s[min(first, second)]), float(s[max(first, second)])


@cache
def held_rods() -> tuple[Held, ...]:
    """Ours at STATIONS."""
    return tuple(_at_stations(ELEMENTS))


def slack_table() -> Table:
    """Ours, as PyElastica's is recorded."""
    found = [(ELEMENTS, x.turns, x.torque, x.pull, x.pressed, *x.places) for x in held_rods()]
    return table(COLUMNS, found)


def _at_stations(elements: int) -> Iterator[Held]:
    system, q = _buckle(elements)
    turns, motion = 0.0, None
    for station in STATIONS:
        while turns < min(station, MOVING) - 1e-9:
            part = min(1.0 / 12.0, station - turns)
            q, turns = turned(system, q, 2.0 * math.pi * part).q, turns + part
        if turns < station - 1e-9:
            motion = _turn_in_motion(system, motion or _start(system, q), 2.0 * math.pi * (station - turns))
            q, turns = motion.q, station
        yield _measure(system, q, station)


def _buckle(elements: int) -> tuple[SelfTouchingRope, Array]:
    """Untwisted, at rest in its plane."""
    rope = Rope(LENGTH, MASS, AXIAL, 0.0, 0.0, TORSION, EI=BEND, diameter=DIAMETER, beta_K=DAMPING)
    scene = Scene(rope=rope, shaft=Shaft(contact=Contact(rope_stiffness=STIFFNESS, friction=0.0)))
    q = planar(LENGTH, SLACK, elements)
    lengths = np.full(elements, LENGTH / elements)
    parts = RopeKernels(elements), lengths, parameter_vector(rope, 0.0), clamped(q), q
    system = SelfTouchingRope(scene, *parts)
    return system, find_equilibrium(system, q).q


def _start(system: RopeSystem, q: Array) -> Motion:
    rest = np.zeros_like(q)
    return restart(_turning(system, q, 0.0, 0.0), 0.0, q, rest, rest)[0]


def _turn_in_motion(system: RopeSystem, motion: Motion, angle: float) -> Motion:
    """At rest after the far end has been turned by ``angle`` (rad), in motion: as it jumps, it must meet itself."""
    left, start, method = angle, motion.t, Coefficients(0.6)
    fastest = math.inf
    while left > 0.0 or fastest > STILL:
        fastest = float(np.abs(motion.v[:, POSITION]).max())
        h = min(STEP, 0.25 * DIAMETER / max(fastest, 1e-6))
        # the rate comes up within a second, and stops at the end
        rate = min(2.0 * math.pi * RATE * min(1.0, motion.t + h - start), left / h)
        now = _turning(system, motion.q, rate, h)
        found = step(now, motion, h, method, 3e-6).motion
        if found is None:
            raise RuntimeError("a step of the rod failed; make STEP shorter")
        motion, left = _along(now, found), left - rate * h
    return motion


def _turning(system: RopeSystem, q: Array, rate: float, h: float) -> RopeSystem:
    held, values = clamped(q).held, q.copy()
    values[-1, ANGLE] += rate * h
    return system.with_reference(q).with_boundary(Turning(held, values, rate))


def _along(system: RopeSystem, m: Motion) -> Motion:
    """``m`` with its angles counted along itself."""
    gained = system.transport(m.q, m.v, m.a)
    q, v, a, b = fields = [x.copy() for x in (m.q, m.v, m.a, m.b)]
    for x, more in zip(fields, (*gained, gained[2]), strict=True):
        x[:, ANGLE] += more
    return Motion(m.t, q, v, a, b, m.a_rate, m.h, m.reaction)


def _measure(system: SelfTouchingRope, q: Array, turns: float) -> Held:
    rest = np.zeros_like(q)
    R = system.with_reference(q).evaluate(q, rest, rest, rest).reaction
    on_legs = np.zeros_like(q)
    system.touches(q, rest).take_force(on_legs)
    pressed = float(np.linalg.norm(on_legs[: len(q) // 2, POSITION].sum(axis=0)))
    s = np.linspace(0.0, LENGTH, 1201)
    points = interpolate(q, arc_lengths(system.lengths), s)[:, POSITION]
    torque = 0.5 * float(R[-1, ANGLE] - R[0, ANGLE])
    return Held(turns, torque, 0.5 * float(R[-1, 0] - R[0, 0]), pressed, nearest(points, s))
