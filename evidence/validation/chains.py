"""Ropes that are soft enough for a chain's theory: one folded and let go, one hanging by one end.

A folded chain that keeps its energy pulls at its held end, when its tip has fallen by x of its length, with
T/(rho g L) = (1 + x)/2 + x (2 - x)/(4 (1 - x)).  Calkin and March, Am. J. Phys. 57 (1989) 154, measured the pull and
found that dependence, and some 25 times the weight at most: so D. Cline, Variational Principles in Classical Mechanics,
chapter 8; of the largest pull also Wong and Yasui, Am. J. Phys. 74 (2006) 490.

A hanging chain swings with omega = j/2 sqrt(g/L), j the zeros of the Bessel function J0 (D. Bernoulli).
"""

import math
from functools import cache

import numpy as np
from scipy.special import jn_zeros

from evidence.statics import OUT_OF_PLANE, held, matrix, rod
from evidence.tables import Array, Table, table
from evidence.validation.falling import CHAIN, GRAVITY, Fall, exact_fall, fall
from rope_model.analysis.modes import modes_of
from rope_model.parameters import Rope
from rope_model.physics.node import POSITION
from rope_model.reference.statics import find_equilibrium

WEIGHT = Rope.mass_per_length * GRAVITY  # N/m
EI = 1.0  # N m^2: the fold of the falling rope is 1.2 % of it
FOLD = (EI / WEIGHT) ** (1 / 3) / CHAIN
DEPTHS = (0.1, 0.3, 0.5, 0.7, 0.9)  # of the tip, over the length
MODES = 4


@cache
def _fallen() -> Fall:
    return fall(EI, 100, 5e-3, 1e-3)


def pull(x: Array) -> Array:
    """Of the chain's held end over its weight."""
    return 0.5 * (1 + x) + 0.25 * x * (2 - x) / (1 - x)


def pulls() -> Table:
    """Ours and the chain's, over the weight, on the tip's way down."""
    found = _fallen()
    x = np.array(DEPTHS)
    ours = np.interp(x, found.depth / CHAIN, found.pull / (WEIGHT * CHAIN))
    return table(("depth", "ours", "chain"), list(zip(x, ours, pull(x), strict=True)))


def fall_time() -> float:
    """Ours over the chain's, less one."""
    exact = exact_fall()[0][-1] * math.sqrt(2 * CHAIN / GRAVITY)
    return float(_fallen().t[-1] / exact) - 1


def swings(elements: int = 120) -> Table:
    """Frequencies (Hz) of a rope of the default length and mass with EI = 1 N m^2, in its plane.

    Its elements are 4.3 (EI / rho g)^(1/3) long: on longer ones the free end is unstable.
    """
    rope = Rope(EI=EI, Qb=0.0, Qc=0.0)
    s = np.linspace(0.0, rope.length, elements + 1)
    q = np.zeros((s.size, 7))
    q[:, 1] = -s
    q[:, 4] = -1.0
    equations = rod(rope, GRAVITY, q, held(q, OUT_OF_PLANE, (0, POSITION)))
    q = find_equilibrium(equations, q).q
    stiffness = matrix(equations, q, (1.0, 0.0, 0.0))
    mass = matrix(equations, q, (0.0, 0.0, 1.0))
    ours = modes_of(stiffness, mass, ~equations.held, MODES).frequencies
    chain = jn_zeros(0, MODES) / (4 * np.pi) * math.sqrt(GRAVITY / rope.length)
    return table(
        ("mode", "ours", "chain"), list(zip(range(1, MODES + 1), ours, chain, strict=True))
    )
