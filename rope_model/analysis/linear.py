"""Linear model of small motions x (7 of each node) about rest or steady flow, from derivatives of the residual R.

    M a + D v + K x = f ,   y = Cq x + Cv v + Ca a ,   K = dR/dq ,  D = dR/dv ,  M = dR/da + node masses .

f are the forces of the conveyances on the end nodes.  Unlike the tangent of Newton's method these
matrices contain the parts without energy: Qk, and wind.

Flow: the left end rises at the speed w, the right one sinks, and the rope flows through a loop that
stands still.  The rope's velocity is -w r' and its acceleration w^2 r''; its tension is higher by
rho w^2.  Nodes slide along the rope at the speed S, which is w about the loop and falls linearly to
0 at the ends.  Small motions of the nodes then obey

    (M a - 2 G v - H x) + D (v - S P x) + K x = f ,   G = int rho S N^T N' ,  H = int rho S^2 N'^T N' ,

with K at the flowing rope and P x the derivative of x along the rope at the nodes.  The lengths of
the legs are frozen, and the flow is left out of the inertia of spin.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from rope_model.analysis import chain_matrices
from rope_model.analysis.element_data import ElementData, element_data, of_elements, to_nodes
from rope_model.arrays import Array
from rope_model.engine import LinearFacts, NativeRope
from rope_model.fidelity.fidelity_rules import not_plumb
from rope_model.method.swivel_phases import Phase, frictionless
from rope_model.physics.element import PARAMETERS
from rope_model.physics.frame import conveyance_load
from rope_model.physics.hermite import GAUSS, bend, node_values
from rope_model.physics.node import ANGLE, NODE_DOF, SIDES, arc_lengths
from rope_model.physics.rope_element import Features, rope_element

#: outputs of an end
_LOADS = ("fx", "fy", "fz", "mx", "my", "mz")
_LOOP = ("x", "y", "z", "yaw")
_CORRECTIONS = 50  #: largest number of Newton corrections from the shape at rest to that in flow
_TOLERANCE = 1e-7  #: m and rad, size of the last one


@dataclass(frozen=True)
class LinearRope:
    """Small motions of a rope; coordinates are those of all nodes, row by row, prescribed ones included.

    ``outputs`` are fx ... mz of either end [N, N m] and the position and yaw of the loop [m, rad],
    ``rest`` their values at rest; ``maps`` are Cq, Cv and Ca, each (outputs, coordinates).
    """

    mass: sp.csc_matrix
    damping: sp.csc_matrix
    stiffness: sp.csc_matrix
    free: NDArray[np.bool_]
    outputs: tuple[str, ...]
    rest: Array
    maps: tuple[sp.csr_matrix, sp.csr_matrix, sp.csr_matrix]


def linear_rope(rope: NativeRope, speed: float = 0.0) -> LinearRope:
    """Return the small motions of a rope at rest, or of one through which its left end winds at the speed [m/s].

    Raises
    ------
    ValueError
        If it has no torsion, an end that is not plumb, touches a body, or finds no steady flow.
    """
    facts = rope.linear_facts()
    _require_linear(rope, facts.near_bodies)
    elements = element_data(rope)
    motion = rope.state.motion
    q = motion.q
    reaction = motion.reaction
    free = facts.free.ravel()
    at_rest = _derivatives_at(elements, q, np.zeros_like(q))
    K = at_rest.stiffness
    D = at_rest.damping
    M = at_rest.mass
    if speed:
        flow = _steady_flow(elements, q, _resisted(facts).ravel(), speed)
        q = flow.q
        reaction = flow.reaction
        slide = _sliding_speeds(elements, q, facts.lowest_s, speed)
        G, H = _sliding(elements, slide)
        along = _along(elements.lengths)
        K = flow.at.stiffness
        D = flow.at.damping
        M = flow.at.mass
        K = (K - D @ sp.diags(np.repeat(slide, NODE_DOF)) @ along - H).tocsc()
        D = (D - 2 * G).tocsc()
    M = (M + _swivel_inertia(rope, q)).tocsc()
    seen = [_load_of_end(q, reaction, node, K, D, M) for node in (0, len(q) - 1)]
    seen.append(_place_of_loop(elements, q, facts.lowest_s))
    C, C_v, C_a = (
        sp.vstack([getattr(rows, name) for rows in seen]).tocsr()
        for name in ("by_q", "by_v", "by_a")
    )
    names = (
        *(f"{side}.{load}" for side in SIDES for load in _LOADS),
        *(f"loop.{x}" for x in _LOOP),
    )
    rest = np.concatenate([rows.rest for rows in seen])
    return LinearRope(M, D, K, free, names, rest, (C, C_v, C_a))


def _resisted(facts: LinearFacts) -> NDArray[np.bool_]:
    """Return the free coordinates (nodes, 7), one fewer if the rope can spin as a whole.

    Nothing resists that of a straight rope between swivels that both turn freely: with the left end
    held its shape is the same, and the torques at its ends balance by themselves.
    """
    spins = facts.free[[0, -1], ANGLE].all() and not (facts.curved or facts.rubs)
    resisted = facts.free.copy()
    if spins:
        resisted[0, ANGLE] = False
    return resisted


def _require_linear(rope: NativeRope, near_bodies: bool) -> None:
    """Raise ValueError if the rope has no linear model where it is."""
    if rope.fidelity != "torsional":
        raise ValueError("model.fidelity must be 'torsional' for a linear model: set it")
    if not_plumb(rope.scene):
        raise ValueError("both ends must be plumb for a linear model: set attachment = 'plumb'")
    if near_bodies:
        raise ValueError(
            "the rope at rest touches a body in the shaft and has no linear model there: choose a height"
        )
    swivels = zip(SIDES, (rope.scene.left, rope.scene.right), rope.state.swivels, strict=True)
    for side, swivel, now in swivels:
        if now.phase is Phase.SLIP and not frictionless(swivel):
            raise ValueError(
                f"the {side} swivel slips, and its friction has no linear model: begin with a rope at rest"
            )


class _Derivatives(NamedTuple):
    """Residual R (nodes, 7) and its derivatives dR/dq, dR/dv and dR/da."""

    R: Array
    stiffness: sp.csc_matrix
    damping: sp.csc_matrix
    mass: sp.csc_matrix


def _derivatives_at(elements: ElementData, q: Array, v: Array) -> _Derivatives:
    """Return R and its derivatives of a rope ``q`` that moves steadily with ``v``, without swivels."""
    n = elements.lengths.size
    function = _derivatives(elements.features).map(n)
    nodes = (of_elements(x) for x in (q, v, np.zeros_like(q)))
    P = np.tile(elements.parameters_at(q, v)[:, None], n)
    R, K, D, M = function(*nodes, elements.lengths[None, :], elements.frames.T, P)
    K, D, M = (chain_matrices.of_elements(np.asarray(part), n) for part in (K, D, M))
    return _Derivatives(to_nodes(np.asarray(R)), K, D, M)


class _Flow(NamedTuple):
    """Shape (nodes, 7) of a rope that flows, the derivatives there, and the reactions at its ends."""

    q: Array
    at: _Derivatives
    reaction: Array


def _steady_flow(elements: ElementData, q: Array, free: NDArray[np.bool_], speed: float) -> _Flow:
    """Return the shape through which the rope flows at the speed [m/s], by Newton's method from that at rest."""
    along = _along(elements.lengths)
    through = _sliding(elements, np.full(len(q), speed))[1]
    no_flow = f"speed = {speed:g} m/s must leave the rope a steady flow: take a lower one"

    def imbalance(q: Array, R: Array) -> Array:
        return np.asarray(R - (through @ q.ravel()).reshape(q.shape))

    def derivatives(q: Array) -> _Derivatives:
        return _derivatives_at(elements, q, -speed * (along @ q.ravel()).reshape(q.shape))

    at = derivatives(q)
    for _ in range(_CORRECTIONS):
        tangent = (at.stiffness - speed * at.damping @ along - through).tocsc()[free][:, free]
        change = np.zeros(q.size)
        try:
            change[free] = splu(tangent).solve(imbalance(q, at.R).ravel()[free])
        except RuntimeError as error:  # singular: no stiffness against some motion
            raise ValueError(no_flow) from error
        q = q - change.reshape(q.shape)
        at = derivatives(q)
        if np.abs(change).max() < _TOLERANCE:
            break
    else:
        raise ValueError(no_flow)
    pulled = np.zeros_like(q)
    pulled[0, :3] = -q[0, 3:6]
    pulled[-1, :3] = q[-1, 3:6]
    rho = float(elements.parameters[PARAMETERS.index("rho")])
    return _Flow(q, at, imbalance(q, at.R) + rho * speed**2 * pulled)


def _sliding_speeds(elements: ElementData, q: Array, lowest_s: float, speed: float) -> Array:
    """Return the speed (nodes,) at which nodes slide along the rope, which is that of the flow about the loop."""
    s = arc_lengths(elements.lengths)
    span = float(np.linalg.norm(q[-1, :3:2] - q[0, :3:2]))
    places = [0.0, lowest_s - span, lowest_s + span, float(s[-1])]
    return np.interp(s, places, [0.0, speed, speed, 0.0])


def _sliding(elements: ElementData, speeds: Array) -> tuple[sp.csc_matrix, sp.csc_matrix]:
    """Return G and H of nodes that slide along the rope at the speeds (nodes,)."""
    n = elements.lengths.size
    rho = float(elements.parameters[PARAMETERS.index("rho")])
    of_nodes = np.vstack((speeds[:-1], speeds[1:]))
    G, H = (np.asarray(part) for part in _flow().map(n)(elements.lengths[None, :], of_nodes))
    return chain_matrices.of_elements(rho * G, n), chain_matrices.of_elements(rho * H, n)


def _swivel_inertia(rope: NativeRope, q: Array) -> sp.dia_matrix:
    """Return the inertia of the swivels, on theta of the ends."""
    inertia = np.zeros_like(q)
    inertia[0, ANGLE] = rope.scene.left.inertia
    inertia[-1, ANGLE] = rope.scene.right.inertia
    return sp.diags(inertia.ravel())


class _Outputs(NamedTuple):
    """Some outputs at rest, and their derivatives (outputs, coordinates) to q, v and a."""

    rest: Array
    by_q: sp.csr_matrix
    by_v: sp.csr_matrix
    by_a: sp.csr_matrix


def _load_of_end(
    q: Array, reaction: Array, node: int, K: sp.csc_matrix, D: sp.csc_matrix, M: sp.csc_matrix
) -> _Outputs:
    """Return force and moment of the rope on the conveyance at an end."""
    entries = slice(NODE_DOF * node, NODE_DOF * (node + 1))
    by_q, by_f, rest = (np.asarray(part) for part in _end_load()(q[node], reaction[node]))
    here = sp.eye(q.size, format="csr")[entries]
    by_position = sp.csr_matrix(by_q @ here + by_f @ K[entries])
    return _Outputs(
        rest.ravel(),
        by_position,
        sp.csr_matrix(by_f @ D[entries]),
        sp.csr_matrix(by_f @ M[entries]),
    )


def _place_of_loop(elements: ElementData, q: Array, lowest_s: float) -> _Outputs:
    """Return position and yaw of the loop's lowest point."""
    s = arc_lengths(elements.lengths)
    last = elements.lengths.size - 1
    e = min(int(np.searchsorted(s, lowest_s, side="right")) - 1, last)
    l = float(elements.lengths[e])
    by_element, rest = (
        np.asarray(part) for part in _loop()(of_elements(q)[:, e], (lowest_s - s[e]) / l, l)
    )
    by_q = np.zeros((len(_LOOP), q.size))
    by_q[:, NODE_DOF * e : NODE_DOF * (e + 2)] = by_element
    nothing = sp.csr_matrix(by_q.shape)
    return _Outputs(rest.ravel(), sp.csr_matrix(by_q), nothing, nothing)


@cache
def _derivatives(features: Features) -> Any:
    """Build (q, v, a, l, F, P) -> R, dR/dq, dR/dv, dR/da of one element."""
    residual = rope_element("torsional", features).residual
    x = [ca.SX.sym(f"x{k}", residual.size1_in(k)) for k in range(residual.n_in())]
    R = residual(*x)
    return ca.Function(
        "derivatives", x, ca.cse([R, *(ca.densify(ca.jacobian(R, x[k])) for k in range(3))])
    )


def _along(lengths: Array) -> sp.csr_matrix:
    """Return P: derivatives of r, r' and theta along the rope at the nodes, means of both sides."""
    l = ca.SX.sym("l")
    q = ca.SX.sym("q", 2 * NODE_DOF)
    sides = []
    for node in (0, 1):
        slope = [q[NODE_DOF * node + k] for k in (3, 4, 5)]
        bends = [bend(node, l, *(q[j + k] for j in (0, 3, 7, 10))) for k in range(3)]
        sides += [*slope, *bends, (q[13] - q[6]) / l]
    parts = ca.Function("along", [l], [ca.densify(ca.jacobian(ca.vertcat(*sides), q))]).map(
        lengths.size
    )(lengths[None, :])
    weight = np.full(NODE_DOF * (lengths.size + 1), 0.5)
    weight[:NODE_DOF] = weight[-NODE_DOF:] = 1.0
    return sp.csr_matrix(
        sp.diags(weight) @ chain_matrices.of_elements(np.asarray(parts), lengths.size)
    )


@cache
def _flow() -> Any:
    """Build (l, S of both nodes) -> int S N^T N' and int S^2 N'^T N' of one element, without theta."""
    l = ca.SX.sym("l")
    S = ca.SX.sym("S", 2)
    q = ca.SX.sym("q", 2 * NODE_DOF)
    G = ca.SX.zeros(2 * NODE_DOF, 2 * NODE_DOF)
    H = ca.SX.zeros(2 * NODE_DOF, 2 * NODE_DOF)
    for xi, weight in GAUSS:
        B = ca.jacobian(ca.vertcat(*node_values(xi, l, ca.vertsplit(q))[:6]), q)
        N = B[:3, :]
        N_s = B[3:, :]
        speed = (1 - xi) * S[0] + xi * S[1]
        G = G + weight * l * speed * (N.T @ N_s)
        H = H + weight * l * speed**2 * (N_s.T @ N_s)
    return ca.Function("flow", [l, S], [ca.densify(G), ca.densify(H)])


@cache
def _end_load() -> Any:
    """Build (coordinates, reaction) of an end -> derivatives of its load with respect to both, and the load."""
    q = ca.SX.sym("q", NODE_DOF)
    f = ca.SX.sym("f", NODE_DOF)
    load = ca.vertcat(*conveyance_load(ca.vertsplit(q), ca.vertsplit(f), f[6]))
    return ca.Function(
        "end_load", [q, f], [ca.densify(ca.jacobian(load, x)) for x in (q, f)] + [load]
    )


@cache
def _loop() -> Any:
    """Build (nodes, xi, l) -> derivative of the lowest point's position and yaw, which moves so that y' = 0."""
    q = ca.SX.sym("q", 2 * NODE_DOF)
    xi = ca.SX.sym("xi")
    l = ca.SX.sym("l")
    point = node_values(xi, l, ca.vertsplit(q))
    position = ca.vertcat(*point[:3], ca.atan2(-point[5], point[3]))
    moved = (
        ca.jacobian(position, xi)
        @ ca.jacobian(point[4], q)
        / (l * bend(xi, l, *(q[k] for k in (1, 4, 8, 11))))
    )
    return ca.Function("loop", [q, xi, l], [ca.densify(ca.jacobian(position, q) - moved), position])
