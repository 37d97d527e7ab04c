"""Pressed pieces of an element's curve, and the places over which contact is integrated there.

An element is looked at in CELLS.  In a cell the depth p(xi) = d/2 - distance, d the rope's diameter, turns once at
most: found by halving between slopes of different signs.  On either side of that it is monotone, and reaches 0 and the
spring's onset once: found by Newton's method from outside, which a straight piece at a convex body never leaves.  The
integral is taken by Gauss points from the deeper end to the onset, and from there to where the pressure ends:

    int f(p(xi)) dxi = sum over cells, sides, {deeper end .. onset, onset .. 0} of sum_k w_k f(p(xi_k))

so that it follows the rope without a jump, however short the contact is and wherever it goes on along the rope.  The
law is 0 where the pressure ends, and goes on smoothly elsewhere: the bounds' derivatives drop out of the tangent.

Works on numbers and CasADi expressions; a and b are the rows r, r' of an element's nodes.
"""

from typing import Any, NamedTuple

from rope_model.physics.contact import ONSET
from rope_model.physics.elementary import dot, larger, less, sign, where
from rope_model.physics.hermite import GAUSS, interpolate
from rope_model.physics.shaft import distance, normal

#: parts of an element, checked one by one: the loop's elements turn by half a radian, those of the legs are nearly
#: straight
CELLS = 4
#: halvings to the place where the depth turns, which one step by its slopes follows; steps to where it has a value
HALVINGS, STEPS = 10, 10
#: m: a depth is reached that is missed by less
FOUND = 1e-12
#: a slope (m) that divides is no less
TINY = 1e-30
#: levels of the depth, in diameters, at which a piece ends, from the deeper end on
LEVELS = (ONSET, 0.0)
#: Gauss points of a piece: places from its deeper end, and weights
PARTS, WEIGHTS = tuple(x for x, _ in GAUSS), tuple(w for _, w in GAUSS)


class Probe(NamedTuple):
    """A place from 0 to 1 in the element, how deep the rope is pressed in there (m), and the derivative of that."""

    place: float
    depth: float
    rate: float


def probe(place: Any, l: Any, a: Any, b: Any, diameter: Any, body: Any) -> Probe:
    """The element looked at in one ``place``."""
    values = [interpolate(place, l, a[k], a[3 + k], b[k], b[3 + k]) for k in range(3)]
    point, slope = tuple(r for r, _ in values), tuple(d for _, d in values)
    return Probe(place, 0.5 * diameter - distance(point, body), -l * dot(normal(point, body), slope))


def turning(start: Any, stop: Any) -> Any:
    """Place where the depth turns between two probes with rates of different signs, which change evenly."""
    return start.place + (stop.place - start.place) * (start.rate / nonzero(start.rate - stop.rate))


def reaching(outer: Any, inner: Any, level: Any) -> Any:
    """The next place at which to look for the depth ``level`` (m), between ``outer`` and the place ``inner``.

    By Newton's method from ``outer``, which is less deep; midway where that leads out.  Where the level is reached, the
    place of ``outer``.
    """
    missing = level - outer.depth
    at = outer.place + missing / nonzero(outer.rate)
    between = less((at - outer.place) * (at - inner), 0.0)
    following = where(between, at, 0.5 * (outer.place + inner))
    return where(less(FOUND, missing), following, outer.place)


def nonzero(x: Any) -> Any:
    """``x``, or TINY with its sign."""
    return sign(x) * larger(abs(x), TINY)


def point_in(part: Any, weight: Any, start: Any, stop: Any) -> tuple[Any, Any]:
    """Place and weight of the Gauss point with these in the piece between two places."""
    return start + part * (stop - start), weight * abs(stop - start)
