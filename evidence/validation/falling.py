"""A dropped end: the free end of a folded rope falls faster than g."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad

from evidence.statics import OUT_OF_PLANE, held, rod
from evidence.tables import Array
from rope_model.method.generalized_alpha import Motion
from rope_model.parameters import Layout, Rope
from rope_model.physics.node import POSITION
from rope_model.reference.equations import Equations
from rope_model.reference.generalized_alpha import largest_error, restart, step
from rope_model.reference.statics import find_equilibrium, hanging_guess

GRAVITY = Layout().gravity
CHAIN = 20.0  # m
RHO_INF = 0.8
NEWTON = 1e-8  # m and rad, last correction of a step


@dataclass(frozen=True)
class Fall:
    """Times (s), depths (m) of the tip, pulls (N) of the held end, until the tip is lowest.

    ``unexplained`` is energy over rho g L^2.
    """

    t: Array
    depth: Array
    pull: Array
    unexplained: float


def fold(EI: float, elements: int) -> tuple[Equations, Array]:
    """A rope that hangs in its plane as a U of its natural width, one end pinned, the other let go."""
    width = 2.54307 * (EI / (Rope.mass_per_length * GRAVITY)) ** (1 / 3)
    s = np.linspace(0.0, CHAIN, elements + 1)
    ends = np.array([[-0.5 * width, 0.0, 0.0], [0.5 * width, 0.0, 0.0]])
    q = hanging_guess(s, *ends)
    # Qa a hundredth of a wire rope's: axial waves pass the rope in 60 ms, and it stretches by 0.2 %
    rope = Rope(length=CHAIN, EI=EI, Qa=1e6, Qb=0.0, Qc=0.0)

    def hold(values: Array, nodes: list[int]) -> Equations:
        mask = held(values, OUT_OF_PLANE, (nodes, POSITION))
        return rod(rope, GRAVITY, values, mask)

    hanging = find_equilibrium(hold(q, [0, -1]), q).q
    return hold(hanging, [0]), hanging


def potential(balance: dict[str, float]) -> float:
    """Strain and potential energy, J."""
    return sum(balance[name] for name in ("axial", "coupling", "torsion", "bending", "gravity"))


def fall(EI: float, elements: int, largest: float, tolerance: float) -> Fall:
    """The tip's fall by generalized-alpha; a step that fails or errs by more than ``tolerance`` (m) is halved."""
    equations, q = fold(EI, elements)
    motion = restart(equations, 0.0, q, np.zeros_like(q))
    assert isinstance(motion, Motion)
    start = potential(equations.balance(q, motion.v))
    h = largest
    dissipated = 0.0
    unexplained = 0.0
    rows = [(0.0, 0.0, float(motion.reaction[0, 1]))]
    while h > 1e-7 and motion.t < 2 * math.sqrt(2 * CHAIN / GRAVITY):
        new = step(equations, motion, h, RHO_INF, NEWTON).motion
        error = math.inf
        if new is not None:
            error = largest_error(equations, motion, new, RHO_INF)
        if new is None or error > tolerance:
            h *= 0.5
            continue
        middle = equations.balance(0.5 * (motion.q + new.q), (new.q - motion.q) / h)
        dissipated += h * middle["damping_power"]
        balance = equations.balance(new.q, new.v)
        unexplained = potential(balance) + balance["kinetic"] + dissipated - start
        motion = new
        rows.append((motion.t, -float(motion.q[-1, 1]), float(motion.reaction[0, 1])))
        if rows[-1][1] < rows[-2][1] and rows[-1][1] > 0.5 * CHAIN:
            break
        if error < 0.1 * tolerance:
            h = min(2 * h, largest)
    t, depth, pull = np.array(rows).T
    return Fall(t, depth, pull, unexplained / (Rope.mass_per_length * GRAVITY * CHAIN**2))


def exact_fall() -> tuple[Array, Array]:
    """Times over sqrt(2L/g) and depths over L of a chain that keeps its energy: v^2 = g x (2L - x) / (L - x)."""

    # x = sin^2(u) takes the root at both ends away
    def rate(u: float) -> float:
        return math.sqrt(2.0) * math.cos(u) ** 2 / math.sqrt(2.0 - math.sin(u) ** 2)

    u = np.linspace(0.0, 0.5 * math.pi, 101)
    pieces = [quad(rate, a, b)[0] for a, b in itertools.pairwise(u)]
    return np.concatenate(([0.0], np.cumsum(pieces))), np.sin(u) ** 2
