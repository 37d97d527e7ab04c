"""Contact of the rope with itself: leg on leg, loop on leg.

Points along the rope, closer than its diameter, are compared with the elements to the right of
their own that begin MIN_ARC diameters or more behind its end.  Several strands may lie around a
point: contact is with the nearest point, and with each next one that is MIN_ARC diameters or more
along the rope from those before.  Where the centre lines are nearer than a diameter, the law of
physics.contact holds between them, per length, with p = diameter - distance:

    f(r_a - r_b, v_a - v_b)  on the one,   -f  on the other,     distributed to the nodes of both elements

so that the forces of a pair cancel to the bit.  The distance is stationary at the nearest point, so
the spring force is the gradient of its energy.  Friction acts at the centre lines, a diameter
apart: the remaining couple is no torque in the rope.  Works on numbers and CasADi expressions;
vectors have their components first.
"""

import math

from rope_model.physics import hermite
from rope_model.physics.contact import ContactLaw, ContactTerms, contact_law
from rope_model.physics.elementary import (
    Scalar,
    Vector3,
    ceil,
    dot,
    floor,
    maximum,
    minimum,
)
from rope_model.physics.node import PointRow
from rope_model.physics.shaft import Body
from rope_model.shaft_parameters import Contact

#: distance of the points, in diameters: two ropes that cross do not slip between them
SPACING = 0.25
#: largest number of points in an element; longer thin elements are checked less closely
MAX_POINTS = 1000
#: diameters along the rope within which it does not touch itself: a full circle of a radius of five
MIN_ARC = 10.0 * math.pi
#: largest number of strands of equal diameter around one
MAX_STRANDS = 6
#: places in ContactTerms.tangent of the entries of the symmetric matrix (3, 3)
TANGENT_ENTRIES = ((0, 1, 2), (1, 3, 4), (2, 4, 5))
PROBES = (0.0, 0.25, 0.5, 0.75, 1.0)  #: xi at which the search for the nearest point starts
CORRECTIONS = 4  #: Newton corrections from the nearest of these
#: bound of the distance of two points over their arc length
STRETCH = 1.25


def number_of_points(l: Scalar, diameter: Scalar) -> Scalar:
    """Return the number of points that are checked in an element of length ``l``."""
    return minimum(ceil(l / (SPACING * diameter)), float(MAX_POINTS))


def points_skipped(distance: Scalar, diameter: Scalar, spacing: Scalar, number: Scalar) -> Scalar:
    """Return how many of an element's next points need no check after one at ``distance`` (m).

    The points are ``spacing`` (m) apart.  All ``number`` of them are skipped if the distance is not
    a number.
    """
    return floor(maximum(minimum(number, (distance - diameter) / (STRETCH * spacing)), 0.0))


def max_points(length: Scalar, elements: Scalar, diameter: Scalar) -> Scalar:
    """Return the largest number of points of a rope in any mesh of so many elements."""
    return minimum(length / (SPACING * diameter) + elements, MAX_POINTS * elements)


def strands(s: list[float], reach: float) -> list[int]:
    """Return the indices of points ``s``, nearest first, on separate strands: ``reach`` or more from those before."""
    chosen: list[int] = []
    for n, s_n in enumerate(s):
        if len(chosen) < MAX_STRANDS and all(abs(s_n - s[before]) >= reach for before in chosen):
            chosen.append(n)
    return chosen


def nearer_xi(xi: Scalar, l: Scalar, point: Vector3, a: PointRow, b: PointRow) -> Scalar:
    """Return Newton's correction of ``xi`` towards the element's point nearest to ``point``; a, b: nodes' r, r'."""
    ends = [(a[k], a[3 + k], b[k], b[3 + k]) for k in range(3)]
    values = [hermite.interpolate(xi, l, *end) for end in ends]
    gap = [r - x for (r, _), x in zip(values, point, strict=True)]
    slope = [d for _, d in values]
    bend = [hermite.bend(xi, l, *end) for end in ends]
    square = dot(slope, slope)
    # beyond the centre of curvature the distance has no minimum
    second = maximum(square + dot(gap, bend), 0.25 * square)
    return minimum(maximum(xi - dot(gap, slope) / (l * second), 0.0), 1.0)


def self_contact_law(
    contact: Contact,
    diameter: Scalar,
    separation: Vector3,
    velocity: Vector3,
    c_q: Scalar,
    c_v: Scalar,
) -> ContactTerms:
    """Return the contact, per length, of a point at ``separation`` (3,) from another with relative ``velocity``."""
    law = ContactLaw(
        stiffness=contact.rope_stiffness,
        damping=contact.damping,
        friction=contact.friction,
        slip_speed=contact.slip_speed,
    )
    other = Body((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.5 * diameter, 1.0, 0.0, 1.0)
    return contact_law(law, diameter, other, (0.0, 0.0, 0.0), separation, velocity, c_q, c_v)
