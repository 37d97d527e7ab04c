"""A rod in tension that winds up into a plectoneme of many turns, and the closed form of that.

Two clamped ends twist a rod whose loop hangs between them, so that its legs wind about each other; then they are drawn
apart until they hold it with a tension, and turned on while they give way so that the tension stays.  The plectoneme
takes in what they give.

A length l of the rod that lies there, two strands in helices of radius R and angle a to their axis, has the curvature
sin^2 a / R, presses itself with an energy U(p) per length of one strand, p = D - 2 R, and takes up the turn
l sin 2a / (2 R) of the ends: its writhe.  With the bending stiffness B, tension T and torque M what is to be least is

    l (B sin^4 a / (2 R^2) + U / 2 + T - M sin 2a / (2 R))

in l, a and R.  Torsion only adds what depends on M alone: how far the rod itself is twisted.  So

    M = 2 B sin^3 a cos a / (R cos 2a),     T + U / 2 = (B sin^4 a / R^2) (1/2 + 1 / cos 2a)
    U' = M sin 2a / (2 R^2) - B sin^4 a / R^3

and at this torque an end that turns once brings the ends nearer by 4 pi R / sin 2a.  The loop at its end and what joins
it to the straight rod move along as they are: they play no part.  For a hard rod R = D / 2 and U = 0.  Ours hangs: what
lies there comes down by l / 2, and T is less by half of the weight of it all.

Source: N. Clauvelin, B. Audoly, S. Neukirch, Macromolecules 41 (2008), for the hard rod.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from evidence.contact.scenes import GRAVITY
from evidence.contact.turned import helix
from evidence.ropes import at_rest, follow, smooth_step
from rope_model import EndMotion
from rope_model.parameters import Layout, Rope, Scene
from rope_model.physics.rope_contact import self_contact_law
from rope_model.shaft_parameters import Air, Contact, Shaft
from rope_model.solver_parameters import Mesh, Solver

#: m, kg/m, N, N m^2, N m^2, m; heavy enough to hang down, and light against the tension
LENGTH = 12.0
MASS = 0.2
AXIAL = 1e6
BEND = 200.0
TORSION = 400.0
DIAMETER = Rope().diameter
#: m, elements, N/m^2 of the contact, N
SPACING = 0.5
ELEMENTS = 100
STIFFNESS = 1e7
TENSION = 1000.0
#: turns of twist, and s: put in while the loop hangs between the ends; drawn apart; more put in, and at rest
WOUND = 5.0
WINDING = 20.0
DRAWING = 20.0
GROWN = 1.5
GROWING = 20.0
RESTING = 10.0
#: an end gives way at so many m/s per N of tension that is missing, at most so fast (m/s), changing that within (s)
GIVE = 2e-3
FASTEST = 0.5
WITHIN = 0.2
#: s, the host's step; m, heights between which the plectoneme is far from both its ends
STEP = 0.02
HEIGHTS = (-2.3, -1.5)


class Plectoneme(NamedTuple):
    """A plectoneme under tension."""

    tension: float  # N
    torque: float  # N m
    nearer: float  # m, by which a turn brings the ends nearer
    angle: float  # rad
    radius: float  # m


def soft_rod(tension: float) -> Plectoneme:
    """The closed form of a rod that presses itself as ours does."""
    return _at_radius(
        tension, float(brentq(lambda R: _pressed(tension, R), 0.25 * DIAMETER, 0.5 * DIAMETER))
    )


def _at_radius(tension: float, R: float) -> Plectoneme:
    effective = tension + 0.5 * _law(R)[0]

    def missing(a: float) -> float:
        return BEND * math.sin(a) ** 4 / R**2 * (0.5 + 1.0 / math.cos(2.0 * a)) - effective

    a = float(brentq(missing, 1e-3, 0.249 * math.pi, xtol=1e-12))
    torque = 2.0 * BEND * math.sin(a) ** 3 * math.cos(a) / (R * math.cos(2.0 * a))
    return Plectoneme(tension, torque, 4.0 * math.pi * R / math.sin(2.0 * a), a, R)


def _pressed(tension: float, R: float) -> float:
    """By how much the strands press each other more than the spring at this radius does, N/m."""
    x = _at_radius(tension, R)
    strands = (
        x.torque * math.sin(2.0 * x.angle) / (2.0 * R**2) - BEND * math.sin(x.angle) ** 4 / R**3
    )
    return strands - _law(R)[1]


def _law(R: float) -> tuple[float, float]:
    """U (J/m) and U' (N/m) of strands a diameter 2 R apart."""
    rest = (0.0, 0.0, 0.0)
    sums = self_contact_law(_CONTACT, DIAMETER, (2.0 * R, 0.0, 0.0), rest, 0.0, 0.0).sums
    return float(sums[0]), float(sums[-1])


_CONTACT = Contact(rope_stiffness=STIFFNESS, friction=0.0)


class Grown(NamedTuple):
    """What is seen of ours, its tension less half the weight, and the times that its strands passed each other."""

    found: Plectoneme
    turns: float  # of its strands about each other
    crossings: float


@cache
def grown() -> Grown:
    """Ours, wound up and drawn, at rest before and after it grows."""
    rope = at_rest(
        Scene(
            Rope(LENGTH, MASS, AXIAL, 0.0, 0.0, TORSION, EI=BEND, diameter=DIAMETER),
            Layout(SPACING),
            mesh=Mesh("eem", elements=ELEMENTS),
            solver=Solver(step_max=STEP, tolerance=1e5),
            shaft=Shaft(contact=_CONTACT, air=Air(density=100.0, drag=10.0)),
        )
    )
    read = rope.reader(("left.fx", "left.swivel.torque", "loop.turns", "loop.crossings"))
    x = v = 0.0

    def ends(t: float) -> tuple[EndMotion, EndMotion]:
        """Either end, outwards where the rod pulls less than it is to; both together twist it."""
        nonlocal x, v
        wanted = np.clip(GIVE * (TENSION - read()[0]), -FASTEST, FASTEST) if t > WINDING else 0.0
        a = float(np.clip(wanted - v, -FASTEST, FASTEST)) / WITHIN if t > WINDING else 0.0
        x = x + STEP * (v + 0.5 * STEP * a)
        v = v + STEP * a
        turns, rate = _turned(t)
        yaw = {"yaw": math.pi * turns, "yaw_rate": math.pi * rate}
        left, right = (
            EndMotion(x=side * x, vx=side * v, ax=side * a, **yaw) for side in (-1.0, 1.0)
        )
        return left, right

    stop = WINDING + DRAWING + GROWING + RESTING
    course = follow(rope, STEP, stop, ends, lambda: (SPACING + 2.0 * x, *read()))
    wide, tension, torque, legs, crossings = course[[round((WINDING + DRAWING) / STEP) - 1, -1]].T
    state = rope.state
    seen = helix(state.motion.q, state.partition.lengths, np.linspace(*HEIGHTS, 200))
    nearer = float((wide[0] - wide[1]) / (_turned(stop)[0] - _turned(WINDING + DRAWING)[0]))
    hangs = 0.5 * MASS * GRAVITY * (LENGTH - float(wide[1]))
    found = Plectoneme(
        float(tension[1]) - hangs, float(abs(torque[1])), nearer, seen.angle, seen.radius
    )
    return Grown(found, float(abs(legs[1])), float(crossings[1]))


def _turned(t: float) -> tuple[float, float]:
    """Turns by which the rod is twisted, and turns a second."""
    _, wound, winds, _ = smooth_step(t / WINDING)
    _, grown, grows, _ = smooth_step((t - WINDING - DRAWING) / GROWING)
    return WOUND * wound + GROWN * grown, WOUND * winds / WINDING + GROWN * grows / GROWING
