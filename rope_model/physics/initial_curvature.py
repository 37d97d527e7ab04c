"""Permanent curvature of a rope, as a reel leaves it, and the direction across the rope in which it lies.

Where nothing bends the rope it has the curvature vector k0 d, per reference length, and bent otherwise it stores

    1/2 EI |k - k0 d|^2                  (J/m)

The director d lies in the cross-section and turns with it.  Seen from a vector that goes along the rope without turning
about the tangent, d is turned by theta and the angle that it has at the left end:

    d = cos(a + theta) e1 + sin(a + theta) e2,   e1 = Z, e2 = -X at the left end, where the tangent is -Y

so a = 0 bends the rope as the loop between two conveyances is bent.

Within an element e1 goes by the smallest rotation from the left node's tangent p to t, and back by its turn about the
tangent on the way (physics.frame), which three Gauss points integrate.
"""

from typing import Any

import numpy as np

from rope_model.physics import hermite
from rope_model.physics.element import POINTS, WEIGHTS
from rope_model.physics.elementary import cos, dot, sin, sqrt
from rope_model.physics.frame import carried, smallest_rotation_rate, turned

#: e1 where the tangent is -Y
START = (0.0, 0.0, 1.0)


def _integrals_to(places: tuple[float, ...]) -> tuple[tuple[float, ...], ...]:
    """Rows: weights of the values at POINTS in the integral from 0 to each of the places, for a parabola."""
    powers = np.arange(3)
    of_values = np.linalg.inv(np.array(POINTS)[:, None] ** powers)
    rows = np.array(places)[:, None] ** (powers + 1) / (powers + 1) @ of_values
    return tuple(map(tuple, rows.tolist()))


#: weights of the values at POINTS in their integral from the left node to each of them, in lengths of the element
TO_POINTS = _integrals_to(POINTS)


def directors(angle: Any, l: Any, nodes: Any, start: Any) -> tuple[Any, ...]:
    """d at the three POINTS of an element with the ``nodes`` (14,), and e1 at its right node: (12,).

    ``start`` is e1 at its left node, ``angle`` that of d at the left end.
    """
    ends = [(nodes[k], nodes[3 + k], nodes[7 + k], nodes[10 + k]) for k in range(3)]
    slopes = [[hermite.interpolate(xi, l, *of)[1] for of in ends] for xi in POINTS]
    bends = [[hermite.bend(xi, l, *of) for of in ends] for xi in POINTS]
    p = _unit(nodes[3:6])
    turning = [smallest_rotation_rate(p, (0.0, 0.0, 0.0), d, c) for d, c in zip(slopes, bends, strict=True)]
    found: list[Any] = []
    for xi, to, d in zip(POINTS, TO_POINTS, slopes, strict=True):
        at = angle + (1 - xi) * nodes[6] + xi * nodes[13] - l * dot(to, turning)
        found += _turned(_unit(d), p, start, at)
    return *found, *_turned(_unit(nodes[10:13]), p, start, -l * dot(WEIGHTS, turning))


def _unit(d: Any) -> list[Any]:
    length = sqrt(dot(d, d))
    return [d[i] / length for i in range(3)]


def _turned(t: Any, p: Any, x: Any, angle: Any) -> list[Any]:
    """``x`` from the tangent p to t, and turned about that."""
    return turned(t, carried(p, t, x), cos(angle), sin(angle))
