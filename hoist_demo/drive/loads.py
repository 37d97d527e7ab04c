"""Loads on a drive at one instant of a step: inputs that change, and forces that yield to its acceleration.

    u(s) = u_0 + u_1 s + u_2 s^2 ,   F(s) = F_p(s) - m_a a ,   s = 0 .. 1 ,   a = a_0 + B F

Forces enter the accelerations linearly, so that with the accelerations a_p under the polynomial alone
F = F_p - (1 + m_a B)^-1 m_a a_p.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from hoist_demo.drive.equations import ACCELERATIONS, FORCES, INPUT_NAMES, Equations

PATH = 3 * len(INPUT_NAMES)
"""Numbers of a path: u_0, u_1 and u_2."""


def path_at(path: Any, s: Any) -> Any:
    """The polynomial."""
    start, rise, bend = ca.vertsplit(path, len(INPUT_NAMES))
    return start + s * (rise + s * bend)


def effective_input(equations: Equations, x: Any, u: Any, added_mass: Any, l0: Any, p: Any) -> Any:
    """The input with its forces less the added masses times the accelerations that come out."""
    a = equations.rates(x, u, l0, p)[list(ACCELERATIONS)]
    B = equations.mobility(x, u, l0, p)
    given_up = ca.solve(ca.SX.eye(len(FORCES)) + ca.diag(added_mass) @ B, added_mass * a)
    acting = ca.SX(u)
    for k, place in enumerate(FORCES):
        acting[place] -= given_up[k]
    return acting
