"""A drive under forces that change within a step, and with its acceleration.

    F(s) = F_0 + F_1 s + F_2 s^2 - m_a a ,   s = 0 .. 1 ,   a = a_0 + B F

Forces enter the accelerations linearly, so that with the accelerations a_p under the polynomial alone
F = F_p - (1 + m_a B)^-1 m_a a_p. Works on any DAE of a drive whose parameters are (H, inputs, others).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca


def under_changing_load(
    dae: dict[str, Any], inputs: int, forces: Sequence[int], accelerations: Sequence[int]
) -> dict[str, Any]:
    """The DAE over s with the parameters (H, u_0, u_1, u_2, m_a, others).

    `inputs` is the length of u; `forces` are places in u, `accelerations` the states whose rates the forces change;
    the ode is that of scaled time, H dx/dt.
    """
    x, p = dae["x"], dae["p"]
    n = len(forces)
    s, start, rise, bend = ca.SX.sym("s"), *(ca.SX.sym(f"u{i}", inputs) for i in range(3))
    added = ca.SX.sym("m_a", n)
    H, others = ca.SX.sym("H"), ca.SX.sym("others", p.numel() - 1 - inputs)
    f = ca.Function("f", [x, p], [dae["ode"], dae["quad"]])
    u = start + s * (rise + s * bend)
    a = f(x, ca.vertcat(H, u, others))[0][list(accelerations)] / H
    B = ca.jacobian(a, start)[:, list(forces)]
    given_up = ca.solve(ca.SX.eye(n) + ca.diag(added) @ B, added * a)
    acting = ca.SX(u)
    for k, place in enumerate(forces):
        acting[place] -= given_up[k]
    ode, quad = f(x, ca.vertcat(H, acting, others))
    return {"x": x, "t": s, "p": ca.vertcat(H, start, rise, bend, added, others), "ode": ode, "quad": quad}
