"""Linear model of small motions x (7 of each node) about rest or steady flow, from derivatives of the residual R.

    M a + D v + K x = f ,   y = Cq x + Cv v + Ca a ,   K = dR/dq ,  D = dR/dv ,  M = dR/da + node masses .

f are the forces of the conveyances on the end nodes.  Unlike the tangent of Newton's method these matrices contain the
parts without energy: Qk, and wind.

Flow: the left end rises at the speed w, the right one sinks, and the rope flows through a loop that stands still.  The
rope's velocity is -w r' and its acceleration w^2 r''; its tension is higher by rho w^2.  Nodes slide along the rope at
the speed S, which is w about the loop and falls linearly to 0 at the ends.  Small motions of the nodes then obey

    (M a - 2 G v - H x) + D (v - S P x) + K x = f ,   G = int rho S N^T N' ,  H = int rho S^2 N'^T N' ,

with K at the flowing rope and P x the derivative of x along the rope at the nodes.  The lengths of the legs are frozen,
and the flow is left out of the inertia of spin.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from rope_model.physics.element import NODE_DOF, PARAMETERS
from rope_model.physics.frame import conveyance_load
from rope_model.physics.hermite import GAUSS, bend, node_values
from rope_model.simulation.ends.paths import SIDES
from rope_model.simulation.ends.swivel_phases import Phase
from rope_model.simulation.messages.fidelity_rules import not_plumb
from rope_model.simulation.outputs.modal import assembled
from rope_model.simulation.outputs.signals import SignalSource
from rope_model.simulation.rope_kernels import Features, rope_element
from rope_model.simulation.rope_system import Array, arc_lengths
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.stepping.hang import equilibrium_in_frame

#: outputs of an end
_LOADS = ("fx", "fy", "fz", "mx", "my", "mz")
_LOOP = ("x", "y", "z", "yaw")
_CORRECTIONS = 50  #: largest number of Newton corrections from the shape at rest to that in flow
_TOLERANCE = 1e-7  #: m and rad, size of the last one


@dataclass(frozen=True)
class LinearRope:
    """Small motions of a rope; coordinates are those of all nodes, row by row, prescribed ones included.

    ``outputs`` are fx ... mz of either end [N, N m] and the position and yaw of the loop [m, rad], ``rest`` their
    values at rest; ``maps`` are Cq, Cv and Ca, each (outputs, coordinates).
    """

    mass: sp.csc_matrix
    damping: sp.csc_matrix
    stiffness: sp.csc_matrix
    free: NDArray[np.bool_]
    outputs: tuple[str, ...]
    rest: Array
    maps: tuple[sp.csr_matrix, sp.csr_matrix, sp.csr_matrix]


def linear_rope(rope: SignalSource, speed: float = 0.0) -> LinearRope:
    """Return the small motions of a rope at rest, or of one through which its left end winds at the speed [m/s].

    Raises
    ------
    ValueError
        If it has no torsion, an end that is not plumb, touches a body, or finds no steady flow.
    """
    system, motion = rope.system, rope.state.motion
    q, n = motion.q, system.lengths.size
    if system.kernels.fidelity != "torsional":
        raise ValueError("model.fidelity must be 'torsional' for a linear model: set it")
    if not_plumb(rope.scene):
        raise ValueError("both ends must be plumb for a linear model: set attachment = 'plumb'")
    if system.longest_near(q) > 0.0:
        raise ValueError(
            "the rope at rest touches a body in the shaft and has no linear model there: choose a height"
        )
    nodes_s, lengths = arc_lengths(system.lengths), system.lengths[None, :]
    derivatives, rho = (
        _derivatives(system.kernels.features).map(n),
        float(system.P[PARAMETERS.index("rho")]),
    )
    along = _along(system.lengths)

    def evaluated(q: Array) -> tuple[Array, tuple[sp.csc_matrix, ...]]:
        """R and its derivatives where the rope flows through q."""
        v = -speed * (along @ q.ravel()).reshape(q.shape)
        frames, P = system.element_data(q, v)
        sides = (np.hstack((x[:-1], x[1:])).T for x in (q, v, np.zeros_like(q)))
        R, *parts = derivatives(*sides, lengths, frames.T, np.tile(P[:, None], n))
        blocks, R_nodes = np.asarray(R).reshape(2, NODE_DOF, n), np.zeros_like(q)
        R_nodes[:-1] += blocks[0].T
        R_nodes[1:] += blocks[1].T
        return R_nodes, tuple(assembled(np.asarray(part), n) for part in parts)

    def flow(speeds: Array) -> tuple[sp.csc_matrix, sp.csc_matrix]:
        """G and H of nodes that slide."""
        G, H = (
            np.asarray(x) for x in _flow().map(n)(lengths, np.vstack((speeds[:-1], speeds[1:])))
        )
        return assembled(rho * G, n), assembled(rho * H, n)

    R, (K, D, M) = evaluated(q)
    reaction = motion.reaction
    if speed:
        free, through = system.free.ravel(), flow(np.full(n + 1, speed))[1]
        for _ in range(_CORRECTIONS):
            missing = (R - (through @ q.ravel()).reshape(q.shape) - system.load).ravel()[free]
            change = np.zeros(q.size)
            change[free] = splu((K - speed * D @ along - through).tocsc()[free][:, free]).solve(
                missing
            )
            q = q - change.reshape(q.shape)
            R, (K, D, M) = evaluated(q)
            if np.abs(change).max() < _TOLERANCE:
                break
        else:
            raise ValueError(
                f"speed = {speed:g} m/s must leave the rope a steady flow: take a lower one"
            )
        pulled = np.zeros_like(q)
        pulled[0, :3], pulled[-1, :3] = -q[0, 3:6], q[-1, 3:6]
        reaction = (
            R - (through @ q.ravel()).reshape(q.shape) + rho * speed**2 * pulled - system.load
        )
        span = float(np.linalg.norm(q[-1, :3:2] - q[0, :3:2]))
        slide = np.interp(
            nodes_s,
            [0.0, rope.loop.s - span, rope.loop.s + span, nodes_s[-1]],
            [0.0, *[speed] * 2, 0.0],
        )
        G, H = flow(slide)
        K = (K - D @ sp.diags(np.repeat(slide, NODE_DOF)) @ along - H).tocsc()
        D = (D - 2 * G).tocsc()
    both = np.hstack((q[:-1], q[1:])).T
    M = (M + sp.diags(system.node_mass.ravel())).tocsc()
    rows, values = [], []
    for node in (0, n):
        mine = slice(NODE_DOF * node, NODE_DOF * (node + 1))
        by_q, by_f, at_rest = (np.asarray(part) for part in _end_load()(q[node], reaction[node]))
        here = sp.eye(NODE_DOF * (n + 1), format="csr")[mine]
        rows.append([by_q @ here + by_f @ K[mine], by_f @ D[mine], by_f @ M[mine]])
        values.append(at_rest.ravel())
    i = min(int(np.searchsorted(nodes_s, rope.loop.s, side="right")) - 1, n - 1)
    l = float(system.lengths[i])
    by_q, at_rest = (np.asarray(x) for x in _loop()(both[:, i], (rope.loop.s - nodes_s[i]) / l, l))
    loop = np.zeros((len(_LOOP), q.size))
    loop[:, NODE_DOF * i : NODE_DOF * (i + 2)] = by_q
    rows.append([loop, np.zeros_like(loop), np.zeros_like(loop)])
    maps = [
        sp.csr_matrix(sp.vstack([sp.csr_matrix(part) for part in parts]))
        for parts in zip(*rows, strict=True)
    ]
    names = (
        *(f"{side}.{load}" for side in SIDES for load in _LOADS),
        *(f"loop.{x}" for x in _LOOP),
    )
    values.append(at_rest.ravel())
    return LinearRope(
        M, D, K, system.free.ravel(), names, np.concatenate(values), (maps[0], maps[1], maps[2])
    )


def let_turn(rope: RopeSimulator) -> None:
    """Let a rope that has just been hung come to rest in those swivels that turn freely; others hold."""
    state, swivels = rope.state, (rope.scene.left, rope.scene.right)
    phases = [
        swivel_state._replace(phase=Phase.SLIP) if swivel.mode == "free" else swivel_state
        for swivel_state, swivel in zip(state.swivels, swivels, strict=True)
    ]
    if any(swivel_state.phase is Phase.SLIP for swivel_state in phases):
        rope.restore(
            equilibrium_in_frame(rope.model, state._replace(swivels=(phases[0], phases[1])))[0]
        )


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
    l, q = ca.SX.sym("l"), ca.SX.sym("q", 2 * NODE_DOF)
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
    return sp.csr_matrix(sp.diags(weight) @ assembled(np.asarray(parts), lengths.size))


@cache
def _flow() -> Any:
    """Build (l, S of both nodes) -> int S N^T N' and int S^2 N'^T N' of one element, without theta."""
    l, S, q = ca.SX.sym("l"), ca.SX.sym("S", 2), ca.SX.sym("q", 2 * NODE_DOF)
    G, H = ca.SX.zeros(2 * NODE_DOF, 2 * NODE_DOF), ca.SX.zeros(2 * NODE_DOF, 2 * NODE_DOF)
    for xi, weight in GAUSS:
        B = ca.jacobian(ca.vertcat(*node_values(xi, l, ca.vertsplit(q))[:6]), q)
        N, N_s, speed = B[:3, :], B[3:, :], (1 - xi) * S[0] + xi * S[1]
        G, H = G + weight * l * speed * (N.T @ N_s), H + weight * l * speed**2 * (N_s.T @ N_s)
    return ca.Function("flow", [l, S], [ca.densify(G), ca.densify(H)])


@cache
def _end_load() -> Any:
    """Build (coordinates, reaction) of an end -> derivatives of its load with respect to both, and the load."""
    q, f = ca.SX.sym("q", NODE_DOF), ca.SX.sym("f", NODE_DOF)
    load = ca.vertcat(*conveyance_load(ca.vertsplit(q), ca.vertsplit(f), f[6]))
    return ca.Function(
        "end_load", [q, f], [ca.densify(ca.jacobian(load, x)) for x in (q, f)] + [load]
    )


@cache
def _loop() -> Any:
    """Build (nodes, xi, l) -> derivative of the lowest point's position and yaw, which moves so that y' = 0."""
    q, xi, l = ca.SX.sym("q", 2 * NODE_DOF), ca.SX.sym("xi"), ca.SX.sym("l")
    point = node_values(xi, l, ca.vertsplit(q))
    position = ca.vertcat(*point[:3], ca.atan2(-point[5], point[3]))
    moved = (
        ca.jacobian(position, xi)
        @ ca.jacobian(point[4], q)
        / (l * bend(xi, l, *(q[k] for k in (1, 4, 8, 11))))
    )
    return ca.Function("loop", [q, xi, l], [ca.densify(ca.jacobian(position, q) - moved), position])
