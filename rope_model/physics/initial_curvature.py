"""Permanent curvature of a rope, as a reel leaves it, and the direction across the rope in which it lies.

Where nothing bends the rope it has the curvature vector k0, per reference length, and bent otherwise it stores

    1/2 EI |k - k0|^2                  (J/m)

k0 lies in the cross-section and turns with it.  Seen from a vector that goes along the rope without turning about the
tangent, it is turned by theta and the angle that it has at the left end:

    k0 = x (cos(a + theta) e1 + sin(a + theta) e2) + y (cos(a + theta) e2 - sin(a + theta) e1)

with e1 = Z, e2 = -X at the left end, where the tangent is -Y.  So a = 0 bends the rope as the loop between two
conveyances is bent.  x is the uniform curvature and what is added to it along that direction, y what is added across.

Within an element e1 goes by the smallest rotation from the left node's tangent p to t, and back by its turn about the
tangent on the way (physics.frame), which three Gauss points integrate.
"""

from typing import Any

import numpy as np

from rope_model.physics import hermite
from rope_model.physics.element import POINTS, WEIGHTS
from rope_model.physics.elementary import cos, dot, hypot, larger, sin, sqrt
from rope_model.physics.frame import carried, smallest_rotation_rate, turned

#: e1 where the tangent is -Y
START = (0.0, 0.0, 1.0)


def _integrals_to(places: tuple[float, ...]) -> tuple[tuple[float, ...], ...]:
    """Rows: weights of the values at POINTS in the integral from 0 to each of the places, for a parabola."""
    powers = np.arange(3)
    of_values = np.linalg.inv(np.array(POINTS)[:, None] ** powers)
    rows = np.array(places)[:, None] ** (powers + 1) / (powers + 1) @ of_values
    return tuple(map(tuple, rows.tolist()))


#: what is added to it, by the end of its name: around which sixth of the length, and the sixths to where it is 0
_ADDED = {"left": (0, 3), "1": (1, 1), "2": (2, 1), "middle": (3, 3), "4": (4, 1), "5": (5, 1), "right": (6, 3)}
#: values of a rope's permanent curvature, 1/m
CURVATURES = ("initial_curvature", *(f"curvature_{name}{way}" for way in ("", "_across") for name in _ADDED))


def most_curvature(rope: Any) -> Any:
    """Return the largest permanent curvature (1/m) along the rope: 0 of a straight one alone."""
    largest = 0.0
    for sixth in range(7):
        largest = larger(hypot(*_curvature(rope, sixth)), largest)
    return largest


def curvature_components(rope: Any, s: Any, l: Any) -> tuple[Any, ...]:
    """Components (1/m) along e1 of no twist at the POINTS of an element from ``s`` on, then those along e2: (6,)."""
    c, t = cos(rope.initial_curvature_angle), sin(rope.initial_curvature_angle)
    pairs = [_curvature(rope, 6 * (s + xi * l) / rope.length) for xi in POINTS]
    return *(c * x - t * y for x, y in pairs), *(t * x + c * y for x, y in pairs)


def _curvature(rope: Any, x: Any) -> tuple[Any, Any]:
    """Permanent curvature (1/m) along its direction and across it, ``x`` sixths of the length from the left end."""
    along, across = rope.initial_curvature, 0.0
    for name, (middle, width) in _ADDED.items():
        hat = larger(1 - larger(x - middle, middle - x) / width, 0.0)
        along += hat * getattr(rope, f"curvature_{name}")
        across += hat * getattr(rope, f"curvature_{name}_across")
    return along, across


#: weights of the values at POINTS in their integral from the left node to each of them, in lengths of the element
TO_POINTS = _integrals_to(POINTS)


def curvature_vectors(components: Any, l: Any, nodes: Any, start: Any) -> tuple[Any, ...]:
    """k0 (1/m) at the three POINTS of an element with the ``nodes`` (14,), and e1 at its right node: (12,).

    ``start`` is e1 at its left node, ``components`` are curvature_components.
    """
    ends = [(nodes[k], nodes[3 + k], nodes[7 + k], nodes[10 + k]) for k in range(3)]
    slopes = [[hermite.interpolate(xi, l, *of)[1] for of in ends] for xi in POINTS]
    bends = [[hermite.bend(xi, l, *of) for of in ends] for xi in POINTS]
    p = _unit(nodes[3:6])
    turning = [smallest_rotation_rate(p, (0.0, 0.0, 0.0), d, c) for d, c in zip(slopes, bends, strict=True)]
    found: list[Any] = []
    for k, (xi, to, d) in enumerate(zip(POINTS, TO_POINTS, slopes, strict=True)):
        at = (1 - xi) * nodes[6] + xi * nodes[13] - l * dot(to, turning)
        x, y, c, t = components[k], components[3 + k], cos(at), sin(at)
        found += _turned(_unit(d), p, start, c * x - t * y, t * x + c * y)
    back = -l * dot(WEIGHTS, turning)
    return *found, *_turned(_unit(nodes[10:13]), p, start, cos(back), sin(back))


def _unit(d: Any) -> list[Any]:
    length = sqrt(dot(d, d))
    return [d[i] / length for i in range(3)]


def _turned(t: Any, p: Any, x: Any, along: Any, across: Any) -> list[Any]:
    """``x`` from the tangent p to t, then ``along`` times it and ``across`` times what is at a right angle to it."""
    return turned(t, carried(p, t, x), along, across)
