"""Beam element with an additional bending moment: force, tangent and energy added to those of another element.

They depend on q and on numbers that F has behind those of the other element's reference.
"""

from collections.abc import Callable
from typing import Any

import casadi as ca

from rope_model.physics.element import BALANCE, ElementFunctions

_BENDING = BALANCE.index("bending")
#: function of q, l, F of the other element and the numbers behind it; the last argument of the tangent is cq
Part = Callable[..., Any]


def bending_element(plain: ElementFunctions, size: int, force: Part, tangent: Part, energy: Part) -> ElementFunctions:
    """Add force, tangent and energy of a part with ``size`` numbers to the ``plain`` element; the energy is bending."""
    frame = plain.residual.size1_in(4)
    q, v, a, before = (ca.SX.sym(name, plain.residual.size1_in(0)) for name in ("q", "v", "a", "before"))
    l, F, P = ca.SX.sym("l"), ca.SX.sym("F", frame + size), ca.SX.sym("P", plain.residual.size1_in(5))
    cq, cv, c_a = (ca.SX.sym(name) for name in ("cq", "cv", "ca"))
    own, numbers = F[:frame], F[frame:]
    R, J = plain.tangent(q, v, a, l, own, P, cq, cv, c_a, before)
    added = force(q, l, own, numbers)
    balance = plain.balance(q, v, l, own, P)
    balance[_BENDING] += energy(q, l, own, numbers)

    return plain.replaced(
        residual=([q, v, a, l, F, P], [plain.residual(q, v, a, l, own, P) + added]),
        tangent=([q, v, a, l, F, P, cq, cv, c_a, before], [R + added, J + tangent(q, l, own, numbers, cq)]),
        balance=([q, v, l, F, P], [balance]),
        losses=([q, v, l, F, P], [plain.losses(q, v, l, own, P)]),
        strains=([q, l, F], [plain.strains(q, l, own)]),
        transport=([q, v, a, l, F], [plain.transport(q, v, a, l, own)]),
    )
