"""Reference frame of the cross-sections, from which the angle theta is counted.

The frame follows the tangent t without turning about it.  In a known state, the reference, it turns
from section to section no more than the tangent does, so theta' is the torsional strain.  As the
rope moves, the smallest rotation carries the frame of each section from the section's tangent p in
the reference to t.  Along the rope it then turns about the tangent by

    twist = - (p x t) . (p' + t') / (1 + p . t)           (per reference length)

which is zero in the reference and singular only where t = -p; with p' = 0 and t_t for t' it is the
spin in time.  So a reference serves all states in which no section's tangent is reversed against
it.

Formulas take vectors with the components first: tuples, numpy arrays (3, n) or CasADi expressions.

The source measures theta from a frame of Tait-Bryan angles Z-Y-X instead, which is singular at t
parallel to Z: exactly when the loop has yawed 90 degrees.  evidence.stability keeps that frame to
show how it fails.
"""

from collections.abc import Callable
from typing import Annotated, Any

from rope_model.physics.elementary import Scalar, Vector, cross, dot, sqrt
from rope_model.physics.node import NodeRow

#: (p, p x p', r', change of r') -> turning of the reference frame about the tangent, for the same
#: change; p x p' is zero for changes in time
FrameRate = Callable[[Any, Any, Any, Any], Any]


def smallest_rotation_rate(p: Vector, turn: Vector, d: Vector, change: Vector) -> Scalar:
    """Return the frame's turning about the tangent as r' = ``d`` changes at rate ``change`` and p turns by ``turn``."""
    length = sqrt(dot(d, d))
    return (dot(turn, d) - dot(p, cross(d, change)) / length) / (length + dot(p, d))


def parallel_transport(p: Vector, t: Vector, x: Vector) -> list[Scalar]:
    """Return the vector ``x`` across the tangent p after the smallest rotation from p to t."""
    factor = dot(t, x) / (1.0 + dot(p, t))
    return [x[i] - factor * (p[i] + t[i]) for i in range(3)]


def rotate_about_tangent(t: Vector, x: Vector, c: Scalar, s: Scalar) -> list[Scalar]:
    """Return the vector ``x`` across the tangent t, turned about t by the angle with cosine ``c`` and sine ``s``."""
    across = cross(t, x)
    return [c * x[i] + s * across[i] for i in range(3)]


def rational_cos_sin(angle: Scalar) -> tuple[Scalar, Scalar]:
    """Return rational cosine and sine of an angle (rad) that differs from ``angle`` by about angle^7 / 1200."""
    half = 0.5 * angle * (1.0 + angle * angle / 12 * (1.0 + angle * angle / 10))
    return (1.0 - half * half) / (1.0 + half * half), 2.0 * half / (1.0 + half * half)


def end_moment(d: Vector, f: Vector, torque: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Return the moment (N m) of the conveyance on the rope's end, from the reaction ``f`` to r' = ``d`` and torque."""
    length = sqrt(dot(d, d))
    x, y, z = cross(d, f)
    return x + torque * (d[0] / length), y + torque * (d[1] / length), z + torque * (d[2] / length)


def conveyance_load(q: NodeRow, f: NodeRow, torque: Scalar) -> Annotated[tuple[Scalar, ...], 6]:
    """Return force (N) and moment (N m) of the rope on the conveyance, from coordinates and reaction of its end."""
    return *(-x for x in f[:3]), *(-x for x in end_moment(q[3:6], f[3:6], torque))
