"""Bodies in the shaft, and distances of the rope from them.

All are upright boxes with rounded edges, turned about Y; ends of long boxes are out of reach.  With
the position x of a point in the body's axes, from its centre, the half widths h and the radius c of
the edges

    q_k = |x_k| - h_k,    d = side ( |max(q, 0)| + min(max_k q_k, 0) - c )

is the distance from the body's surface, negative in the body: side is 1 where the rope hangs
outside of the box, -1 in a shaft, whose lining is the box.  Outside of a box, and inside of a
shaft, d is exact; its gradient is the unit normal, away from the body.  Its second derivatives jump
where the nearest point of the surface changes from a face to an edge.

Over an upright box about x with half widths e in the body's axes, the least distance is that with
q_k = |x_k| - h_k - side e_k: a bound for the rope's centre line between two of its points.  Works
on numbers, numpy arrays and CasADi expressions; vectors have their components first.
"""

from typing import NamedTuple

from rope_model.physics.elementary import (
    Scalar,
    Vector,
    Vector3,
    cos,
    less,
    maximum,
    minimum,
    sin,
    sqrt,
    unit_sign,
)
from rope_model.shaft_parameters import Conveyance, Divider, HeadRopes, Lining, Sump

#: m, longer than any shaft
ENDLESS = 1e6
#: m, thickness of the ground and length of head ropes; positions this far away are rounded by less
#: than 1e-11 m
DEEP = 1e4
#: kinds of bodies; the number of a kind is its index
KINDS = ("lining", "conveyance", "head_ropes", "divider", "floor")
#: m^2, keeps the root smooth where all of max(q, 0) vanishes; it is 1e-12 m off there
ROOT_SMOOTHING = 1e-24


class Body(NamedTuple):
    """Box in m: centre, half widths without the rounded edges, their radius, cosine and sine of its yaw, side."""

    centre: tuple[float, float, float]
    half: tuple[float, float, float]
    radius: float
    cosine: float
    sine: float
    side: float


def distance(point: Vector3, body: Body) -> Scalar:
    """Return the distance (m) of ``point`` (3,) from the body's surface; negative inside of the body."""
    x, y, z = _in_axes(
        point[0] - body.centre[0], point[1] - body.centre[1], point[2] - body.centre[2], body
    )
    return _distance(abs(x) - body.half[0], abs(y) - body.half[1], abs(z) - body.half[2], body)


def min_distance(point: Vector3, extent: Vector3, body: Body) -> Scalar:
    """Return the smallest distance (m) over the box about ``point`` with half widths ``extent`` along X, Y, Z."""
    x, y, z = _in_axes(
        point[0] - body.centre[0], point[1] - body.centre[1], point[2] - body.centre[2], body
    )
    c = abs(body.cosine)
    s = abs(body.sine)
    across = c * extent[0] + s * extent[2]
    along = s * extent[0] + c * extent[2]
    return _distance(
        abs(x) - body.half[0] - body.side * across,
        abs(y) - body.half[1] - body.side * extent[1],
        abs(z) - body.half[2] - body.side * along,
        body,
    )


def normal(point: Vector, body: Body) -> tuple[Scalar, Scalar, Scalar]:
    """Return the unit normal at ``point`` (3,), away from the body: the gradient of its distance."""
    local = _in_axes(
        point[0] - body.centre[0], point[1] - body.centre[1], point[2] - body.centre[2], body
    )
    q = [abs(x) - h for x, h in zip(local, (body.half[0], body.half[1], body.half[2]), strict=True)]
    out = [maximum(x, 0.0) for x in q]
    root = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2] + ROOT_SMOOTHING)
    # within the box the normal is that of the nearest face
    largest = maximum(maximum(q[0], q[1]), q[2])
    faces = [(1.0 - less(0.0, x)) * (1.0 - less(x, largest)) for x in q]
    x, y, z = (
        body.side * unit_sign(p) * (o / root + face)
        for p, o, face in zip(local, out, faces, strict=True)
    )
    return body.cosine * x + body.sine * z, y, body.cosine * z - body.sine * x


def _in_axes(x: Scalar, y: Scalar, z: Scalar, body: Body) -> tuple[Scalar, Scalar, Scalar]:
    return body.cosine * x - body.sine * z, y, body.sine * x + body.cosine * z


def _distance(x: Scalar, y: Scalar, z: Scalar, body: Body) -> Scalar:
    a = maximum(x, 0.0)
    b = maximum(y, 0.0)
    c = maximum(z, 0.0)
    within = minimum(maximum(maximum(x, y), z), 0.0)
    return body.side * (sqrt(a * a + b * b + c * c + ROOT_SMOOTHING) + within - body.radius)


def lining(lining: Lining) -> Body:
    """Return the wall, with the rope inside."""
    x = 0.5 * lining.width
    z = 0.5 * lining.depth
    radius = lining.rounding * minimum(x, z)
    return Body(
        (lining.x, 0.0, lining.z), (x - radius, ENDLESS, z - radius), radius, 1.0, 0.0, -1.0
    )


def conveyance(conveyance: Conveyance, end: Vector3) -> Body:
    """Return the conveyance from which the rope's ``end`` (3,) hangs; it moves with that end."""
    half = 0.5 * conveyance.width, 0.5 * conveyance.height, 0.5 * conveyance.depth
    return Body((end[0], end[1] + conveyance.above + half[1], end[2]), half, 0.0, 1.0, 0.0, 1.0)


def head_ropes(head_ropes: HeadRopes, conveyance: Conveyance, end: Vector3) -> Body:
    """Return the ropes above that conveyance; they begin at its top and move sideways with it."""
    centre = end[0], end[1] + conveyance.above + conveyance.height + DEEP, end[2]
    return Body(centre, (0.0, DEEP, 0.5 * head_ropes.row), 0.5 * head_ropes.diameter, 1.0, 0.0, 1.0)


def divider(divider: Divider) -> Body:
    """Return a horizontal beam."""
    radius = 0.5 * divider.rounding * divider.size
    half = 0.5 * divider.size - radius
    c = cos(divider.direction)
    s = sin(divider.direction)
    return Body(
        (divider.offset * c, divider.y, -divider.offset * s),
        (half, half, ENDLESS),
        radius,
        c,
        s,
        1.0,
    )


def floor(sump: Sump) -> Body:
    """Return the ground below the sump's level."""
    return Body((0.0, sump.level - DEEP, 0.0), (ENDLESS, DEEP, ENDLESS), 0.0, 1.0, 0.0, 1.0)
