"""Legs that are turned about each other until they lie in a two-strand ply: with what is exact about it.

Both held ends turn and twist the rope, slowly and in thick air, so that it is at rest all the time.  Two strands with
bending stiffness B and twisting moment M lie in helices of radius a and angle alpha to the vertical, without friction;
the vertical force in each is n, and no moment about their axis comes from below.  Moments balance where

    -M cos 2 alpha / a = 2 B sin^3 alpha cos alpha / a^2 + n sin alpha

Source: Thompson, van der Heijden and Neukirch, Proc. R. Soc. A 458 (2002), for the ply.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from evidence.contact.scenes import WEIGHT, unexplained
from evidence.ropes import at_rest, follow
from evidence.tables import Array
from rope_model import EndMotion
from rope_model.parameters import Layout, Rope, Scene
from rope_model.physics.node import arc_lengths
from rope_model.reference.transfer import interpolated
from rope_model.shaft_parameters import Air, Contact, Shaft
from rope_model.solver_parameters import Mesh

#: m, m, elements; s that the ends turn, by how many turns each, and s, half of that where the legs strike each other
LENGTH = 10.0
SPACING = 0.5
ELEMENTS = 40
TIME = 60.0
TURNS = 4.0
FAST = 4.0
#: m: between these heights the ply is far from both its ends
PLY = (-3.4, -2.2)


class Turned(NamedTuple):
    """Turns of the legs about each other and torque (N m) in the rope as they grow, from the first touch on.

    ``angle`` is that of the helices where the ply is even, over what the moments' balance gives; ``unexplained`` is
    energy over the work of the ends, ``crossings`` the times that the legs passed through each other.
    """

    turns: Array
    torque: Array
    angle: float
    unexplained: float
    crossings: float


def turned(friction: float) -> Turned:
    """The rope turned by ``TURNS`` at either end."""
    contact = Contact(rope_stiffness=1e7, friction=friction)
    scene = _scene(Shaft(contact=contact, air=Air(density=100.0, drag=10.0)))
    found = at_rest(scene)
    read = found.reader(("loop.turns", "left.swivel.torque", "contact.rope", "loop.crossings"))
    turns, torque, force, crossings = np.abs(
        follow(found, 0.02, TIME, lambda t: 2 * (_end(t, TIME),), read)
    ).T
    first = int(np.argmax(force > 0))
    ply = helix(found.state.motion.q, found.state.partition.lengths, np.linspace(*PLY, 200))
    moment = float(torque[-1]) / ply.radius
    bending = scene.rope.EI / ply.radius**2
    n = 0.5 * WEIGHT * ply.below

    def missing(a: float) -> float:
        return (
            moment * math.cos(2.0 * a)
            - 2.0 * bending * math.sin(a) ** 3 * math.cos(a)
            - n * math.sin(a)
        )

    angle = ply.angle / float(brentq(missing, 0.0, 0.25 * math.pi))
    return Turned(turns[first:], torque[first:], angle, unexplained(found), float(crossings[-1]))


def struck_legs(stiffness: float) -> float:
    """Energy unexplained, of the work, where the rope is turned so fast that its legs strike and rebound."""
    found = at_rest(_scene(Shaft(contact=Contact(rope_stiffness=stiffness))))
    follow(found, 0.01, FAST, lambda t: 2 * (_end(t, 2.0 * FAST),))
    return unexplained(found)


def _scene(shaft: Shaft) -> Scene:
    rope = Rope(length=LENGTH, EI=200.0, Qb=0.0, Qc=0.0)
    return Scene(rope, Layout(SPACING), mesh=Mesh("eem", elements=ELEMENTS), shaft=shaft)


def _end(t: float, time: float) -> EndMotion:
    """An end turns at an even rate, which it comes to within a second, by ``TURNS`` in this ``time`` (s)."""
    rate = 2.0 * math.pi * TURNS / (time - 1.0)
    return EndMotion(yaw=rate * (t - 1.0 + math.exp(-t)), yaw_rate=rate * (1.0 - math.exp(-t)))


class Helix(NamedTuple):
    """Two strands about a vertical axis: angle (rad), radius, and how long the rope is below (m)."""

    angle: float
    radius: float
    below: float


def helix(q: Array, lengths: Array, heights: Array) -> Helix:
    """Means of the legs between the ``heights``."""
    s = np.linspace(0.0, lengths.sum(), 20 * lengths.size + 1)
    points = interpolated(q, arc_lengths(lengths), s).T
    bottom = int(np.argmin(points[1]))
    legs = [
        np.array([np.interp(heights, points[1, part], x[part]) for x in (points[0], points[2], s)])
        for part in (slice(bottom, None, -1), slice(bottom, None))
    ]
    x, z, between = legs[1] - legs[0]
    radius = 0.5 * float(np.hypot(x, z).mean())
    turn = np.unwrap(np.arctan2(z, x))
    angle = math.atan(radius * abs(float(np.polyfit(heights, turn, 1)[0])))
    return Helix(angle, radius, float(between.mean()))
