"""Beam element with the permanent curvature of physics.initial_curvature.

physics.element has the energy

    U0 = int EI (1/2 |k0|^2 - k . k0) dx

beside that of bending.  While the element moves, the smallest rotation of the tangent carries k0 of
a section from its direction in the frame's reference.  k0 is then turned about the tangent by the
increase of

    theta(x) - (turn of the frame from the left node to x) + x/l (turn of the frame to the right
    node)

which is the section's angle where tau is uniform; so the energy stays when the present shape
becomes the reference.

Behind the frame's entries F has 12 numbers of the element in the reference: k0 at the three Gauss
points, theta at both nodes, and EI.
"""

from functools import cache
from typing import Any, NamedTuple

import casadi as ca

from rope_model.physics import element
from rope_model.physics.bending_element import bending_element
from rope_model.physics.elementary import dot, sqrt
from rope_model.physics.frame import (
    parallel_transport,
    rational_cos_sin,
    rotate_about_tangent,
    smallest_rotation_rate,
)
from rope_model.physics.initial_curvature import TO_POINTS
from rope_model.physics.node import NODE_DOF

#: number of entries of an element: k0 at its points, angles, and EI
CURVED_SIZE = 3 * len(element.POINTS) + 3


class CurvedFunctions(NamedTuple):
    """CasADi functions of permanent curvature in an element; ``C`` contains its CURVED_SIZE numbers.

    residual: (q, l, F, C) -> R (14,)
    tangent:  (q, l, F, C, c_q) -> J (14, 14)
    energy:   (q, l, F, C) -> J
    """

    residual: ca.Function
    tangent: ca.Function
    energy: ca.Function


@cache
def curved_functions() -> CurvedFunctions:
    """Build the functions."""
    relative = element.relative_coordinates()
    q = ca.SX.sym("q", 2 * NODE_DOF)
    l = ca.SX.sym("l")
    F = ca.SX.sym("F", element.FRAME_SIZE)
    C = ca.SX.sym("C", CURVED_SIZE)
    c_q = ca.SX.sym("c_q")
    numbers = ca.vertsplit(C)
    frames = ca.vertsplit(F[:-3], 6)
    before = numbers[-3:-1]
    EI = numbers[-1]
    B = [element.interpolation(xi, l) for xi in element.POINTS]
    z = [B_p @ relative @ q for B_p in B]
    turn = _turn_function()
    bend = _bend_function()
    f, f_z, f_zz = zip(*(turn(*pair) for pair in zip(z, frames, strict=True)), strict=True)
    # weights of the frame's turning in the angle of each point, relative to the element's linear
    # part
    parts = [
        [l * (to - xi * w) for to, w in zip(row, element.WEIGHTS, strict=True)]
        for row, xi in zip(TO_POINTS, element.POINTS, strict=True)
    ]
    angles: list[Any] = [
        (1 - xi) * before[0] + xi * before[1] + dot(row, f)
        for row, xi in zip(parts, element.POINTS, strict=True)
    ]
    W, W_z, W_zz = zip(
        *(bend(z[i], frames[i][:3], C[3 * i : 3 * i + 3], angles[i]) for i in range(len(B))),
        strict=True,
    )
    R = ca.SX.zeros(relative.shape[0])
    J = ca.SX.zeros(relative.shape[0], relative.shape[0])
    U = ca.SX(0)
    for i, (w, B_p) in enumerate(zip(element.WEIGHTS, B, strict=True)):
        # derivative of the angle at this point, and the effect of this point's turning on all
        # angles
        angle_x: Any = sum(
            (parts[i][k] * B[k].T @ f_z[k] for k in range(len(B))),
            start=ca.SX.zeros(relative.shape[0]),
        )
        coupled_weight: Any = sum(
            element.WEIGHTS[k] * W_z[k][6] * parts[k][i] for k in range(len(B))
        )
        R += B_p.T @ (w * W_z[i] - coupled_weight * f_z[i])
        J += B_p.T @ element.symmetric(w * W_zz[i] - coupled_weight * f_zz[i]) @ B_p
        coupled = w * (B_p.T @ W_zz[i][:, 6] - 0.5 * W_zz[i][6, 6] * angle_x)
        J -= coupled @ angle_x.T + angle_x @ coupled.T
        U += w * (0.5 * ca.sumsqr(C[3 * i : 3 * i + 3]) - W[i])
    R = relative.T @ R
    U = l * EI * U
    factor = -l * EI
    J = element.symmetric(c_q * factor * (relative.T @ element.symmetric(J) @ relative))
    inputs = [q, l, F, C]
    return CurvedFunctions(
        ca.Function("curved_residual", inputs, [ca.cse(factor * R)]),
        ca.Function("curved_tangent", [*inputs, c_q], [ca.cse(J)]),
        ca.Function("curved_energy", inputs, [ca.cse(U)]),
    )


def _turn_function() -> ca.Function:
    """Build (z, frame) -> turning of the frame along the rope at a point z = (r', r'', theta), and its derivatives."""
    z = ca.SX.sym("z", 7)
    frame = ca.SX.sym("frame", 6)
    f: Any = smallest_rotation_rate(frame[:3], frame[3:], z[0:3], z[3:6])
    f_zz, f_z = ca.hessian(f, z)
    return ca.Function("curved_turn", [z, frame], [ca.cse(x) for x in (f, f_z, f_zz)])


def _bend_function() -> ca.Function:
    """Build (z, p, k0 in the reference, angle there) -> k . k0 at a point z = (r', r'', theta), and its derivatives."""
    z = ca.SX.sym("z", 7)
    p = ca.SX.sym("p", 3)
    before = ca.SX.sym("before", 3)
    angle = ca.SX.sym("angle")
    d = z[0:3]
    c = z[3:6]
    square = dot(d, d)
    length = sqrt(square)
    t = [d[k] / length for k in range(3)]
    director = rotate_about_tangent(
        t, parallel_transport(p, t, before), *rational_cos_sin(z[6] - angle)
    )
    along = dot(ca.cross(d, c), director) / square
    along_zz, along_z = ca.hessian(along, z)
    return ca.Function(
        "curved_bend", [z, p, before, angle], [ca.cse(x) for x in (along, along_z, along_zz)]
    )


@cache
def curved_element(base: element.ElementFunctions) -> element.ElementFunctions:
    """Build the functions of the ``base`` torsional element with permanent curvature."""
    curved = curved_functions()
    return bending_element(base, CURVED_SIZE, curved.residual, curved.tangent, curved.energy)
