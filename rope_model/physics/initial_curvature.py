"""Permanent curvature of a rope, as a reel leaves it, and its direction across the rope.

Without load the rope has the curvature vector k0, per reference length.  At the curvature k it
stores

    1/2 EI |k - k0|^2                  (J/m)

k0 lies in the cross-section and turns with it.  Relative to a vector that goes along the rope
without turning about the tangent, it is turned by theta and its angle a at the left end:

    k0 = x (cos(a + theta) e1 + sin(a + theta) e2) + y (cos(a + theta) e2 - sin(a + theta) e1)

with e1 = Z, e2 = -X at the left end where its tangent is -Y.  So a = 0 bends the rope as the loop
between two conveyances is bent.  A left end that leans, a clamp or a hinge, carries e1 with its
tangent without turning about it, as its section follows the tangent: physics.frame.

x is the uniform curvature plus additions in its direction, y the sum of additions across it.

Within an element the smallest rotation from the left node's tangent p to t carries e1, which is
then turned back by the frame's turning about the tangent (physics.frame), integrated over the three
Gauss points.
"""

from typing import Annotated, Any

import numpy as np

from rope_model.parameters import Rope
from rope_model.physics import hermite
from rope_model.physics.element import POINTS, WEIGHTS
from rope_model.physics.elementary import (
    Scalar,
    Vector,
    Vector3,
    cos,
    dot,
    hypot,
    maximum,
    sin,
    sqrt,
)
from rope_model.physics.frame import (
    parallel_transport,
    rotate_about_tangent,
    smallest_rotation_rate,
)
from rope_model.physics.node import ElementRows

#: the left end's tangent where it is plumb, and e1 there
PLUMB = (0.0, -1.0, 0.0)
START = (0.0, 0.0, 1.0)


def carried_director(e1: Vector3, before: Vector3, after: Vector3) -> tuple[Scalar, Scalar, Scalar]:
    """Return ``e1`` (3,) of the left end after its r' has turned from ``before`` to ``after`` (3,)."""
    x, y, z = parallel_transport(_unit(before), _unit(after), e1)
    return x, y, z


def _integrals_to(bounds: tuple[float, ...]) -> tuple[tuple[float, ...], ...]:
    """Return weights of the values at POINTS in the integral from 0 to each of the ``bounds``, exact for a parabola."""
    powers = np.arange(3)
    coefficients = np.linalg.inv(np.array(POINTS)[:, None] ** powers)
    return tuple(
        map(
            tuple,
            (np.array(bounds)[:, None] ** (powers + 1) / (powers + 1) @ coefficients).tolist(),
        )
    )


#: hat functions of added curvature, by the end of the parameter's name: centre and half width in
#: sixths of the length
_HATS = {
    "left": (0, 3),
    "1": (1, 1),
    "2": (2, 1),
    "middle": (3, 3),
    "4": (4, 1),
    "5": (5, 1),
    "right": (6, 3),
}
#: names of a rope's parameters of permanent curvature, 1/m
CURVATURES = (
    "initial_curvature",
    *(f"curvature_{name}{way}" for way in ("", "_across") for name in _HATS),
)


def max_curvature(rope: Rope) -> Scalar:
    """Return the largest permanent curvature (1/m) along the rope; 0 only for a straight rope."""
    largest = 0.0
    for sixth in range(7):
        largest = maximum(hypot(*_curvature(rope, sixth)), largest)
    return largest


def curvature_components(rope: Rope, s: Scalar, l: Scalar) -> Annotated[tuple[Scalar, ...], 6]:
    """Return components (1/m) along e1, then e2, at the POINTS of an untwisted element that begins at ``s`` (6,)."""
    c = cos(rope.initial_curvature_angle)
    t = sin(rope.initial_curvature_angle)
    pairs = [_curvature(rope, 6 * (s + xi * l) / rope.length) for xi in POINTS]
    return *(c * x - t * y for x, y in pairs), *(t * x + c * y for x, y in pairs)


def _curvature(rope: Rope, x: Scalar) -> tuple[Scalar, Scalar]:
    """Return the permanent curvature (1/m) along its direction and across it at ``x`` sixths of the length."""
    along = rope.initial_curvature
    across = 0.0
    for name, (middle, width) in _HATS.items():
        hat = maximum(1 - maximum(x - middle, middle - x) / width, 0.0)
        along += hat * getattr(rope, f"curvature_{name}")
        across += hat * getattr(rope, f"curvature_{name}_across")
    return along, across


#: weights of the values at POINTS in their integral from the left node to each of them, over the
#: element's length
TO_POINTS = _integrals_to(POINTS)


def curvature_vectors(
    components: Annotated[Vector, 6], l: Scalar, nodes: ElementRows, start: Vector3
) -> Annotated[tuple[Scalar, ...], 12]:
    """Return k0 (1/m) at the three POINTS of an element with the ``nodes`` (14,), then e1 at its right node (12,).

    ``start`` is e1 at its left node; ``components`` are curvature_components.
    """
    ends = [(nodes[k], nodes[3 + k], nodes[7 + k], nodes[10 + k]) for k in range(3)]
    slopes = [[hermite.interpolate(xi, l, *values)[1] for values in ends] for xi in POINTS]
    bends = [[hermite.bend(xi, l, *values) for values in ends] for xi in POINTS]
    p = _unit(nodes[3:6])
    turning = [
        smallest_rotation_rate(p, (0.0, 0.0, 0.0), d, c) for d, c in zip(slopes, bends, strict=True)
    ]
    vectors: list[Any] = []
    for k, (xi, to, d) in enumerate(zip(POINTS, TO_POINTS, slopes, strict=True)):
        angle = (1 - xi) * nodes[6] + xi * nodes[13] - l * dot(to, turning)
        x = components[k]
        y = components[3 + k]
        c = cos(angle)
        t = sin(angle)
        vectors += _turned(_unit(d), p, start, c * x - t * y, t * x + c * y)
    back = -l * dot(WEIGHTS, turning)
    return *vectors, *_turned(_unit(nodes[10:13]), p, start, cos(back), sin(back))


def _unit(d: Vector) -> list[Scalar]:
    length = sqrt(dot(d, d))
    return [d[i] / length for i in range(3)]


def _turned(t: Vector, p: Vector, x: Vector, along: Scalar, across: Scalar) -> list[Scalar]:
    """Carry ``x`` from the tangent p to t, then add ``along`` times it and ``across`` times its perpendicular."""
    return rotate_about_tangent(t, parallel_transport(p, t, x), along, across)
