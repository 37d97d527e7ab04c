"""A long rod, its ends nearer to each other than it is long, that is turned: its slack gathers in one buckle.

With m = M/(2 sqrt(B T)), B = EI and C = Qd, the buckle of an endless rod takes up

    slack = 4 sqrt(B/T) sqrt(1 - m^2),     turn = M L/C + 4 arccos m

of which the rod follows the branch that begins at m = 1, until its torque no longer grows with the turn.

Sources: J. Coyne, IEEE J. Oceanic Eng. 15 (1990) 72-83; G. van der Heijden and J. Thompson, Nonlinear Dynamics 21
(2000) 71-99.
"""

import math
from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from evidence.statics import clamped, rod, turned
from evidence.tables import Array, Table, table
from rope_model.parameters import Rope
from rope_model.physics.node import ANGLE, POSITION
from rope_model.reference.statics import find_equilibrium

#: m, m, N, N m^2, N m^2
LENGTH = 60.0
SLACK = 4.0
AXIAL = 1e7
BEND = 200.0
TORSION = 400.0
TURNS = (4.0, 5.0)
#: turns between two shapes at rest
STEP = 0.25


def theory(turns: float) -> tuple[float, float]:
    """Torque (N m) and pull (N)."""

    def loads(m: float) -> tuple[float, float]:
        pull = 16.0 * BEND * (1.0 - m * m) / SLACK**2
        return 2.0 * m * math.sqrt(BEND * pull), pull

    def missing(m: float) -> float:
        return loads(m)[0] * LENGTH / TORSION + 4.0 * math.acos(m) - 2.0 * math.pi * turns

    # the torque is largest at m^2 = 1/2; beyond it the turn falls to 0 at m = 1
    return loads(brentq(missing, math.sqrt(0.5), 1.0, xtol=1e-14))


def planar(length: float, slack: float, elements: int) -> Array:
    """A guess of a rod (nodes, 7) between clamps on one axis, buckled in a plane."""
    s = np.linspace(0.0, length, elements + 1)
    q = np.zeros((s.size, 7))
    # so high that its arc is about as long as the rod
    height = 2.0 / math.pi * math.sqrt(slack * (length - slack))
    q[:, 0] = s * (1.0 - slack / length)
    q[:, 1] = height * np.sin(math.pi * s / length) ** 2
    q[:, 3:6] = np.gradient(q[:, POSITION], s, axis=0)
    q[:, 3:6] /= np.linalg.norm(q[:, 3:6], axis=1)[:, None]
    q[[0, -1], 3:6] = [1.0, 0.0, 0.0]
    return q


def ours(elements: int = 240) -> Iterator[tuple[float, float]]:
    """The same at TURNS, of the model's rod."""
    guess = planar(LENGTH, SLACK, elements)
    rope = Rope(LENGTH, Qa=AXIAL, Qb=0.0, Qc=0.0, Qd=TORSION, EI=BEND)
    equations = rod(rope, 0.0, guess, clamped(guess))
    at_rest = find_equilibrium(equations, guess)
    for k in range(1, round(max(TURNS) / STEP) + 1):
        at_rest = turned(equations, at_rest.q, 2.0 * math.pi * STEP)
        if k * STEP in TURNS:
            yield float(at_rest.reaction[-1, ANGLE]), float(at_rest.reaction[-1, 0])


def measure() -> Table:
    """Ours and the theory's."""
    found = []
    for turns, (torque, pull) in zip(TURNS, ours(), strict=True):
        exact = theory(turns)
        found.append((turns, torque, exact[0], pull, exact[1]))
    return table(("turns", "torque", "exact_torque", "pull", "exact_pull"), found)
