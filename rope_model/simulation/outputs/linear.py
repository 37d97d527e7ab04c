"""Small motions x (7 of each node) of a rope about a rest, from exact derivatives of the element's residual R.

    M a + D v + K x = f ,   y = Cq x + Cv v + Ca a ,   K = dR/dq ,  D = dR/dv ,  M = dR/da + node masses .

f are the forces of the conveyances on the end nodes.  Unlike the tangent of Newton's method these have the parts
without energy: Qk, and air that blows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from rope_model.physics.element import NODE_DOF
from rope_model.physics.frame import conveyance_load
from rope_model.physics.hermite import bend, node_values
from rope_model.simulation.ends.ends import Phase
from rope_model.simulation.ends.paths import SIDES
from rope_model.simulation.messages.fidelity_rules import not_plumb
from rope_model.simulation.outputs.modal import assembled
from rope_model.simulation.outputs.signals import Evaluated
from rope_model.simulation.rope_kernels import Kinds, rope_element
from rope_model.simulation.rope_system import Array, arc_lengths
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.stepping.hang import equilibrium_in_frame

#: outputs of an end, and of the loop
_LOADS = ("fx", "fy", "fz", "mx", "my", "mz")
_LOOP = ("x", "y", "z", "yaw")


@dataclass(frozen=True)
class LinearRope:
    """A rope's small motions; coordinates are those of all nodes, row by row, the held ones of the ends included.

    ``outputs`` are fx ... mz of either end [N, N m] and the place and yaw of the loop [m, rad], ``rest`` their values
    at rest; ``maps`` are Cq, Cv and Ca, each (outputs, coordinates).
    """

    mass: sp.csc_matrix
    damping: sp.csc_matrix
    stiffness: sp.csc_matrix
    free: NDArray[np.bool_]
    outputs: tuple[str, ...]
    rest: Array
    maps: tuple[sp.csr_matrix, sp.csr_matrix, sp.csr_matrix]


def linear_rope(rope: Evaluated) -> LinearRope:
    """Return the small motions of a rope at rest.

    Raises
    ------
    ValueError
        If it has no torsion, an end that is not plumb, or touches a body.
    """
    system, motion = rope.system, rope.state.motion
    q, n = motion.q, system.lengths.size
    if system.kernels.fidelity != "torsional":
        raise ValueError("model.fidelity must be 'torsional' for a linear model: set it")
    if not_plumb(rope.scene):
        raise ValueError("both ends must be plumb for a linear model: set attachment = 'plumb'")
    if system.longest_near(q) > 0.0:
        raise ValueError("the rope at rest touches a body in the shaft and has no linear model there: choose a height")
    rest = np.zeros_like(q)
    frames, P = system.element_data(q, rest)
    both, none = np.hstack((q[:-1], q[1:])).T, np.zeros((2 * NODE_DOF, n))
    parts = _derivatives(system.kernels.kinds).map(n)(
        both, none, none, system.lengths[None, :], frames.T, np.tile(P[:, None], n)
    )
    K, D, M = (assembled(np.asarray(part), n) for part in parts)
    M = (M + sp.diags(system.node_mass.ravel())).tocsc()
    rows, values = [], []
    for node in (0, n):
        mine = slice(NODE_DOF * node, NODE_DOF * (node + 1))
        found = _end_load()(q[node], motion.reaction[node])
        by_q, by_f, at_rest = (np.asarray(part) for part in found)
        here = sp.csr_matrix(np.eye(NODE_DOF * (n + 1))[mine])
        rows.append([by_q @ here + by_f @ K[mine], by_f @ D[mine], by_f @ M[mine]])
        values.append(at_rest.ravel())
    nodes_s = arc_lengths(system.lengths)
    i = min(int(np.searchsorted(nodes_s, rope.loop.s, side="right")) - 1, n - 1)
    l = float(system.lengths[i])
    by_q, at_rest = (np.asarray(x) for x in _loop()(both[:, i], (rope.loop.s - nodes_s[i]) / l, l))
    loop = np.zeros((len(_LOOP), q.size))
    loop[:, NODE_DOF * i : NODE_DOF * (i + 2)] = by_q
    rows.append([loop, np.zeros_like(loop), np.zeros_like(loop)])
    maps = [sp.csr_matrix(sp.vstack([sp.csr_matrix(part) for part in parts])) for parts in zip(*rows, strict=True)]
    names = (*(f"{side}.{load}" for side in SIDES for load in _LOADS), *(f"loop.{x}" for x in _LOOP))
    values.append(at_rest.ravel())
    return LinearRope(M, D, K, system.free.ravel(), names, np.concatenate(values), (maps[0], maps[1], maps[2]))


def let_turn(rope: RopeSimulator) -> None:
    """Let a rope that has just been hung come to rest in those of its swivels that turn freely; others hold."""
    state, swivels = rope.state, (rope.scene.left, rope.scene.right)
    phases = [
        now._replace(phase=Phase.SLIP) if of.mode == "free" else now
        for now, of in zip(state.swivels, swivels, strict=True)
    ]
    if any(now.phase is Phase.SLIP for now in phases):
        rope.restore(equilibrium_in_frame(rope.model, state._replace(swivels=(phases[0], phases[1])))[0])


@cache
def _derivatives(kinds: Kinds) -> Any:
    """(q, v, a, l, F, P) -> dR/dq, dR/dv, dR/da of one element."""
    residual = rope_element("torsional", kinds).residual
    x = [ca.SX.sym(f"x{k}", residual.size1_in(k)) for k in range(residual.n_in())]
    R = residual(*x)
    return ca.Function("derivatives", x, ca.cse([ca.densify(ca.jacobian(R, x[k])) for k in range(3)]))


@cache
def _end_load() -> Any:
    """(coordinates, reaction) of an end -> derivatives of its load to both, the load."""
    q, f = ca.SX.sym("q", NODE_DOF), ca.SX.sym("f", NODE_DOF)
    load = ca.vertcat(*conveyance_load(ca.vertsplit(q), ca.vertsplit(f), f[6]))
    return ca.Function("end_load", [q, f], [ca.densify(ca.jacobian(load, x)) for x in (q, f)] + [load])


@cache
def _loop() -> Any:
    """(nodes, xi, l) -> derivative of the lowest point's place and yaw as it moves along the rope, with y' = 0."""
    q, xi, l = ca.SX.sym("q", 2 * NODE_DOF), ca.SX.sym("xi"), ca.SX.sym("l")
    point = node_values(xi, l, ca.vertsplit(q))
    place = ca.vertcat(*point[:3], ca.atan2(-point[5], point[3]))
    moved = ca.jacobian(place, xi) @ ca.jacobian(point[4], q) / (l * bend(xi, l, *(q[k] for k in (1, 4, 8, 11))))
    return ca.Function("loop", [q, xi, l], [ca.densify(ca.jacobian(place, q) - moved), place])
