"""Contact of the rope with itself: leg on leg, loop on leg.

Places stand along the rope, closer than its diameter.  Each is compared with the elements to the right of its
own that begin LEAST_ARC diameters or more behind its end.  Several strands may lie around it: the nearest place
counts, and each next one that is LEAST_ARC diameters or more along the rope from those before.  Where the centre lines
are nearer than a diameter, the law of physics.contact holds between them, per length, with p = diameter - distance:

    f(r_a - r_b, v_a - v_b)  on the one,   -f  on the other,     shared between the nodes of both elements

so that the forces of a pair cancel to the bit.  The nearest place is where the distance is stationary: the spring's
force is the gradient of its energy.  Friction pulls at the centre lines, a diameter apart: the couple that this leaves
is no torque in the rope.

Works on numbers and CasADi expressions; vectors have their components first.
"""

import math
from types import SimpleNamespace
from typing import Any

from rope_model.physics.contact import Touch, touch
from rope_model.physics.elementary import ceil, dot, floor, larger, smaller
from rope_model.physics.hermite import interpolate
from rope_model.physics.shaft import Body

#: distance of the places that are looked at, in diameters: two ropes that cross do not slip between them
SPACING = 0.25
#: in an element at most; longer ones that are so thin are looked at less closely
MOST_PLACES = 1000
#: diameters along the rope within which it does not touch itself: the circle that would takes a radius of five
LEAST_ARC = 10.0 * math.pi
#: most strands of equal diameter around one
MOST_STRANDS = 6
#: where in an element the nearest place is looked for first, and corrections from the best of these
PROBES, CORRECTIONS = (0.0, 0.25, 0.5, 0.75, 1.0), 4
#: places are no farther apart than so many times their distance along the rope
STRETCH = 1.25


def places(l: Any, diameter: Any) -> Any:
    """Number of places that are checked in an element of length ``l``."""
    return smaller(ceil(l / (SPACING * diameter)), float(MOST_PLACES))


def places_skipped(distance: Any, diameter: Any, weight: Any, number: Any) -> Any:
    """Number of an element's next places that need no check after one at ``distance`` (m).

    They are ``weight`` (m) apart.  All ``number`` of them where the distance is not a number.
    """
    return floor(larger(smaller(number, (distance - diameter) / (STRETCH * weight)), 0.0))


def most_places(length: Any, elements: Any, diameter: Any) -> Any:
    """Largest number of places of a rope, in any mesh of so many elements."""
    return smaller(length / (SPACING * diameter) + elements, MOST_PLACES * elements)


def nearer_place(xi: Any, l: Any, point: Any, a: Any, b: Any) -> Any:
    """Newton's correction of ``xi``, the place nearest to ``point`` between the rows r, r' of an element's nodes."""
    gap, slope, bend = [], [], []
    for k in range(3):
        r, d = interpolate(xi, l, a[k], a[3 + k], b[k], b[3 + k])
        curve = (6 - 12 * xi) * (b[k] - a[k]) + l * ((6 * xi - 4) * a[3 + k] + (6 * xi - 2) * b[3 + k])
        gap.append(r - point[k])
        slope.append(d)
        bend.append(curve / (l * l))
    square = dot(slope, slope)
    # beyond the centre of the bend the distance has no minimum
    second = larger(square + dot(gap, bend), 0.25 * square)
    return smaller(larger(xi - dot(gap, slope) / (l * second), 0.0), 1.0)


def self_contact_law(contact: Any, diameter: Any, apart: Any, speed: Any, cq: Any, cv: Any) -> Touch:
    """Contact, per length, of a place that is ``apart`` (3,) from another and moves with ``speed`` against it."""
    law = SimpleNamespace(**(vars(contact) | {"stiffness": contact.rope_stiffness}))
    other = Body((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.5 * diameter, 1.0, 0.0, 1.0)
    return touch(law, diameter, other, (0.0, 0.0, 0.0), apart, speed, cq, cv)
