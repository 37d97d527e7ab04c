"""Geometry of the rope's centre line: samples, distances from points and planes, bounding boxes, angles.

Works on numbers, numpy arrays and CasADi expressions; vectors have their components first.
"""

import math
from functools import reduce
from typing import Annotated, Protocol

from rope_model.parameters import Layout
from rope_model.physics.elementary import (
    SMALLEST_DIVISOR,
    Scalar,
    Vector,
    Vector2,
    Vector3,
    atan2,
    cos,
    dot,
    maximum,
    minimum,
    nearest_whole,
    sin,
)
from rope_model.physics.hermite import interpolate
from rope_model.physics.node import PointRow


class SuspensionPoint(Protocol):
    """Position (m) of a suspension point from its nominal point, as boundary.end_paths.EndMotion has it."""

    @property
    def x(self) -> Scalar: ...
    @property
    def y(self) -> Scalar: ...
    @property
    def z(self) -> Scalar: ...


def suspension_points(
    layout: Layout, left: SuspensionPoint, right: SuspensionPoint
) -> Annotated[tuple[tuple[Scalar, ...], tuple[Scalar, ...]], 2, 3]:
    """Return the suspension points (2, 3) of ends whose motions count from their nominal points."""
    half = 0.5 * layout.spacing
    return (-half + left.x, left.y, left.z), (half + right.x, right.y, right.z)


def sample_s(bottom_s: Scalar, reach: Scalar, fraction: Scalar, loop: Scalar) -> Scalar:
    """Return the arc length (m) of a sample at the ``fraction`` of the ``reach`` from ``bottom_s`` to an end.

    Near the bottom samples are as dense as if they had to cover twice the width of the ``loop`` (m)
    only, however long the legs are; farther away their distance grows.
    """
    even = minimum(2.0 * loop / maximum(abs(reach), loop), 1.0)
    square = fraction * fraction
    return bottom_s + reach * (even * fraction + (1.0 - even) * (square * square))


def squared_distance(point: Vector3, start: Vector3, along: Vector3) -> Scalar:
    """Return the squared distance (m^2) of ``point`` from the straight piece from ``start`` along ``along``."""
    across = point[0] - start[0], point[1] - start[1], point[2] - start[2]
    square = maximum(dot(along, along), SMALLEST_DIVISOR)  # a piece may be a point
    fraction = minimum(maximum(dot(across, along) / square, 0.0), 1.0)
    x = across[0] - fraction * along[0]
    y = across[1] - fraction * along[1]
    z = across[2] - fraction * along[2]
    return x * x + y * y + z * z


def min_squared_distance(a: PointRow, b: PointRow) -> Scalar:
    """Return a lower bound (m^2) of ``squared_distance`` between boxes (lowest, highest coordinates), even rounded."""
    x, y, z = (maximum(maximum(a[k] - b[3 + k], b[k] - a[3 + k]), 0.0) for k in range(3))
    return (1.0 - 1e-9) * (x * x + y * y + z * z)


def middle(length: Scalar, a: PointRow, b: PointRow) -> Annotated[tuple[Scalar, ...], 6]:
    """Return position and r' (6,) midway between two points of an element with theirs, ``length`` (m) apart."""
    values = [interpolate(0.5, length, a[k], a[3 + k], b[k], b[3 + k]) for k in range(3)]
    return (*(r for r, _ in values), *(d for _, d in values))


def position_at(
    xi: Scalar, length: Scalar, a: PointRow, b: PointRow
) -> Annotated[tuple[Scalar, ...], 3]:
    """Return the position (3,) at ``xi``, 0 to 1, between two points of an element with r', ``length`` (m) apart."""
    return tuple(interpolate(xi, length, a[k], a[3 + k], b[k], b[3 + k])[0] for k in range(3))


def lower_bound(
    known: Scalar, length: Scalar, a: Scalar, slope_a: Scalar, b: Scalar, slope_b: Scalar
) -> Scalar:
    """Return a lower bound of ``known`` and a coordinate's cubic from ``a``, not below ``known``, to ``b``.

    The cubic is within its control points.
    """
    third = length / 3.0
    return minimum(minimum(known, b), minimum(a + third * slope_a, b - third * slope_b))


def upper_bound(
    known: Scalar, length: Scalar, a: Scalar, slope_a: Scalar, b: Scalar, slope_b: Scalar
) -> Scalar:
    """Return an upper bound of ``known`` and a coordinate's cubic from ``a``, not above ``known``, to ``b``."""
    third = length / 3.0
    return maximum(maximum(known, b), maximum(a + third * slope_a, b - third * slope_b))


def box_between(bounds: Annotated[Vector, 6]) -> Annotated[tuple[Scalar, ...], 6]:
    """Return centre and half widths (6,) of the upright box with these lowest and highest coordinates (6,)."""
    pairs = [(bounds[k], bounds[3 + k]) for k in range(3)]
    return (*(0.5 * (x + y) for x, y in pairs), *(0.5 * (y - x) for x, y in pairs))


def enclosing_box(length: Scalar, a: PointRow, b: PointRow) -> Annotated[tuple[Scalar, ...], 6]:
    """Return centre and half widths (6,) of an upright box that contains the cubic between ``a`` and ``b``."""
    bounds = [
        of(a[k], length, a[k], a[3 + k], b[k], b[3 + k])
        for of in (lower_bound, upper_bound)
        for k in range(3)
    ]
    return box_between(bounds)


def heading(yaw: Scalar) -> tuple[Scalar, Scalar]:
    """Return the horizontal unit vector (X, Z) of a yaw (rad) about Y."""
    return cos(yaw), -sin(yaw)


def line_yaw(left: Vector3, right: Vector3) -> Scalar:
    """Return the yaw (rad) of the line from the left to the right end."""
    return atan2(left[2] - right[2], right[0] - left[0])


def plane_between(
    left: Vector3, right: Vector3, start: Vector3, direction: Vector2
) -> tuple[Scalar, Scalar, Scalar]:
    """Return the normal of the plane through ``start``, level across a horizontal ``direction`` (X, Z).

    At the height of the higher end the plane passes midway between the ends ``left`` and ``right``.
    """
    rise = maximum(left[1], right[1]) - start[1]
    return (
        direction[0],
        -0.5 * (reach(left, start, direction) + reach(right, start, direction)) / rise,
        direction[1],
    )


def reach(point: Vector, start: Vector, direction: Vector) -> Scalar:
    """Return the distance (m) of ``point`` from ``start`` along a horizontal ``direction`` (X, Z)."""
    return direction[0] * (point[0] - start[0]) + direction[1] * (point[2] - start[2])


def beyond(point: Vector, start: Vector, normal: Vector) -> Scalar:
    """Return the distance of ``point`` from the plane through ``start``, in lengths of its ``normal``."""
    return dot(normal, (point[0] - start[0], point[1] - start[1], point[2] - start[2]))


def margin(point: Vector, lowest_point: Vector, diameter: Scalar, above: Scalar) -> Scalar:
    """Return the least distance (m) from the plane that keeps legs a diameter apart; 0 at the lowest point.

    ``above`` (m) is the height above that point up to which it grows.
    """
    return diameter * minimum((point[1] - lowest_point[1]) / above, 1.0)


def side_gap(
    side: Scalar,
    length: Scalar,
    outer: PointRow,
    inner: PointRow,
    top: Scalar,
    start: Vector3,
    normal: Vector3,
    diameter: Scalar,
    above: Scalar,
) -> Scalar:
    """Return the least gap (m) of an element of a leg, from its ``outer`` to its ``inner`` node, excluding the latter.

    It is the distance beyond the margin on its ``side`` of the plane (-1: left, 1: right), or below
    the height ``top``.  The control points of the cubic bound it: long elements may bulge over a
    plane far from their nodes.
    """
    third = -side * (length / 3.0)
    ahead = tuple(outer[k] + third * outer[3 + k] for k in range(3))
    behind = tuple(inner[k] - third * inner[3 + k] for k in range(3))
    points = outer, ahead, behind
    gaps = [side * beyond(x, start, normal) - margin(x, start, diameter, above) for x in points]
    return reduce(minimum, (*gaps, *(top - x[1] for x in points)))


def min_slope(length: Scalar, a: PointRow, b: PointRow, direction: Vector2) -> Scalar:
    """Return a lower bound of the slope, in a horizontal ``direction``, of the cubic between two points.

    They are ``length`` (m) apart and come with their r'; the slope's lowest control point is that bound.
    """
    start, stop = (direction[0] * x[3] + direction[1] * x[5] for x in (a, b))
    return minimum(minimum(start, stop), 3.0 * reach(b, a, direction) / length - start - stop)


def turns(yaw: Scalar, line: Scalar, passages: Scalar) -> Scalar:
    """Return the turns of one side of the rope about the other.

    The loop has yawed to ``yaw`` (rad), the line between the ends to ``line`` (rad); each net
    passage of ``passages`` through the other side takes one turn away.
    """
    return (yaw - line) / (2.0 * math.pi) - passages


def angle_between(before: Vector2, after: Vector2) -> Scalar:
    """Return the angle (rad) about Y from one horizontal vector (X, Z) to another."""
    return atan2(
        before[1] * after[0] - before[0] * after[1], before[0] * after[0] + before[1] * after[1]
    )


def nearest_turn(angle: Scalar, last: Scalar) -> Scalar:
    """Unwrap ``angle`` (rad): add the full turns that bring it closest to ``last``."""
    return angle + 2 * math.pi * nearest_whole((last - angle) / (2 * math.pi))
