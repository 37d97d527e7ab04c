"""Violent motion: a leg that goes slack, its snatch, and a dropped end."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.integrate import quad, solve_ivp
from scipy.sparse.linalg import splu

from rope_model.numerics.generalized_alpha import Coefficients, restart, step
from rope_model.parameters import Layout, Mesh, Rope, Scene, Solver
from rope_model.simulation.ends import EndMotion
from rope_model.simulation.modal import assembled_matrix
from rope_model.simulation.rope_system import POSITION, RopeKernels, RopeSystem, parameter_vector
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.statics import find_equilibrium, hanging_guess

from . import bulging, hockling, turn_over
from .chain import POLE_X, Held, potential
from .entry import Array, Curve, Entry, Figure, Finding, Measured

GRAVITY = Layout().gravity

# an end that is lowered faster than the rope can fall, and stopped

LENGTH, DROP, FALL, END, H = 30.0, 1.5, 0.35, 1.0, 0.0025  # m, m, s, s, s


def dropped(t: float) -> EndMotion:
    """The left conveyance goes down by DROP within FALL, with up to 7 g, and stands."""
    s = min(t / FALL, 1.0)
    return EndMotion(
        y=-DROP * (10 * s**3 - 15 * s**4 + 6 * s**5),
        vy=-DROP / FALL * (30 * s**2 - 60 * s**3 + 30 * s**4),
        ay=-DROP / FALL**2 * (60 * s - 180 * s**2 + 120 * s**3),
    )


@dataclass(frozen=True)
class Drop:
    """Times (s), pull of the rope on the left conveyance (N), and what the energy books do not explain (J)."""

    t: Array
    pull: Array
    unexplained: Array
    kinetic: Array  # J
    stopped: str  # '' when it ran to the end


def drop(solver: Solver, end: float = END, beta_K: float = Rope.beta_K) -> Drop:
    """The drop of the left conveyance by the simulator."""
    rope = RopeSimulator(
        Scene(rope=Rope(length=LENGTH, beta_K=beta_K), mesh=Mesh(kind="eem", elements=60), solver=solver)
    )
    status = rope.initialize(0.0, EndMotion(), EndMotion())
    rows = []
    for k in range(1, round(end / H) + 1):
        status = rope.advance_to(k * H, dropped(k * H), EndMotion())
        if not status.valid:
            break
        state = rope.state
        rows.append((k * H, state.motion.reaction[0, 1], state.ledger.residual, state.ledger.kinetic))
    return Drop(*np.array(rows).T, status.message)


def linear_drop(end: float) -> tuple[Array, Array]:
    """Times and pulls (N) of the rope linearised about its hanging shape, by Newmark's average acceleration."""
    rope = RopeSimulator(Scene(rope=Rope(length=LENGTH), mesh=Mesh(kind="eem", elements=60)))
    rope.initialize(0.0, EndMotion(), EndMotion())
    system, q = rope.system, rope.state.motion.q
    K, C, M = (assembled_matrix(system, q, c) for c in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    free = np.flatnonzero(system.free.ravel())
    held = 1  # height of the left end
    h = H
    effective = splu(sp.csc_matrix((K + 2 / h * C + 4 / h**2 * M)[free][:, free]))
    x, v, a = np.zeros((3, q.size))
    weight = float(rope.state.motion.reaction[0, 1])
    times, pulls = [], []
    for k in range(1, round(end / H) + 1):
        at = dropped(k * h)
        new_v, new_a = -2 / h * x - v, -4 / h**2 * x - 4 / h * v - a  # but for 2 x/h and 4 x/h^2
        new_x = np.zeros_like(x)
        new_x[held], new_v[held], new_a[held] = at.y, at.vy, at.ay
        known = K @ new_x + C @ new_v + M @ new_a
        new_x[free] = effective.solve(-known[free])
        new_v[free] += 2 / h * new_x[free]
        new_a[free] += 4 / h**2 * new_x[free]
        x, v, a = new_x, new_v, new_a
        times.append(k * h)
        pulls.append(weight + float((K @ x + C @ v + M @ a)[held]))
    return np.array(times), np.array(pulls)


SLACK = (0.04, 0.2)  # s, while the end falls faster than the rope


def measure_slack() -> Finding:
    ours, (t, pull) = drop(Solver(), SLACK[1]), linear_drop(SLACK[1])
    weight = 0.5 * Rope.mass_per_length * GRAVITY * LENGTH
    during = t > SLACK[0]
    push, linear = (-float(np.mean(x[during])) for x in (ours.pull, pull))
    # a leg fixed at both ends buckles under 4 pi^2 EI / l^2
    buckling = 4 * math.pi**2 * Rope.EI / (0.5 * LENGTH) ** 2
    return Finding(
        twin=(
            Measured("linear: mean push on the conveyance over what buckles the leg", linear / buckling, "1", ">", 100.0),
        ),
        ours=(
            Measured("stopped before the end", float(bool(ours.stopped)), "1", "<", 0.5),
            # a slack rope pulls or pushes with what hangs next to the conveyance, not with the leg's weight
            Measured("mean force on the conveyance over the leg's weight", abs(push) / weight, "1", "<", 0.5),
            Measured(
                "energy the books do not explain, part of the largest kinetic energy",
                float(np.abs(ours.unexplained).max() / ours.kinetic.max()),
                "1",
                "<",
                0.02,
            ),
        ),
        figure=Figure(
            "A conveyance falls away under its rope at up to 7 g",
            "time, s",
            "pull of the rope on the conveyance, kN",
            (
                Curve("rope linearised about its hanging shape", t, 1e-3 * pull),
                Curve("ours", ours.t, 1e-3 * ours.pull),
            ),
        ),
    )


def measure_snatch() -> Finding:
    fixed = Solver(tolerance=1e9, rho_inf=1.0, step_max=0.005, step_min=0.005)
    undamped = drop(fixed, beta_K=0.0)
    twin = drop(fixed)
    ours, fine = drop(Solver()), drop(Solver(tolerance=1e-4))
    largest = ours.kinetic.max()
    return Finding(
        twin=(
            Measured("rho_inf = 1, fixed step: time reached", float(twin.t[-1]), "s", "<", 0.9 * END),
            Measured("the same without material damping: time reached", float(undamped.t[-1]), "s", "<", 0.9 * END),
        ),
        ours=(
            Measured("time not reached", END - float(ours.t[-1]), "s", "<", 1e-9),
            # the default tolerance is a local error of 1 mm per step
            Measured(
                f"snatch of {1e-3 * fine.pull.max():.3g} kN against ten times the tolerance",
                abs(float(ours.pull.max() / fine.pull.max()) - 1),
                "1",
                "<",
                0.05,
            ),
            Measured(
                "energy the books do not explain, part of the largest kinetic energy",
                float(np.abs(ours.unexplained).max() / largest),
                "1",
                "<",
                0.05,
            ),
            Measured(
                "the same with a tenth of the tolerance",
                float(np.abs(fine.unexplained).max() / largest),
                "1",
                "<",
                0.02,
            ),
        ),
        figure=Figure(
            "Slack at 0.02 s, taut again at 0.27 s",
            "time, s",
            "pull of the rope on the conveyance, kN",
            (
                Curve("ours", ours.t, 1e-3 * ours.pull),
                Curve("rho_inf = 1, fixed step, until it stops", twin.t, 1e-3 * twin.pull, "--"),
                Curve("the same without material damping", undamped.t, 1e-3 * undamped.pull, ":"),
            ),
        ),
        message=twin.stopped,
    )


# a dropped end

CHAIN = 20.0  # m


@dataclass(frozen=True)
class Fall:
    """Times (s) and depths (m) of the tip until it is lowest, and the energy unexplained over rho g L^2."""

    t: Array
    depth: Array
    unexplained: float


def folded(EI: float, elements: int) -> tuple[RopeSystem, Array]:
    """A rope that hangs in its plane as a U of its natural width, one end pinned, the other let go."""
    width = 2.54307 * (EI / (Rope.mass_per_length * GRAVITY)) ** (1 / 3)
    s = np.linspace(0.0, CHAIN, elements + 1)
    ends = np.array([[-0.5 * width, 0.0, 0.0], [0.5 * width, 0.0, 0.0]])
    q = hanging_guess(s, *ends)
    # Qa a hundredth of a wire rope's: axial waves pass the rope in 60 ms, and it stretches by 0.2 %
    rope = Rope(length=CHAIN, EI=EI, Qa=1e6, Qb=0.0, Qc=0.0)
    kernels, P = RopeKernels(elements), parameter_vector(rope, GRAVITY, POLE_X)

    def held(values: Array, nodes: list[int]) -> RopeSystem:
        boundary = Held.nothing(values)
        boundary.held[:, [2, 5, 6]] = True
        boundary.held[nodes, POSITION] = True
        return RopeSystem(kernels, np.diff(s), P, boundary)

    hanging = find_equilibrium(held(q, [0, -1]), q).q
    return held(hanging.copy(), [0]), hanging


def fall(EI: float, elements: int, largest: float, tolerance: float) -> Fall:
    """The tip's fall by generalized-alpha; a step that fails or errs by more than ``tolerance`` (m) is halved."""
    system, q = folded(EI, elements)
    rest = np.zeros_like(q)
    motion, start = restart(system, 0.0, q, rest, rest)
    method, h, dissipated, unexplained = Coefficients(0.8), largest, 0.0, 0.0
    rows = [(0.0, 0.0)]
    while h > 1e-7 and motion.t < 2 * math.sqrt(2 * CHAIN / GRAVITY):
        result = step(system, motion, h, method, 1e-8)
        if result.motion is None or result.assessment is None or result.error > tolerance:
            h *= 0.5
            continue
        new = result.motion
        middle = system.assess(0.0, 0.5 * (motion.q + new.q), (new.q - motion.q) / h, new.a, new.reaction).balance
        dissipated += h * middle["damping_power"]
        balance = result.assessment.balance
        unexplained = potential(balance) + balance["kinetic"] + dissipated - potential(start.balance)
        motion = new
        rows.append((motion.t, -float(motion.q[-1, 1])))
        if rows[-1][1] < rows[-2][1] and rows[-1][1] > 0.5 * CHAIN:
            break
        if result.error < 0.1 * tolerance:
            h = min(2 * h, largest)
    t, depth = np.array(rows).T
    return Fall(t, depth, unexplained / (Rope.mass_per_length * GRAVITY * CHAIN**2))


def exact_fall() -> tuple[Array, Array]:
    """Times over sqrt(2L/g) and depths over L of a chain that keeps its energy: v^2 = g x (2L - x) / (L - x)."""
    # x = sin^2(u) takes the root at both ends away
    def rate(u: float) -> float:
        return math.sqrt(2.0) * math.cos(u) ** 2 / math.sqrt(2.0 - math.sin(u) ** 2)

    u = np.linspace(0.0, 0.5 * math.pi, 101)
    pieces = [quad(rate, a, b)[0] for a, b in zip(u[:-1], u[1:], strict=True)]
    return np.concatenate(([0.0], np.cumsum(pieces))), np.sin(u) ** 2


def inelastic_fall() -> tuple[Array, Array]:
    """Times over sqrt(2L/g) and depths over L when the fold catches each link without giving its energy on.

    The momentum of the part that falls changes by its weight and by what the caught links take with them.
    """

    def rates(t: float, y: Array) -> list[float]:
        x, p = y  # over L and over rho sqrt(g L) L, time over sqrt(L/g)
        mass = max(0.5 * (1 - x), 1e-12)
        return [p / mass, mass - 0.5 * (p / mass) ** 2]

    def lowest(t: float, y: Array) -> float:
        return float(y[0]) - 0.999

    lowest.terminal = True  # type: ignore[attr-defined]
    solution = solve_ivp(rates, (0.0, 3.0), [0.0, 0.0], rtol=1e-9, atol=1e-12, events=lowest)
    return solution.t / math.sqrt(2.0), solution.y[0]


def measure_fall() -> Finding:
    unit = math.sqrt(2 * CHAIN / GRAVITY)
    exact_t, exact_x = exact_fall()
    falls = {1.0: fall(1.0, 100, 5e-3, 1e-3), 0.1: fall(0.1, 200, 2e-3, 1e-4)}
    ratios = {EI: float(x.t[-1]) / unit for EI, x in falls.items()}
    free_t, free_x = inelastic_fall()
    curves = [Curve(f"ours, EI = {EI:g} N m²", x.t / unit, x.depth / CHAIN) for EI, x in falls.items()]
    return Finding(
        twin=(
            # it falls with g: 1 instead of 0.847
            Measured("inelastic fold: fall time over that of the energy-conserving chain", float(free_t[-1] / exact_t[-1]), "1", ">", 1.1),
        ),
        ours=(
            Measured("exact fall time over sqrt(2L/g), against the printed 0.847213", abs(float(exact_t[-1]) - 0.847213), "1", "<", 1e-6),
            # the fold is a part (EI/rho g)^(1/3)/L = 1.2 % and 0.5 % of the rope long, and carries energy
            *(
                Measured(f"fall time of {ratios[EI]:.4f}, EI = {EI:g} N m^2: error", abs(ratios[EI] / float(exact_t[-1]) - 1), "1", "<", bound)
                for EI, bound in ((1.0, 0.012), (0.1, 0.006))
            ),
            Measured("energy unexplained over rho g L^2, larger of both", max(abs(x.unexplained) for x in falls.values()), "1", "<", 0.01),
        ),
        figure=Figure(
            "The free end of a folded rope falls faster than g",
            "time over sqrt(2L/g)",
            "depth of the tip over L",
            (
                *curves,
                Curve("chain that keeps its energy, exact", exact_t, exact_x, "--"),
                Curve("inelastic fold: falls with g", free_t, free_x, ":"),
            ),
        ),
    )


