"""A rope as a discrete rod: nodes with mass, straight edges that spin, bend and twist at the nodes.

Written from the equations of the continuous rope, for strains e, tau, k and stiffnesses Qa, Qb, Qc, Qd, EI:

    T = Qa e + Qb tau       M = Qc e + Qd tau       bending moment EI k       damping beta times the same of the rates
    inertia: rho of the centre line, rhoJ of the spin w about the tangent, none of the tangent's own turning
    ends: position and vertical tangent prescribed; a swivel between the clamp and the rope's end

Edge j runs from node j to j + 1, with reference length l, tangent t and spin w (the section's, about t, seen in space).
Node i stands for the cell of length L between the middles of its edges; t1, t2 are the tangents left and right of it:

    e     = |edge| / l - 1                          per edge
    K     = 2 t1 x t2 / (1 + t1.t2)                 curvature vector times L, per node
    m     = angle from the section of the edge before, carried by parallel transport from t1 to t2, to that of the
            edge behind: torsional strain times L, per node

The clamped tangents are edges of no length before the first and behind the last node, whose cells are half an edge
long; their spin is the swivel's.  m has no frame and no angles behind it: it is integrated by its own exact rate,

    m_t   = w2 - w1 + K . (t1_t + t2_t) / 2

in which the second term is the area that the arc from t1 to t2 sweeps on the sphere (holonomy): through it the
torque moves the loop out of its plane.  The rate of K is the one seen from the section, K_t - (O1 + O2)/2 x K, where
O = t x t_t + w t is an edge's angular velocity.  Forces are what these rates are multiplied with in the virtual power

    sum_edges T l e_t + sum_nodes (M m_t + n . (K_t - (O1 + O2)/2 x K)),     n = EI (K + beta rate) / L

and the spin, whose virtual change contains (t x t_t) . dt as the twist's contains K . dt, adds the gyroscopic couple.
T of an edge takes the mean tau of its two nodes, M of a node the mean e of its half edges.  All is of second order.

Source of the discrete curvature and twist: M. Bergou, M. Wardetzky, S. Robinson, B. Audoly, E. Grinspun, Discrete
Elastic Rods, ACM Transactions on Graphics 27 (2008); coupling, clamps, damping and gyroscopic couple are derived here.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from rope_model import Rope, Swivel

Array = NDArray[Any]  # real, or complex when differentiated
#: t -> (3, 2, 3): position, velocity and acceleration of the left and the right end
Ends = Callable[[float], Array]
#: entries of the state that a node couples with: two nodes of 8 to either side
HALF_BAND = 23
#: tangents of the clamps
CLAMPS = np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
GRAVITY = 9.81  # m/s^2


class Parts(NamedTuple):
    """A state by what it holds; the last axis is that of the columns of ``y`` (size, columns)."""

    b: Array  # (2, .) angle of the swivels
    b_t: Array  # (2, .)
    x: Array  # (N - 1, 3, .) inner nodes
    v: Array
    m: Array  # (N + 1, .) twist at the nodes
    w: Array  # (N, .) spin of the edges


class Loads(NamedTuple):
    """What the ends feel, columns last."""

    reaction: Array  # (2, 3, .) force of the conveyances on the rope
    moment: Array  # (2, .) moment about the tangent that a swivel which holds puts on the rope
    rates: Array  # (size, .) of the state


def split(y: Array) -> Parts:
    """(b, b_t, m, w | x, v, m, w per inner node | m, b, b_t): neighbours stand side by side."""
    inner = y[4:-3].reshape(-1, 8, *y.shape[1:])
    return Parts(
        b=y[[0, -2]],
        b_t=y[[1, -1]],
        x=inner[:, 0:3],
        v=inner[:, 3:6],
        m=np.concatenate((y[2:3], inner[:, 6], y[-3:-2])),
        w=np.concatenate((y[3:4], inner[:, 7])),
    )


def join(p: Parts) -> Array:
    """The inverse of ``split``."""
    inner = np.concatenate((p.x, p.v, p.m[1:-1, None], p.w[1:, None]), axis=1)
    left = (p.b[0], p.b_t[0], p.m[0], p.w[0])
    right = (p.m[-1], p.b[1], p.b_t[1])
    return np.concatenate((np.stack(left), inner.reshape(-1, *inner.shape[2:]), np.stack(right)))


@dataclass(frozen=True)
class Rod:
    """A discrete rod with edges of reference length ``lengths`` (N,) between ``ends``, the right one at ``swivel``."""

    lengths: Array
    rope: Rope
    ends: Ends
    swivel: Swivel = field(default_factory=Swivel)

    @property
    def cells(self) -> Array:
        """(N + 1,): reference lengths of the nodes' cells, m."""
        return _halves(self.lengths)

    @property
    def arms(self) -> tuple[float, float]:
        """Friction moments of the swivel, static and kinetic, over the force on it, m."""
        half = 0.5 * self.swivel.mean_diameter
        return half * self.swivel.mu_static, half * self.swivel.mu_kinetic

    @property
    def s(self) -> Array:
        """(N + 1,): arc length of the nodes, m."""
        return np.append(0.0, np.cumsum(self.lengths))

    def nodes(self, t: float, y: Array) -> Array:
        """(N + 1, 3): where the nodes are."""
        left, right = self.ends(t)[0]
        return np.vstack((left, split(y).x, right))

    def evaluate(self, t: float, y: Array, slip: float) -> Loads:
        """Rates of the state ``y`` (size, columns); ``slip`` is the sense in which the swivel slips, 0: it holds."""
        c = self.rope
        l = self.lengths[:, None]
        L = self.cells[:, None]
        p = split(y)
        place, speed, acceleration = (z[:, :, None] for z in self.ends(t))
        edge, dv = (
            np.diff(_with_ends(z, inner), axis=0) for z, inner in ((place, p.x), (speed, p.v))
        )
        size = np.sqrt(_dot(edge, edge))
        t_e = edge / size[:, None]
        t_t = (dv - t_e * _dot(t_e, dv)[:, None]) / size[:, None]
        e = size / l - 1
        e_t = _dot(t_e, dv) / l

        # tangents, their rates and spins with those of the clamps, as seen from the nodes
        tangent = _with_ends(CLAMPS[:, :, None], t_e)
        turning = _with_ends(np.zeros((2, 3, 1)), t_t)
        spin = np.concatenate((p.b_t[:1], p.w, p.b_t[1:]))
        omega = _cross(tangent, turning) + spin[:, None] * tangent
        t1 = tangent[:-1]
        t2 = tangent[1:]
        d1 = turning[:-1]
        d2 = turning[1:]

        # strains of the nodes, and their rates as seen from the section
        q = 1 + _dot(t1, t2)[:, None]
        K = 2 * _cross(t1, t2) / q
        K_t = (
            2 * (_cross(d1, t2) + _cross(t1, d2)) - K * (_dot(d1, t2) + _dot(t1, d2))[:, None]
        ) / q
        seen = K_t - _cross(0.5 * (omega[:-1] + omega[1:]), K)
        m_t = np.diff(spin, axis=0) + 0.5 * _dot(K, d1 + d2)

        # forces and moments
        tau = p.m / L
        tau_t = m_t / L
        Qs = 0.5 * (c.Qb + c.Qc)
        along, along_t = (_halves(l * z) / L for z in (e, e_t))
        twisted = c.Qb * tau + c.beta_K * Qs * tau_t
        T = c.Qa * (e + c.beta_K * e_t) + 0.5 * (twisted[:-1] + twisted[1:])
        M = c.Qc * along + c.Qd * tau + c.beta_K * (Qs * along_t + c.Qd * tau_t)
        n = c.EI * (K + c.beta_K * seen) / L[:, None]

        # what multiplies the tangents' rates and the spins in the virtual power
        turn = _cross(K, n)
        bend = _dot(n, K)[:, None]
        common = 0.5 * M[:, None] * K
        left = common + (2 * _cross(t2, n) - bend * t2) / q - 0.5 * _cross(turn, t1)
        right = common + (2 * _cross(n, t1) - bend * t1) / q - 0.5 * _cross(turn, t2)
        g = right[:-1] + left[1:] - (c.rhoJ * l * p.w)[:, None] * _cross(t_e, t_t)
        torque = np.zeros_like(spin)
        torque[:-1] += M + 0.5 * _dot(t1, turn)
        torque[1:] -= M - 0.5 * _dot(t2, turn)

        force = T[:, None] * t_e + (g - t_e * _dot(g, t_e)[:, None]) / size[:, None]
        F = _with_ends(np.zeros((2, 3, 1)), np.diff(force, axis=0))
        F[0] = force[0]
        F[-1] = -force[-1]
        F[:, 1] -= c.mass_per_length * GRAVITY * L
        mass = c.mass_per_length * L[:, None]
        reaction = mass[[0, -1]] * acceleration - F[[0, -1]]
        b_tt = np.zeros_like(p.b)
        if slip:
            b_tt[1] = (torque[-1] - self.arms[1] * reaction[1, 1] * slip) / self.swivel.inertia
        a = F[1:-1] / mass[1:-1]
        w_t = torque[1:-1] / (c.rhoJ * l)
        return Loads(reaction, -torque[[0, -1]], join(Parts(p.b_t, b_tt, p.v, a, m_t, w_t)))

    def rates(self, t: float, y: Array, slip: float) -> Array:
        """(size,): rates of one state (size,)."""
        return self.evaluate(t, y[:, None], slip).rates[:, 0]

    def jacobian(self, t: float, y: Array, slip: float) -> sp.csc_matrix:
        """Derivative of ``rates``, sparse: complex steps along all columns of the band that touch no common row."""
        size = y.size
        width = 2 * HALF_BAND + 1
        column = np.arange(size)
        steps = np.zeros((size, width), dtype=complex)
        steps[column, column % width] = 1e-30j
        slopes = self.evaluate(t, y[:, None] + steps, slip).rates.imag / 1e-30
        rows = np.repeat(column, width)
        columns = rows + np.tile(np.arange(-HALF_BAND, HALF_BAND + 1), size)
        inside = (columns >= 0) & (columns < size)
        rows = rows[inside]
        columns = columns[inside]
        values = slopes[rows, columns % width]
        kept = values != 0
        return sp.csc_matrix((values[kept], (rows[kept], columns[kept])), shape=(size, size))


def swept_area(a: Array, b: Array, c: Array) -> Array:
    """(n,): signed area of the spherical triangles with corners ``a``, ``b``, ``c`` (n, 3)."""
    triple = np.sum(a * np.cross(b, c), axis=1)
    return np.asarray(2 * np.arctan2(triple, 1 + np.sum(a * b + b * c + c * a, axis=1)))


def _with_ends(ends: Array, inner: Array) -> Array:
    """``inner`` with the row of the left end before it and that of the right end behind it."""
    shape = (1, *inner.shape[1:])
    return np.concatenate((np.broadcast_to(ends[0], shape), inner, np.broadcast_to(ends[1], shape)))


def _halves(z: Array) -> Array:
    """(N + 1, .): half of each edge's value to either node."""
    return np.asarray(0.5 * (np.concatenate((z, 0 * z[:1])) + np.concatenate((0 * z[:1], z))))


def _dot(a: Array, b: Array) -> Array:
    """Without complex conjugation."""
    return np.asarray(np.einsum("ij...,ij...->i...", a, b))


def _cross(a: Array, b: Array) -> Array:
    i = [1, 2, 0]
    j = [2, 0, 1]
    return np.asarray(a[:, i] * b[:, j] - a[:, j] * b[:, i])
