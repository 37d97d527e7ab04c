"""Beam element with an additional bending moment: force, tangent and energy added to those of another element.

They depend on q and on numbers that F has behind those of the other element's reference.
"""

from collections.abc import Callable
from typing import Any

import casadi as ca

from rope_model.physics.element import BALANCE, ElementFunctions

_BENDING = BALANCE.index("bending")
#: function of q, l, F of the other element and the numbers behind it; the last argument of the
#: tangent is c_q
Part = Callable[..., Any]


def bending_element(
    base: ElementFunctions, size: int, force: Part, tangent: Part, energy: Part
) -> ElementFunctions:
    """Add force, tangent and energy of a part with ``size`` numbers to the ``base`` element; the energy is bending."""
    frame = base.residual.size1_in(4)
    q, v, a, q_prestress = (
        ca.SX.sym(name, base.residual.size1_in(0)) for name in ("q", "v", "a", "q_prestress")
    )
    l = ca.SX.sym("l")
    F = ca.SX.sym("F", frame + size)
    P = ca.SX.sym("P", base.residual.size1_in(5))
    c_q, c_v, c_a = (ca.SX.sym(name) for name in ("c_q", "c_v", "c_a"))
    base_F = F[:frame]
    numbers = F[frame:]
    R, J = base.tangent(q, v, a, l, base_F, P, c_q, c_v, c_a, q_prestress)
    added = force(q, l, base_F, numbers)
    balance = base.balance(q, v, l, base_F, P)
    balance[_BENDING] += energy(q, l, base_F, numbers)

    return base.replaced(
        residual=([q, v, a, l, F, P], [base.residual(q, v, a, l, base_F, P) + added]),
        tangent=(
            [q, v, a, l, F, P, c_q, c_v, c_a, q_prestress],
            [R + added, J + tangent(q, l, base_F, numbers, c_q)],
        ),
        balance=([q, v, l, F, P], [balance]),
        losses=([q, v, l, F, P], [base.losses(q, v, l, base_F, P)]),
        strains=([q, v, l, F], [base.strains(q, v, l, base_F)]),
        transport=([q, v, a, l, F], [base.transport(q, v, a, l, base_F)]),
    )
