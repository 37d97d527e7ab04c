"""The beam element that touches bodies in the shaft: physics.element with the forces of physics.contact.

Where the element is near a body, the force per length is integrated over Gauss points of the centre line:

    R -= int N^T f dx,   J += int N^T (-cq df/dr - cv df/dv) N dx

with the cubic Hermite shapes N of r.  The points are so many that a thin body does not slip between two of them.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from . import hermite
from .contact import touch
from .element import ELEMENT_DOF, ElementFidelity, ElementFunctions
from .shaft import KINDS, Body

_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(16)
#: places in the element, from 0 to 1, and their weights
POINTS, WEIGHTS = tuple((0.5 + 0.5 * _GAUSS_POINTS).tolist()), tuple((0.5 * _GAUSS_WEIGHTS).tolist())
#: numbers of the law, and of a body: those of shaft.Body and its speed
LAW = ("stiffness", "damping", "friction", "slip_speed", "diameter")
BODY_SIZE = 13
#: what the balance of the element has beyond element.BALANCE
CONTACT_BALANCE = (
    "contact",  # J, stored where bodies press the rope
    "contact_dissipated",  # W, never negative
    "contact_moved",  # W, what moving bodies do on the rope
    *("contact_fx", "contact_fy", "contact_fz"),  # N, on the rope
    *("contact_mx", "contact_my", "contact_mz"),  # N m, about the origin
    *KINDS,  # N, sums of the pressure
)


@cache
def contact_element(fidelity: ElementFidelity, plain: ElementFunctions, kinds: tuple[int, ...]) -> ElementFunctions:
    """The functions of the ``plain`` element of a fidelity, with as many bodies as ``kinds``.

    F has an entry more for each body, 1 where the element is near it, else 0; P those of LAW and of the bodies.
    residual, tangent, balance and losses have what contact adds, the latter two in further entries.
    """
    m = len(ELEMENT_DOF[fidelity])
    frame, own, bodies = plain.residual.size1_in(4), plain.residual.size1_in(5), len(kinds)
    q, v, a = (ca.MX.sym(name, 2 * m) for name in ("q", "v", "a"))
    l, F = ca.MX.sym("l"), ca.MX.sym("F", frame + bodies)
    P = ca.MX.sym("P", own + len(LAW) + bodies * BODY_SIZE)
    cq, cv, c_a = (ca.MX.sym(name) for name in ("cq", "cv", "ca"))
    at, near = (F[:frame], P[:own]), ca.sum1(F[frame:]) > 0
    R, J, sums = _integrals(ELEMENT_DOF[fidelity], kinds)

    def added(function: ca.Function, *factors: Any) -> ca.MX:
        inputs = [q, v, l, F[frame:], P[own:], *factors]
        zero = ca.Function(f"no_{function.name()}", function.mx_in(), [ca.MX.zeros(*function.size_out(0))])
        return ca.Function.if_else(f"{function.name()}_if", function, zero)(near, *inputs)

    def function(name: str, inputs: list[ca.MX], outputs: list[ca.MX]) -> ca.Function:
        return ca.Function(f"element_{name}", inputs, outputs)

    R_plain, J_plain = plain.tangent(q, v, a, l, *at, cq, cv, c_a)
    balance = added(sums)
    return replace(
        plain,
        residual=function("residual", [q, v, a, l, F, P], [plain.residual(q, v, a, l, *at) + added(R)]),
        tangent=function("tangent", [q, v, a, l, F, P, cq, cv, c_a], [R_plain + added(R), J_plain + added(J, cq, cv)]),
        balance=function("balance", [q, v, l, F, P], [ca.vertcat(plain.balance(q, v, l, *at), balance)]),
        losses=function("losses", [q, v, l, F, P], [ca.vertcat(plain.losses(q, v, l, *at), balance[1:3])]),
        strains=function("strains", [q, l, F], [plain.strains(q, l, at[0])]),
        momentum=function("momentum", [q, v, l, P], [plain.momentum(q, v, l, at[1])]),
        transport=function("transport", [q, v, a, l, F], [plain.transport(q, v, a, l, at[0])]),
    )


def _integrals(kept: tuple[int, ...], kinds: tuple[int, ...]) -> tuple[ca.Function, ca.Function, ca.Function]:
    """(q, v, l, near, P) -> R (2 m,), the same with (cq, cv) -> J (2 m, 2 m), and the sums of CONTACT_BALANCE."""
    number, m = len(POINTS), len(kept)
    q, v, l = ca.MX.sym("q", 2 * m), ca.MX.sym("v", 2 * m), ca.MX.sym("l")
    near, P = ca.MX.sym("near", len(kinds)), ca.MX.sym("P", len(LAW) + len(kinds) * BODY_SIZE)
    cq, cv = ca.MX.sym("cq"), ca.MX.sym("cv")
    # which entry of the element is component i of node value k: r and r' of both nodes
    place = {dof: i for i, dof in enumerate(kept) if dof < 6}
    entries = {(i, k): place[i + 3 * (k % 2)] + m * (k // 2) for i in range(3) if i in place for k in range(4)}
    shares = ca.vertcat(*(ca.horzcat(*hermite.shares(xi, l)) for xi in POINTS))  # (points, 4)
    weights = ca.repmat(l * ca.DM(list(WEIGHTS)), 1, 4) * shares

    def nodal(x: ca.MX) -> ca.MX:
        rows = ([x[entries[i, k]] if (i, k) in entries else 0 for k in range(4)] for i in range(3))
        return ca.vertcat(*(ca.horzcat(*row) for row in rows))

    places, speeds = nodal(q) @ shares.T, nodal(v) @ shares.T
    repeated = [ca.repmat(x, 1, number) for x in (near, P)]
    loads, stiff = (f.map(number) for f in _touch_all(kinds))
    force, sums = loads(places, speeds, *repeated)
    tangent = stiff(places, speeds, *repeated, ca.repmat(cq, 1, number), ca.repmat(cv, 1, number))
    f = force @ weights
    R, J = ca.MX.zeros(2 * m), ca.MX(2 * m, 2 * m)
    for (i, k), row in entries.items():
        R[row] = -f[i, k]
        products = tangent @ (weights * ca.repmat(shares[:, k], 1, 4))  # (6, 4)
        for (j, n), column in entries.items():
            J[row, column] = products[_upper(i, j), n]
    return (
        ca.Function("contact_residual", [q, v, l, near, P], [R]),
        ca.Function("contact_tangent", [q, v, l, near, P, cq, cv], [ca.densify(J)]),
        ca.Function("contact_sums", [q, v, l, near, P], [sums @ (l * ca.DM(list(WEIGHTS)))]),
    )


def _upper(i: int, j: int) -> int:
    """Place of entry (i, j) of a symmetric matrix (3, 3) among those of its upper half, row by row."""
    i, j = min(i, j), max(i, j)
    return 3 * i - i * (i - 1) // 2 + j - i


def _touch_all(kinds: tuple[int, ...]) -> tuple[ca.Function, ca.Function]:
    """(point, speed, near, P) -> force (3,) and sums per length of all bodies, the same with (cq, cv) -> tangent."""
    point, speed = ca.SX.sym("point", 3), ca.SX.sym("speed", 3)
    near, P = ca.SX.sym("near", len(kinds)), ca.SX.sym("P", len(LAW) + len(kinds) * BODY_SIZE)
    cq, cv = ca.SX.sym("cq"), ca.SX.sym("cv")
    law = SimpleNamespace(**dict(zip(LAW, ca.vertsplit(P[: len(LAW)]), strict=True)))
    force, tangent, sums = ca.SX.zeros(3), ca.SX.zeros(6), ca.SX.zeros(len(CONTACT_BALANCE))
    for k, kind in enumerate(kinds):
        x: Any = P[len(LAW) + k * BODY_SIZE : len(LAW) + (k + 1) * BODY_SIZE]
        body = Body(x[0:3], x[3:6], x[6], x[7], x[8], x[9])
        one = touch(law, law.diameter, body, x[10:13], point, speed, cq, cv)
        force += near[k] * ca.vertcat(*one.force)
        tangent += near[k] * ca.vertcat(*one.tangent)
        sums[: len(one.sums) - 1] += near[k] * ca.vertcat(*one.sums[:-1])
        sums[len(one.sums) - 1 + kind] += near[k] * one.sums[-1]
    inputs = [point, speed, near, P]
    return (
        ca.Function("touch", inputs, ca.cse([force, sums])),
        ca.Function("touch_tangent", [*inputs, cq, cv], [ca.cse(tangent)]),
    )
