"""Contact detection along an element: its pressed pieces, and the Gauss points of contact on them.

An element is checked in CELLS.  In a cell the penetration depth p(xi) = d/2 - distance, d the
rope's diameter, has at most one extremum, which is found by bisection between slopes of different
signs.  On either side of it the depth is monotone and reaches 0 and the spring's onset once.
Newton's method finds these from outside, which it never leaves for a straight piece at a convex
body.  The integral is taken by Gauss points from the deeper end to the onset, and from there to
where the pressure ends:

    int f(p(xi)) dxi = sum over cells, sides, {deeper end .. onset, onset .. 0} of sum_k w_k
    f(p(xi_k))

It changes continuously as the contact moves along the rope, however short the contact is.  The law
is 0 where the pressure ends and smooth elsewhere, so that derivatives of the bounds drop out of the
tangent.  Works on numbers and CasADi expressions; a and b are the rows r, r' of an element's nodes.
"""

from typing import NamedTuple

from rope_model.physics.contact import ONSET
from rope_model.physics.elementary import Scalar, dot, less, maximum, unit_sign, where
from rope_model.physics.hermite import GAUSS, interpolate
from rope_model.physics.node import PointRow
from rope_model.physics.shaft import Body, distance, normal

#: parts of an element that are checked one by one: an element in the loop turns by half a radian,
#: legs are nearly straight
CELLS = 4
#: bisections for the extremum of the depth, which one secant step of the slopes follows
HALVINGS = 10
STEPS = 10  #: Newton steps for a level of the depth
#: m, tolerance of a depth that is searched for
DEPTH_TOLERANCE = 1e-12
#: m, least size of a slope that divides
LEAST_SLOPE = 1e-30
#: depths, in diameters, at which a piece ends, from the deeper end on
LEVELS = (ONSET, 0.0)
PARTS = tuple(x for x, _ in GAUSS)  #: Gauss points of a piece, from its deeper end
WEIGHTS = tuple(w for _, w in GAUSS)


class Probe(NamedTuple):
    """Element coordinate xi in [0, 1] (``place``), penetration depth (m) and its derivative with respect to xi."""

    place: float
    depth: float
    rate: float


def probe(xi: Scalar, l: Scalar, a: PointRow, b: PointRow, diameter: Scalar, body: Body) -> Probe:
    """Return the penetration depth of the element at ``xi``."""
    values = [interpolate(xi, l, a[k], a[3 + k], b[k], b[3 + k]) for k in range(3)]
    point = tuple(r for r, _ in values)
    slope = tuple(d for _, d in values)
    return Probe(xi, 0.5 * diameter - distance(point, body), -l * dot(normal(point, body), slope))


def turning(start: Probe, stop: Probe) -> Scalar:
    """Return xi of the extremum of the depth between two probes, as if its rate changed linearly between them."""
    return start.place + (stop.place - start.place) * (start.rate / nonzero(start.rate - stop.rate))


def reaching(outer: Probe, inner: Scalar, level: Scalar) -> Scalar:
    """Return the next xi of the search for the depth ``level`` (m), between ``outer`` and xi ``inner``.

    It is that of Newton's method from ``outer``, which is less deep, or midway if that leaves the
    interval.  If the level is reached, it is the xi of ``outer``.
    """
    missing = level - outer.depth
    candidate = outer.place + missing / nonzero(outer.rate)
    inside = less((candidate - outer.place) * (candidate - inner), 0.0)
    next_xi = where(inside, candidate, 0.5 * (outer.place + inner))
    return where(less(DEPTH_TOLERANCE, missing), next_xi, outer.place)


def nonzero(x: Scalar) -> Scalar:
    """Return ``x``, or LEAST_SLOPE with its sign."""
    return unit_sign(x) * maximum(abs(x), LEAST_SLOPE)


def contact_point(
    fraction: Scalar, weight: Scalar, start: Scalar, stop: Scalar
) -> tuple[Scalar, Scalar]:
    """Return xi and weight of a Gauss point, which has ``fraction`` and ``weight`` in the unit interval, on a piece."""
    return start + fraction * (stop - start), weight * abs(stop - start)
