"""Ropes held in any way, without conveyances, and their shapes at rest.

They are those of the reference rope: ``rope_model.reference.equations`` with boundaries of their own.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from unittest.mock import patch

import numpy as np
import scipy.sparse as sp

from evidence.tables import Array
from rope_model.analysis import chain_matrices
from rope_model.parameters import Rope
from rope_model.physics import element as elements
from rope_model.physics.element import ElementFunctions
from rope_model.physics.node import ANGLE
from rope_model.reference.equations import Equations, Mask, of_elements
from rope_model.reference.statics import Equilibrium, find_equilibrium

#: index of what moves a rope out of its plane
OUT_OF_PLANE = np.s_[:, [2, 5, 6]]


def held(q: Array, *places: Any) -> Mask:
    """Return the mask (nodes, 7) that holds these ``places`` of ``q``, given as indices."""
    mask = np.zeros(q.shape, dtype=bool)
    for place in places:
        mask[place] = True
    return mask


def clamped(q: Array) -> Mask:
    """Return the mask that holds both ends of ``q``: place, direction and angle.

    They may stretch, along the axis that they lie on.
    """
    mask = held(q, [0, -1])
    mask[[0, -1], 3 + np.argmax(np.abs(q[[0, -1], 3:6]), axis=1)] = False
    return mask


def rod(rope: Rope, gravity: float, q: Array, mask: Mask) -> Equations:
    """Return the equations of a ``rope`` on equal elements, held by ``mask`` where ``q`` (nodes, 7) is."""
    count = len(q) - 1
    lengths = np.full(count, rope.length / count)
    return Equations.of(rope, gravity, lengths, q, mask)


def turned(equations: Equations, q: Array, angle: float) -> Equilibrium:
    """Return the rest after the far end of ``q``, whose angles count along it, is turned by ``angle`` (rad) more."""
    guess = q.copy()
    guess[:, ANGLE] += angle * np.linspace(0.0, 1.0, len(q))
    return find_equilibrium(equations.held_at(guess), guess)


def matrix(equations: Equations, q: Array, c: tuple[float, float, float]) -> sp.csc_matrix:
    """Return c[0] dR/dq + c[1] dR/dv + c[2] dR/da of all nodes at rest in ``q``, the frame's reference."""
    at = equations.with_reference(q)
    still = of_elements(np.zeros_like(q))
    nodes = of_elements(q)
    parts = (nodes, still, still, at.lengths[None, :], at.frame, at.material)
    _, J = at.law.tangent(*parts, *c, nodes)
    of_chain = chain_matrices.of_elements(J.full(), at.lengths.size)
    return (of_chain + sp.diags(c[2] * at.inertia.ravel())).tocsc()


@contextmanager
def with_element(functions: ElementFunctions) -> Iterator[None]:
    """Give reference ropes inside another element: their equations take these ``functions``."""
    with patch.object(elements, "element_functions", lambda: functions):
        yield
