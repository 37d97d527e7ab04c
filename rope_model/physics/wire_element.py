"""Beam element with friction between its wires: physics.element with the moment of physics.wire_friction.

At each Gauss point C z is added to the moment EI k, work-conjugate to the rate of k seen from the
section:

    R += int B^T C z dx,     J += c_q int B^T C dz/dk B dx

Behind the frame's entries F has HISTORY_SIZE numbers of the rope at the last accepted instant (at
each point section and z (10), then k0 and C) and TANGENT_SIZE numbers of the latest tangent.  The
tangent is symmetric: it leaves out the skew part of dz/dk and the change of B.  Where wires reverse
their sliding, dz/dk jumps up and down, and Newton's method with this tangent alone may oscillate
without end.  So the tangent is

    p dz/dk + (1 - p) |z| / |z if all wires stuck|,    p = (z predicted by the latest tangent) . z / |z|^2 in [0, 1]

which is safe where the latest tangent was far off, as well as without one, p = 0: Newton's method
for z and k together (T. F. Chan, G. H. Golub, P. Mulet, SIAM J. Sci. Comput. 20 (1999)).
"""

from functools import cache
from typing import Any, NamedTuple

import casadi as ca

from rope_model.physics import element
from rope_model.physics.bending_element import bending_element
from rope_model.physics.frame import smallest_rotation_rate
from rope_model.physics.node import NODE_DOF
from rope_model.physics.wire_friction import (
    POINT_STATE_SIZE,
    REGULARIZATION,
    bouc_wen_step,
    section,
    within,
)

#: number of entries of an element: state of its points, k0 and C
HISTORY_SIZE = POINT_STATE_SIZE * len(element.POINTS) + 2
#: number of entries of a point's latest tangent: k, z and the upper half of dz/dk
_POINT_TANGENT_SIZE = 12
#: number of entries of an element's latest tangents
TANGENT_SIZE = _POINT_TANGENT_SIZE * len(element.POINTS)


class WireFunctions(NamedTuple):
    """CasADi functions of friction between the wires in an element; ``H`` is its history (HISTORY_SIZE,).

    residual: (q, l, H) -> R (2 m,)
    tangent:  (q, l, H, latest, c_q) -> J (2 m, 2 m)
    latest:   (q, l, H, latest) -> ``latest`` after that tangent (TANGENT_SIZE,)
    energy:   (q, l, H) -> energy stored, J
    """

    residual: ca.Function
    tangent: ca.Function
    latest: ca.Function
    energy: ca.Function


@cache
def wire_functions(fidelity: element.ElementFidelity) -> WireFunctions:
    """Build the functions for a fidelity."""
    dofs = [
        *element.ELEMENT_DOF[fidelity],
        *(NODE_DOF + k for k in element.ELEMENT_DOF[fidelity]),
    ]
    symbol = ca.SX.sym("q", len(dofs))
    q = ca.SX.zeros(2 * NODE_DOF)
    q[dofs] = symbol
    l = ca.SX.sym("l")
    H = ca.SX.sym("H", HISTORY_SIZE)
    latest = ca.SX.sym("latest", TANGENT_SIZE)
    c_q = ca.SX.sym("c_q")
    *points, k0, C = ca.vertsplit(
        H, [*range(0, HISTORY_SIZE - 1, POINT_STATE_SIZE), HISTORY_SIZE - 1, HISTORY_SIZE]
    )
    relative = element.relative_coordinates()
    point = _point_function()
    R = ca.SX.zeros(relative.shape[0])
    J = ca.SX.zeros(relative.shape[0], relative.shape[0])
    energy = ca.SX(0)
    latest_tangents = []
    for xi, weight, before, last in zip(
        element.POINTS,
        element.WEIGHTS,
        points,
        ca.vertsplit(latest, _POINT_TANGENT_SIZE),
        strict=True,
    ):
        B = element.interpolation(xi, l)
        force, stiffness, square, tangent_numbers = point(B @ relative @ q, before, k0, last)
        R += B.T @ (weight * l * C * force)
        J += B.T @ (weight * l * C * stiffness) @ B
        energy += 0.5 * weight * l * C * square
        latest_tangents.append(tangent_numbers)
    R = (relative.T @ R)[dofs]
    J = element.symmetric(c_q * (relative.T @ element.symmetric(J) @ relative))[dofs, dofs]
    inputs = [symbol, l, H]
    return WireFunctions(
        ca.Function("wire_residual", inputs, [ca.cse(R)]),
        ca.Function("wire_tangent", [*inputs, latest, c_q], [ca.cse(J)]),
        ca.Function("wire_latest", [*inputs, latest], [ca.cse(ca.vertcat(*latest_tangents))]),
        ca.Function("wire_energy", inputs, [ca.cse(energy)]),
    )


def _point_function() -> ca.Function:
    """Build (at = (r', r'', theta), before, k0, latest) -> B^T z, B^T (dz/dk) B for Newton's method, |z|^2, latest."""
    at = ca.SX.sym("at", 7)
    at_t = ca.SX.sym("at_t", 7)
    before = ca.SX.sym("before", POINT_STATE_SIZE)
    k0 = ca.SX.sym("k0")
    latest = ca.SX.sym("latest", _POINT_TANGENT_SIZE)
    d = at[0:3]
    c = at[3:6]
    k = ca.cross(d, c) / ca.dot(d, d)
    tangent: Any = d / ca.norm_2(d)
    w = at_t[6] + smallest_rotation_rate(before[0:3], ca.SX.zeros(3), d, at_t[0:3])
    spin = ca.cross(d, at_t[0:3]) / ca.dot(d, d) + w * tangent
    B = ca.jacobian(ca.jtimes(k, at, at_t) - ca.cross(spin, k), at_t)
    # the law as a function of the curvature alone: turning with the section does not change it
    curvature = ca.SX.sym("k", 3)
    present = section(d, c, at[6])
    step = bouc_wen_step(before, [*present[0:3], *ca.vertsplit(curvature), present[6]], k0)
    z: Any = ca.vertcat(*step.z)
    slope = ca.jacobian(z, curvature)
    # prediction by the latest tangent
    old_curvature, old_z, upper = ca.vertsplit(latest, [0, 3, 6, _POINT_TANGENT_SIZE])
    old_slope: Any = ca.vertcat(upper[[0, 1, 2]].T, upper[[1, 3, 4]].T, upper[[2, 4, 5]].T)
    predicted = old_z + old_slope @ (curvature - old_curvature)
    trust = within(ca.dot(predicted, z) / (ca.dot(z, z) + REGULARIZATION * k0 * k0))
    slope = trust * 0.5 * (slope + slope.T) + (1 - trust) * step.secant * ca.SX.eye(3)
    latest_now = ca.vertcat(curvature, z, _upper_half(slope))
    z, slope, latest_now = ca.substitute([z, slope, latest_now], [curvature], [k])
    outputs = B.T @ z, element.symmetric(B.T @ slope @ B), ca.dot(z, z), latest_now
    return ca.Function("wire_point", [at, before, k0, latest], [ca.cse(x) for x in outputs])


def _upper_half(A: ca.SX) -> ca.SX:
    return ca.vertcat(*(A[i, j] for i in range(3) for j in range(i, 3)))


@cache
def wire_element(
    fidelity: element.ElementFidelity, base: element.ElementFunctions
) -> element.ElementFunctions:
    """Build the functions of the ``base`` element with friction between its wires, whose energy is bending."""
    wires = wire_functions(fidelity)
    return bending_element(
        base,
        HISTORY_SIZE + TANGENT_SIZE,
        lambda q, l, _, numbers: wires.residual(q, l, numbers[:HISTORY_SIZE]),
        lambda q, l, _, numbers, c_q: wires.tangent(
            q, l, numbers[:HISTORY_SIZE], numbers[HISTORY_SIZE:], c_q
        ),
        lambda q, l, _, numbers: wires.energy(q, l, numbers[:HISTORY_SIZE]),
    )
