"""Equations of motion of a rope on one mesh.

    R(q, v, a) = d/dt dK/dv - dK/dq + dU/dq + dD/dv + dV/dq - loads

(docs/theory/element.md, eq-energies) with the kinetic energy K, the strain energy U and the
dissipation D of ``physics.element``, summed over the elements. R is zero where a degree of freedom
is free.  Where it is held, R is the reaction: the force or moment of the surroundings on the rope.

A node has seven degrees of freedom: r (m), r' (1) and theta (rad).  Arrays of nodes are (nodes, 7),
arrays of elements have their entries first: (entries, elements).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgbtrf, dgbtrs

from rope_model.arrays import Array
from rope_model.parameters import Rope
from rope_model.physics import element
from rope_model.physics.element import BALANCE, ElementFunctions, parameters
from rope_model.physics.node import ANGLE, NODE_DOF, SLOPE
from rope_model.physics.swivel import pressing_tension
from rope_model.reference.elements import over_elements

Mask = NDArray[np.bool_]

ALONG = 0  #: column of r_X
HEIGHT = 1  #: column of r_Y
STRETCH = 4  #: column of r'_Y: the stretch of a plumb end
ELEMENT_DOF = 2 * NODE_DOF
BAND = ELEMENT_DOF - 1  #: diagonals of the tangent on either side of the main one
DIAGONAL = 2 * BAND  #: row of the main diagonal in a band: above are BAND rows for exchanges
BAND_ROWS = 3 * BAND + 1


@dataclass(frozen=True)
class Factors:
    """Tangent J of what is free as a product of triangular matrices."""

    lu: Array
    pivots: NDArray[np.int32]
    held: Mask  #: true where a degree of freedom is held (nodes, 7)
    singular: bool  #: true if J has no inverse: there is nothing to solve

    def solve(self, force: Array) -> Array:
        """Return x (nodes, 7) with J x = ``force`` (nodes, 7) where free, and 0 where held.

        LAPACK exchanges rows: its own x where held is 0 up to rounding.
        """
        load = np.where(self.held, 0.0, force)
        x, _ = dgbtrs(self.lu, BAND, BAND, load.ravel(), self.pivots)
        return np.where(self.held, 0.0, np.asarray(x).reshape(force.shape))


@dataclass(frozen=True)
class Equations:
    """Equations of motion on a mesh, with any degrees of freedom held and loads at the nodes."""

    law: ElementFunctions  #: functions of the element: the published ones, or others for a trial
    lengths: Array  #: reference lengths of the elements (elements,), m
    material: Array  #: element.ElementParameters (13,)
    frame: Array  #: reference of the sections' frame (21, elements): see ``with_reference``
    held: Mask  #: true where a degree of freedom is held (nodes, 7)
    #: time -> q, v, a (3, nodes, 7), of which the held entries count
    held_motion: Callable[[float], Array]
    load: Array  #: dead loads at the nodes (nodes, 7), N, N m and N m
    inertia: Array  #: additional inertia of the nodes (nodes, 7), kg, kg m^2 and kg m^2
    friction: Array  #: moment on theta per newton of the node's vertical reaction (nodes,), m

    @staticmethod
    def of(rope: Rope, gravity: float, lengths: Array, q: Array, held: Mask) -> Equations:
        """Return the equations of a ``rope`` of which ``held`` stays where ``q`` is."""
        law = element.element_functions()
        return Equations(
            law=law,
            lengths=lengths,
            material=np.array(parameters(rope, gravity)),
            frame=frame_at(q, lengths, law),
            held=held,
            held_motion=at_rest(q),
            load=np.zeros_like(q),
            inertia=np.zeros_like(q),
            friction=np.zeros(len(q)),
        )

    def with_reference(self, q: Array) -> Equations:
        """Return the equations with angles that count from the frame of ``q``: see ``turning``."""
        return replace(self, frame=frame_at(q, self.lengths, self.law))

    def held_at(self, q: Array) -> Equations:
        """Return the equations of a rope whose held degrees of freedom rest where ``q`` is."""
        return replace(self, held_motion=at_rest(q))

    # forces

    def residual(self, q: Array, v: Array, a: Array) -> Array:
        """Return R (nodes, 7), N and N m."""
        (forces,) = self._values(
            self.law.residual,
            *self._of_elements(q, v, a),
            self.material[:, None],
        )
        return self._assembled(forces, a)

    def linearised(
        self, q: Array, v: Array, a: Array, c: tuple[float, float, float], prestress: Array
    ) -> tuple[Array, Factors]:
        """Return R and the tangent J = c[0] dR/dq + c[1] dR/dv + c[2] dR/da of what is free.

        ``c`` are 1, 1/s and 1/s^2 (docs/theory/time.md, eq-tangent).  Tensions in J are those of the
        axial strains of the rope ``prestress`` (nodes, 7).
        """
        forces, J = self._values(
            self.law.tangent,
            *self._of_elements(q, v, a),
            self.material[:, None],
            *c,
            of_elements(prestress),
        )
        R = self._assembled(forces, a)
        band = assembled_band(J)
        band[DIAGONAL] += c[2] * self.inertia.ravel()
        self._add_friction(band, R)
        self._hold(band)
        lu, pivots, info = dgbtrf(band, BAND, BAND, overwrite_ab=True)
        return R, Factors(lu, pivots, self.held, singular=info > 0)

    def _values(self, function: ca.Function, *arguments: Array | float) -> tuple[Array, ...]:
        """Return the results of a ``function`` of an element for all elements."""
        return over_elements(function)(self.lengths.size, *arguments)

    def _of_elements(self, q: Array, v: Array, a: Array) -> tuple[Array, ...]:
        """Return the first arguments of the element's functions."""
        return of_elements(q), of_elements(v), of_elements(a), self.lengths[None, :], self.frame

    def _assembled(self, forces: Array, a: Array) -> Array:
        """Return the residual of the nodes from those of the elements (14, elements)."""
        R = self.inertia * a - self.load
        R[:-1] += forces[:NODE_DOF].T
        R[1:] += forces[NODE_DOF:].T
        R[:, ANGLE] -= self.friction * pressing_tension(R[:, HEIGHT])
        return R

    def _add_friction(self, band: Array, R: Array) -> None:
        """Add the change of the friction's moments with the vertical reactions ``R``."""
        acting = (self.friction != 0) & (pressing_tension(R[:, HEIGHT]) > 0)
        for node in np.flatnonzero(acting).tolist():
            of_moment = NODE_DOF * node + ANGLE
            of_force = NODE_DOF * node + HEIGHT
            first = max(of_moment - BAND, 0)
            last = min(of_force + BAND, band.shape[1] - 1)
            j = np.arange(first, last + 1)
            of_force_row = band[DIAGONAL + of_force - j, j]
            band[DIAGONAL + of_moment - j, j] -= self.friction[node] * of_force_row

    def _hold(self, band: Array) -> None:
        """Replace the rows of what is held by x = force."""
        i = np.flatnonzero(self.held)[:, None]
        j = np.clip(i + np.arange(-BAND, BAND + 1), 0, band.shape[1] - 1)
        band[DIAGONAL + i - j, j] = 0.0
        band[DIAGONAL, i] = 1.0

    # the frame of the sections

    def turning(self, q: Array, v: Array, a: Array) -> Array:
        """Return the increase of theta and its rates (3, nodes) when ``q`` becomes the reference.

        It is in rad, rad/s and rad/s^2.  Sections stay where they are.  The frame of the left end
        stays, too; along the rope the mean twist of each element adds up (docs/theory/element.md,
        eq-frame).
        """
        gained = np.zeros((3, len(q)))
        transport = self.law.transport
        (gained[:, 1:],) = self._values(transport, *self._of_elements(q, v, a))
        gained[0] = gained[0].cumsum()
        return gained

    # energies and strains

    def balance(self, q: Array, v: Array) -> dict[str, float]:
        """Return energies (J) and powers (W) of the whole rope by the names of element.BALANCE."""
        (values,) = self._values(
            self.law.balance,
            of_elements(q),
            of_elements(v),
            self.lengths[None, :],
            self.frame,
            self.material[:, None],
        )
        sum_by_name = dict(zip(BALANCE, values.sum(axis=1).tolist(), strict=True))
        sum_by_name["kinetic"] += 0.5 * float(np.sum(self.inertia * v * v))
        return sum_by_name

    def strains(self, q: Array, v: Array) -> Array:
        """Return the strains of the elements (5, elements): element.STRAINS."""
        strains = self.law.strains
        parts = of_elements(q), of_elements(v), self.lengths[None, :], self.frame
        (values,) = self._values(strains, *parts)
        return values

    def size(self, x: Array) -> float:
        """Return the largest entry of a correction or error ``x`` (nodes, 7) of what is free.

        It is in m and rad.  A change of r' counts as that of the ends of the shortest element.
        """
        weights = np.ones(NODE_DOF)
        weights[SLOPE] = self.lengths.min()
        return float(np.max(np.abs(x) * weights, where=~self.held, initial=0.0))


def at_rest(q: Array) -> Callable[[float], Array]:
    """Return the motion of what rests where ``q`` is."""
    still = np.array([q, np.zeros_like(q), np.zeros_like(q)])
    return lambda t: still


def of_elements(x: Array) -> Array:
    """Return the values (14, elements) of both nodes of each element."""
    return np.concatenate((x[:-1], x[1:]), axis=1).T


def frame_at(q: Array, lengths: Array, law: ElementFunctions) -> Array:
    """Return the reference (21, elements) of sections whose frame is that of the rope ``q``."""
    reference = over_elements(law.reference)
    (frame,) = reference(lengths.size, of_elements(q), lengths[None, :])
    return frame


def assembled_band(J: Array) -> Array:
    """Return the tangent of the nodes from those of the elements (196, elements), symmetric matrices.

    Row i and column j of it are at [DIAGONAL + i - j, j].  The first BAND rows are room for the
    exchanges of rows, as LAPACK needs them.
    """
    elements = J.shape[1]
    places = _band_places(elements)
    unknowns = NODE_DOF * (elements + 1)
    band = np.zeros(unknowns * BAND_ROWS)
    band += np.bincount(places, weights=J.T.ravel(), minlength=band.size)
    return band.reshape(unknowns, BAND_ROWS).T


@lru_cache(8)
def _band_places(elements: int) -> NDArray[np.intp]:
    """Return the place in a band, stored by columns, of each entry of the elements' tangents."""
    first = NODE_DOF * np.arange(elements)[:, None, None]
    j = np.arange(ELEMENT_DOF)[:, None]
    i = np.arange(ELEMENT_DOF)
    return ((first + j) * BAND_ROWS + DIAGONAL + i - j).ravel()
