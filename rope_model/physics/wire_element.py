"""The beam element with friction between its wires: physics.element with the moment of physics.wire_friction.

At each Gauss point C z is added to the moment EI k, work-conjugate to the rate of k that the section sees:

    R += int B^T C z dx,     J += cq int B^T C dz/dk B dx

F has behind the frame's entries what the rope was at the last accepted instant: at each point section and z (10), then
k0, C, and a number for Newton's method, (33,).  The tangent is symmetric: it leaves out the skew part of dz/dk, and how
B changes.  The number is the share that secants have in it: between curvatures at which wires slide to and fro, dz/dk
goes up and down, and tangents alone lead from one side to the other for ever.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import casadi as ca

from .element import (
    BALANCE,
    ELEMENT_DOF,
    NODE_DOF,
    POINTS,
    WEIGHTS,
    ElementFidelity,
    ElementFunctions,
    interpolation,
    relative_coordinates,
    symmetric,
)
from .frame import smallest_rotation_rate
from .wire_friction import MEMORY, section, slide

_BENDING = BALANCE.index("bending")
#: numbers of an element: what its points remember, k0, C and the share of secants
HISTORY = MEMORY * len(POINTS) + 3


class WireFunctions(NamedTuple):
    """What friction between the wires adds to an element, ``H`` being its HISTORY.

    residual: (q, l, H) -> R (2 m,); tangent: (q, l, H, cq) -> J (2 m, 2 m); energy: (q, l, H) -> J, stored.
    """

    residual: ca.Function
    tangent: ca.Function
    energy: ca.Function


@cache
def wire_functions(fidelity: ElementFidelity) -> WireFunctions:
    """Build the functions."""
    kept = [*ELEMENT_DOF[fidelity], *(NODE_DOF + k for k in ELEMENT_DOF[fidelity])]
    symbol, q = ca.SX.sym("q", len(kept)), ca.SX.zeros(2 * NODE_DOF)
    q[kept] = symbol
    l, H, cq = ca.SX.sym("l"), ca.SX.sym("H", HISTORY), ca.SX.sym("cq")
    *points, k0, C, share = ca.vertsplit(H, [*range(0, HISTORY - 2, MEMORY), *range(HISTORY - 2, HISTORY + 1)])
    relative, point = relative_coordinates(), _point_function()
    R, J, energy = ca.SX.zeros(relative.shape[0]), ca.SX.zeros(relative.shape[0], relative.shape[0]), ca.SX(0)
    for xi, weight, before in zip(POINTS, WEIGHTS, points, strict=True):
        B = interpolation(xi, l)
        force, stiffness, square = point(B @ relative @ q, before, k0, share)
        R += B.T @ (weight * l * C * force)
        J += B.T @ (weight * l * C * stiffness) @ B
        energy += 0.5 * weight * l * C * square
    R, J = (relative.T @ R)[kept], symmetric(cq * (relative.T @ symmetric(J) @ relative))[kept, kept]
    inputs = [symbol, l, H]
    return WireFunctions(
        ca.Function("wire_residual", inputs, [ca.cse(R)]),
        ca.Function("wire_tangent", [*inputs, cq], [ca.cse(J)]),
        ca.Function("wire_energy", inputs, [ca.cse(energy)]),
    )


def _point_function() -> ca.Function:
    """(at, before, k0, share), at = (r', r'', theta), -> B^T z, what Newton takes for its derivative, |z|^2."""
    at, at_t, before = ca.SX.sym("at", 7), ca.SX.sym("at_t", 7), ca.SX.sym("before", MEMORY)
    k0, share = ca.SX.sym("k0"), ca.SX.sym("share")
    d, c = at[0:3], at[3:6]
    k = ca.cross(d, c) / ca.dot(d, d)
    tangent: Any = d / ca.norm_2(d)
    w = at_t[6] + smallest_rotation_rate(before[0:3], ca.SX.zeros(3), d, at_t[0:3])
    spin = ca.cross(d, at_t[0:3]) / ca.dot(d, d) + w * tangent
    B = ca.jacobian(ca.jtimes(k, at, at_t) - ca.cross(spin, k), at_t)
    # the law as a function of the curvature alone: what turns with the section is no change of it
    bent, now = ca.SX.sym("k", 3), section(d, c, at[6])
    slid = slide(before, [*now[0:3], *ca.vertsplit(bent), now[6]], k0)
    z: Any = ca.vertcat(*slid.z)
    slope = ca.jacobian(z, bent)
    slope = (1 - share) * 0.5 * (slope + slope.T) + share * slid.secant * ca.SX.eye(3)
    z, slope = ca.substitute([z, slope], [bent], [k])
    outputs = B.T @ z, symmetric(B.T @ slope @ B), ca.dot(z, z)
    return ca.Function("wire_point", [at, before, k0, share], [ca.cse(x) for x in outputs])


@cache
def wire_element(fidelity: ElementFidelity, plain: ElementFunctions) -> ElementFunctions:
    """The ``plain`` element's functions with friction between the wires, whose energy is in that of bending."""
    wires, m = wire_functions(fidelity), len(ELEMENT_DOF[fidelity])
    frame = plain.residual.size1_in(4)
    q, v, a = (ca.SX.sym(name, 2 * m) for name in ("q", "v", "a"))
    l, F, P = ca.SX.sym("l"), ca.SX.sym("F", frame + HISTORY), ca.SX.sym("P", plain.residual.size1_in(5))
    cq, cv, c_a = (ca.SX.sym(name) for name in ("cq", "cv", "ca"))
    own, H = F[:frame], F[frame:]
    R, J = plain.tangent(q, v, a, l, own, P, cq, cv, c_a)
    rubbed = wires.residual(q, l, H)
    balance = plain.balance(q, v, l, own, P)
    balance[_BENDING] += wires.energy(q, l, H)

    def function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
        return ca.Function(f"element_{name}", inputs, outputs)

    tangent = [R + rubbed, J + wires.tangent(q, l, H, cq)]
    return replace(
        plain,
        residual=function("residual", [q, v, a, l, F, P], [plain.residual(q, v, a, l, own, P) + rubbed]),
        tangent=function("tangent", [q, v, a, l, F, P, cq, cv, c_a], tangent),
        balance=function("balance", [q, v, l, F, P], [balance]),
        losses=function("losses", [q, v, l, F, P], [plain.losses(q, v, l, own, P)]),
        strains=function("strains", [q, l, F], [plain.strains(q, l, own)]),
        transport=function("transport", [q, v, a, l, F], [plain.transport(q, v, a, l, own)]),
    )
