"""Rods that are held and loaded in any way: the equations of the reference, also with permanent curvature."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from rope_model.analysis.chain_matrices import of_elements as chain_matrix
from rope_model.arrays import Array
from rope_model.parameters import Rope
from rope_model.physics.curved_element import curved_element
from rope_model.physics.element import (
    BALANCE,
    PARAMETERS,
    POINTS,
    ElementFunctions,
    element_functions,
    parameters,
)
from rope_model.physics.initial_curvature import START, curvature_components, curvature_vectors
from rope_model.physics.node import NODE_DOF
from rope_model.reference.equations import Equations, at_rest, frame_at, of_elements

Mask = NDArray[np.bool_]


def nothing_held(q: Array) -> Mask:
    """Return the mask (nodes, 7) of a rod that is held nowhere."""
    return np.zeros(q.shape, dtype=bool)


def rod(
    lengths: Array,
    material: Array,
    held: Mask,
    values: Array,
    load: Array | None = None,
    reference: Array | None = None,
) -> Equations:
    """Return the equations of a rod whose ``held`` freedoms rest at ``values`` (nodes, 7), under dead loads.

    ``material`` has the entries of physics.element.PARAMETERS.  The frame is that of ``reference``, else of ``values``.
    """
    if load is None:
        load = np.zeros_like(values)
    if reference is None:
        reference = values
    law = element_functions()
    return Equations(
        law=law,
        lengths=lengths,
        material=material,
        frame=frame_at(reference, lengths, law),
        held=held,
        held_motion=at_rest(values),
        load=load,
        inertia=np.zeros_like(values),
        friction=np.zeros(len(values)),
    )


def chain_tangent(
    equations: Equations,
    q: Array,
    c: tuple[float, float, float],
    prestress: Array | None = None,
    functions: ElementFunctions | None = None,
) -> sp.csc_matrix:
    """Return c[0] dR/dq + c[1] dR/dv + c[2] dR/da of all freedoms of a rod at rest in ``q``."""
    zeros = np.zeros_like(q)
    parts = (*(of_elements(x) for x in (q, zeros, zeros)), equations.lengths[None, :])
    if prestress is None:
        prestress = q
    before = of_elements(prestress)
    tangent = (functions or element_functions()).tangent
    J = tangent(*parts, equations.frame, equations.material, *c, before)[1]
    inertia = sp.diags(c[2] * equations.inertia.ravel())
    return chain_matrix(np.asarray(J), equations.lengths.size) + inertia


@cache
def curvature_along(elements: int) -> ca.Function:
    """Build (e1 at the left end, curvature_components, lengths, nodes) -> e1 at the right nodes, k0 at the points (9,).

    Columns belong to elements.
    """
    start = ca.SX.sym("start", 3)
    l = ca.SX.sym("l")
    nodes = ca.SX.sym("nodes", 2 * NODE_DOF)
    components = ca.SX.sym("components", 2 * len(POINTS))
    *k0, x, y, z = curvature_vectors(components, l, nodes, start)
    inputs = [start, components, l, nodes]
    return ca.Function(
        "curvature_vectors", inputs, [ca.vertcat(x, y, z), ca.vertcat(*k0)]
    ).mapaccum(elements)


@dataclass(frozen=True)
class Dense:
    """Tangent of what is free, as one matrix."""

    matrix: Array
    held: Mask
    singular: bool = False

    def solve(self, force: Array) -> Array:
        """Return x (nodes, 7) with J x = ``force``, zero where the rod is held."""
        free = np.flatnonzero(~self.held.ravel())
        x = np.zeros(force.size)
        x[free] = np.linalg.solve(self.matrix[np.ix_(free, free)], force.ravel()[free])
        return x.reshape(force.shape)


@dataclass(frozen=True)
class CurvedRod(Equations):
    """Equations of a rod with permanent curvature, whose left end hangs down and is clamped there."""

    components: Array  #: physics.initial_curvature.curvature_components

    @staticmethod
    def of_rope(rope: Rope, q: Array, held: Mask, load: Array | None = None) -> CurvedRod:
        """Return the rod of equal elements without weight, referred to ``q`` (nodes, 7)."""
        elements = len(q) - 1
        lengths = np.full(elements, rope.length / elements)
        plain = rod(lengths, np.array(parameters(rope, 0.0)), held, q, load)
        components = np.array(curvature_components(rope, np.cumsum(lengths) - lengths, lengths))
        return CurvedRod(**vars(plain), components=components).with_reference(q)

    def with_reference(self, q: Array) -> CurvedRod:
        l = self.lengths
        _, k0 = curvature_along(l.size)(START, self.components, l[None], of_elements(q))
        bending = np.full(l.size, self.material[PARAMETERS.index("EI")])
        frame = np.vstack((frame_at(q, l, self.law), np.array(k0), q[:-1, 6], q[1:, 6], bending))
        return replace(self, frame=frame)

    def residual(self, q: Array, v: Array, a: Array) -> Array:
        R = curved_element(element_functions()).residual(*self._of_elements(q, v, a), self.material)
        return self._assembled(R.full(), a)

    def linearised(
        self, q: Array, v: Array, a: Array, c: tuple[float, float, float], prestress: Array
    ) -> tuple[Array, Any]:
        matrix = chain_tangent(self, q, c, prestress, curved_element(element_functions()))
        return self.residual(q, v, a), Dense(matrix.toarray(), self.held)

    def turning(self, q: Array, v: Array, a: Array) -> Array:
        gained = np.zeros((3, len(q)))
        transport = curved_element(element_functions()).transport
        gained[:, 1:] = transport(*self._of_elements(q, v, a)).full()
        gained[0] = gained[0].cumsum()
        return gained

    def bending(self, q: Array) -> float:
        """Return the energy (J) of bending against the permanent curvature."""
        parts = of_elements(q), 0.0 * of_elements(q), self.lengths[None, :]
        balance = curved_element(element_functions()).balance
        sums = balance(*parts, self.frame, self.material).full().sum(axis=1)
        return float(sums[BALANCE.index("bending")])
