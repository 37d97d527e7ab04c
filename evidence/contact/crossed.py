"""Two straight strings that cross at a distance below their diameter, and the force between them.

The law is one per length of the first string, at the distance of each of its places from the second: with the gap g and
the angle a of the two

    F = int s(D - sqrt(g^2 + x^2 sin^2 a)) g / sqrt(g^2 + x^2 sin^2 a) dx
"""

from __future__ import annotations

import math

import numpy as np

from rope_model.parameters import Rope, Scene
from rope_model.physics.contact import ONSET
from rope_model.shaft_parameters import Contact, Shaft
from rope_model.simulation.contact.self_contact import touches_of

from .scenes import Array

#: m, N/m^2, and the gap in diameters
DIAMETER, STIFFNESS, GAP = Rope().diameter, 1e6, 0.85
#: m: places along the first string at which the second one crosses it
PLACES = (0.0, 0.002, 0.004, 0.006, 0.008)


def crossing(gap: float, angle: float, along: float = 0.0) -> tuple[Array, Array]:
    """A rope in which two straight strings of 2 m cross, the second above the first, and a wide loop between them.

    Returns its rows (nodes, 7) and the lengths of its elements.
    """
    q = np.zeros((6, 7))
    for k, (nodes, turn, z) in enumerate(((range(3), 0.0, 0.0), (range(3, 6), math.pi + angle, gap))):
        tangent = np.array([math.cos(turn), math.sin(turn), 0.0])
        for node, s in zip(nodes, (-1.0, along + 0.013 * k, 1.0), strict=True):
            q[node, :3], q[node, 3:6] = s * tangent + [0.0, 0.0, z], tangent
    return q, np.array([1.0 + along, 1.0 - along, 6.0, 1.013 + along, 0.987 - along])


def force_error(degrees: float) -> float:
    """By how much the force is off at most, of the exact one, as the strings move along each other."""
    scene = Scene(shaft=Shaft(contact=Contact(rope_stiffness=STIFFNESS)))
    angle, gap = math.radians(degrees), GAP * DIAMETER
    exact, worst = exact_force(gap, math.sin(angle)), 0.0
    for along in PLACES:
        q, lengths = crossing(gap, angle, along)
        R = np.zeros_like(q)
        touches_of(scene, q, np.zeros_like(q), lengths, 0.0, 0.0).take_force(R)
        worst = max(worst, abs(float(R[:3, 2].sum()) / exact - 1.0))
    return worst


def exact_force(gap: float, sine: float) -> float:
    """The integral above, of strings whose angle has this sine."""
    number, reach = 200000, math.sqrt(DIAMETER**2 - gap**2) / sine
    distance = np.hypot(gap, (np.arange(number) + 0.5) / number * reach * sine)
    pressed, onset = DIAMETER - distance, ONSET * DIAMETER
    soft = np.minimum(pressed, onset)
    spring = STIFFNESS * (soft * soft / (2.0 * onset) + pressed - soft)
    return 2.0 * reach * float((spring * gap / distance).mean())
