"""A leg pressed at rest against a thin divider: the rope on its own mesh, and a chain of many straight pieces.

The chain is another code: stretch of its pieces, turns between them, weight and the spring of contact in its nodes,
which stand 2 mm apart where the divider is.  Its rest is where the energy is least, by Newton's method.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rope_model import EndMotion
from rope_model.parameters import Layout, Model, Rope, Scene
from rope_model.physics.contact import ONSET
from rope_model.shaft_parameters import Contact, Divider, Shaft
from rope_model.simulation.diagnostics import loop_bottom
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.statics import find_equilibrium
from rope_model.simulation.transfer import interpolate

Array = NDArray[np.float64]
#: m: size of the divider, its height and its place; how far the rope is put beside it first
SIZE, HEIGHT, OFFSET, ASIDE = 0.02, -30.0, -0.5, 0.05
#: m: distance of the chain's nodes at the divider, for half a metre to either side, and how fast it grows from there
NODES, AROUND, GROWTH, FAR = 2e-3, 0.5, 1.05, 0.25


@dataclass(frozen=True)
class Pressed:
    """Force (N) of the divider on the rope, and on the chain."""

    rope: float
    chain: float


def pressed() -> Pressed:
    """Both at rest on the same side of the divider."""
    rope, layout = Rope(Qb=0.0, Qc=0.0), Layout()
    shaft = Shaft(divider_1=Divider(size=SIZE, y=HEIGHT, offset=OFFSET))
    scene = Scene(rope=rope, layout=layout, model=Model(fidelity="planar"), shaft=shaft)
    simulator = RopeSimulator(scene)
    status = simulator.initialize(0.0, EndMotion(), EndMotion())
    if not status.valid:
        raise RuntimeError(status.message)
    state = simulator.state
    s, guess = state.partition.nodes_s, simulator.state.motion.q.copy()
    bottom = loop_bottom(guess, state.partition.lengths).s
    here = float(np.interp(-HEIGHT, -guess[s < bottom, 1], s[s < bottom]))
    aside = OFFSET + 0.5 * SIZE + 0.5 * rope.diameter + ASIDE - np.interp(here, s, guess[:, 0])
    guess[:, 0] += aside * np.interp(s, [0.0, here, bottom], [0.0, 1.0, 0.0])
    found = find_equilibrium(simulator.system.with_reference(state.motion.q), guess)
    force = simulator.system.outside(found.q, np.zeros_like(found.q))["divider"]
    places = _places(here, rope.length)
    return Pressed(force, _chain_force(scene, places, interpolate(found.q, s, places)[:, :2]))


def _places(here: float, length: float) -> Array:
    """Arc lengths (m) of the chain's nodes."""
    away = [*np.arange(NODES, AROUND, NODES)]
    while away[-1] < length:
        away.append(away[-1] + min(max(NODES, (GROWTH - 1.0) * (away[-1] - AROUND + NODES)), FAR))
    s = np.concatenate((-np.array(away[::-1]), [0.0], away)) + here
    inside = s[(s > 0.5 * FAR) & (s < length - 0.5 * FAR)]
    return np.concatenate(([0.0], inside, [length]))


def _chain_force(scene: Scene, s: Array, guess: Array) -> float:
    """Force (N) of the divider on a chain with nodes at ``s`` that comes to rest from ``guess`` (n, 2)."""
    rope, n, lengths = scene.rope, s.size, np.diff(s)
    weight = rope.mass_per_length * scene.layout.gravity
    x = ca.SX.sym("x", 2, n - 2)
    ends = np.array([[-0.5, 0.0], [0.5, 0.0]]) * scene.layout.spacing
    r = ca.horzcat(ends[0], x, ends[1])
    l, share = ca.DM(lengths).T, ca.DM(0.5 * (np.append(lengths, 0.0) + np.append(0.0, lengths))).T
    pieces = r[:, 1:] - r[:, :-1]
    size = ca.sqrt(ca.sum1(pieces**2))
    tangents = ca.horzcat(ca.DM([0.0, -1.0]), pieces / ca.repmat(size, 2, 1), ca.DM([0.0, 1.0]))
    turns = ca.sum1((tangents[:, 1:] - tangents[:, :-1]) ** 2)
    energy = 0.5 * rope.Qa * ca.sum2(l * (size / l - 1.0) ** 2) + 0.5 * rope.EI * ca.sum2(turns / share)
    energy += weight * ca.sum2(share * r[1, :])
    depth = 0.5 * (rope.diameter + SIZE) - ca.sqrt((r[0, :] - OFFSET) ** 2 + (r[1, :] - HEIGHT) ** 2)
    energy += ca.sum2(share * _spring_energy(scene.shaft.contact, ONSET * rope.diameter, ca.fmax(depth, 0.0)))
    pressure = _spring(scene.shaft.contact, ONSET * rope.diameter, ca.fmax(depth, 0.0))
    hessian, gradient = ca.hessian(energy, ca.vec(x))
    look = ca.Function("look", [ca.vec(x)], [energy, gradient, hessian])
    at = guess[1:-1].ravel()
    solver = ca.Linsol("rest", "ldl", hessian.sparsity())
    for _ in range(200):
        _, g, H = look(at)
        step = np.array(solver.solve(H, -g)).ravel()
        part = min(1.0, 0.1 / np.abs(step).max())
        at = at + part * step
        if np.abs(step).max() < 1e-10:
            break
    else:
        raise RuntimeError("the chain finds no rest")
    return float(ca.Function("force", [ca.vec(x)], [ca.sum2(share * pressure)])(at))


def _spring_energy(contact: Contact, onset: float, depth: Any) -> Any:
    soft = ca.fmin(depth, onset)
    return contact.stiffness * (soft**3 / (6.0 * onset) + 0.5 * (depth - soft) * depth)


def _spring(contact: Contact, onset: float, depth: Any) -> Any:
    soft = ca.fmin(depth, onset)
    return contact.stiffness * (soft**2 / (2.0 * onset) + depth - soft)
