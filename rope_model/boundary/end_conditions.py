"""Conditions at the ends of the rope: the pose of a plumb or leaning end, and its motion."""

from typing import Annotated

from rope_model.boundary.end_paths import EndMotion, EndPath
from rope_model.parameters import Scene
from rope_model.physics.elementary import (
    Scalar,
    Vector3,
    atan2,
    cos,
    hypot,
    maximum,
    minimum,
    sin,
    sqrt,
    where,
)

#: sense of the conveyance's yaw in theta, left and right, as of the tangent in Y
YAW_SENSE = (-1.0, 1.0)
MIN_LEAN_SQUARE = 1e-24  #: rad^2, squared lean below which C and S take their limits
SMALL_LEAN = 1e-5  #: rad^2, squared lean below which D and E take their limits


def held_end(
    path: EndPath, t: float, nominal_x: float, sense: float, angle: float
) -> Annotated[tuple[tuple[Scalar, ...], ...], 3, 7]:
    """Return position, velocity and acceleration (3, 7) at ``t`` of an end held at ``angle`` against its conveyance."""
    (x, y, z, yaw), (vx, vy, vz, yaw_rate), (ax, ay, az, yaw_acceleration) = path.motion(t)
    return (
        (nominal_x + x, y, z, 0.0, 0.0, 0.0, sense * yaw + angle),
        (vx, vy, vz, 0.0, 0.0, 0.0, sense * yaw_rate),
        (ax, ay, az, 0.0, 0.0, 0.0, sense * yaw_acceleration),
    )


def clamp_axis(lean: Vector3, lean_z: Vector3) -> Annotated[tuple[tuple[Scalar, ...], ...], 3, 3]:
    """Return the axis n of a clamp and its rates (3, 3), from the leans, a rotation vector, and their rates.

    n = (S lean, -C, S lean_z) with C = cos a, S = sin(a)/a for the angle a.  With p = a a_t,
    C_t = -S p, S_t = D p and D_t = E p.
    """
    x, x_t, x_tt = lean
    z, z_t, z_tt = lean_z
    square = x * x + z * z
    p = x * x_t + z * z_t
    p_t = x_t * x_t + z_t * z_t + x * x_tt + z * z_tt
    angle = sqrt(maximum(square, MIN_LEAN_SQUARE))
    C = cos(angle)
    S = sin(angle) / angle
    divisor = maximum(square, SMALL_LEAN)
    D = where(square > SMALL_LEAN, (C - S) / divisor, -1.0 / 3.0)
    E = where(square > SMALL_LEAN, -(S + 3.0 * D) / divisor, 1.0 / 15.0)
    (n_x, v_x, a_x), (n_z, v_z, a_z) = (
        (S * w, D * p * w + S * w_t, (E * p * p + D * p_t) * w + 2.0 * D * p * w_t + S * w_tt)
        for w, w_t, w_tt in (lean, lean_z)
    )
    return (n_x, -C, n_z), (v_x, S * p, v_z), (a_x, D * p * p + S * p_t, a_z)


def partly_placed(
    scene: Scene, end: EndMotion, other_end: EndMotion, sense: Scalar, fraction: Scalar
) -> EndMotion:
    """Return ``end`` on its way from a rope hung in a loop (0) to its position and lean (1)."""
    x = other_end.x - end.x - sense * scene.layout.spacing
    z = other_end.z - end.z
    narrow = (
        HANGING_WIDTH
        * (scene.rope.length - abs(other_end.y - end.y))
        / maximum(hypot(x, z), MIN_LEAN_SQUARE)
    )
    shift = 0.5 * (1.0 - minimum(narrow, 1.0)) * (1.0 - fraction)
    x = end.x + shift * x
    z = end.z + shift * z
    return EndMotion(
        x, end.y, z, yaw=end.yaw, lean=fraction * end.lean, lean_z=fraction * end.lean_z
    )


def right_offset(left: Vector3, right: Vector3) -> Scalar:
    """Return the offset (rad) of theta at the right end of an untwisted rope in the vertical plane of its ends.

    Turning that plane by psi about Y turns the frame by psi at the left end, by -psi at the right.
    """
    return 2.0 * atan2(right[2] - left[2], right[0] - left[0])


#: width between the ends over the length of the loop in which a rope is first hung up
HANGING_WIDTH = 0.4
