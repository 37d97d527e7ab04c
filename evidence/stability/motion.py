"""Violent motion: a leg that goes slack, and its snatch; and, from their own modules, a fall and shapes at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from evidence.claims import Measurement
from rope_model import balance_rope
from rope_model.parameters import Layout, Mesh, Rope, Scene, Solver
from rope_model.simulation.modal import assemble_matrix
from rope_model.simulation.paths import EndMotion
from rope_model.simulation.simulator import RopeSimulator

from . import bulging, falling, hockling, turn_over
from .entry import Array, Curve, Entry, Figure, Finding

GRAVITY = Layout().gravity

# an end that is lowered faster than the rope can fall, and stopped

LENGTH, DROP, FALL, SHOWN, END, H = 30.0, 1.5, 0.35, 0.6, 1.0, 0.005  # m, m, s, s, s, s


def drop_motion(t: float) -> EndMotion:
    """The left conveyance goes down by DROP within FALL, with up to 7 g, and stands."""
    s = min(t / FALL, 1.0)
    return EndMotion(
        y=-DROP * (10 * s**3 - 15 * s**4 + 6 * s**5),
        vy=-DROP / FALL * (30 * s**2 - 60 * s**3 + 30 * s**4),
        ay=-DROP / FALL**2 * (60 * s - 180 * s**2 + 120 * s**3),
    )


@dataclass(frozen=True)
class Drop:
    """Times (s), pull of the rope on the left conveyance (N), and what the energy balance does not explain (J)."""

    t: Array
    pull: Array
    unexplained: Array
    kinetic: Array  # J
    stopped: str  # '' when it ran to the end


def drop(solver: Solver, end: float = END, beta_K: float = Rope.beta_K, elements: int = 60) -> Drop:
    """The drop of the left conveyance."""
    rope = balance_rope(
        Scene(rope=Rope(length=LENGTH, beta_K=beta_K), mesh=Mesh(kind="eem", elements=elements), solver=solver)
    )
    status = rope.initialize(0.0, EndMotion(), EndMotion())
    rows = []
    for k in range(1, round(end / H) + 1):
        status = rope.advance_to(k * H, drop_motion(k * H), EndMotion())
        if not status.valid:
            break
        state = rope.state
        rows.append((k * H, state.motion.reaction[0, 1], state.energy_balance.residual, state.energy_balance.kinetic))
    t, pull, unexplained, kinetic = np.array(rows).T
    return Drop(t, pull, unexplained, kinetic, status.message)


def linear_drop(end: float) -> tuple[Array, Array]:
    """Times and pulls (N) of the rope linearised about its hanging shape, by Newmark's average acceleration."""
    rope = RopeSimulator(Scene(rope=Rope(length=LENGTH), mesh=Mesh(kind="eem", elements=60)))
    rope.initialize(0.0, EndMotion(), EndMotion())
    system, q = rope.system, rope.state.motion.q
    K, C, M = (assemble_matrix(system, q, c) for c in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    free = np.flatnonzero(system.free.ravel())
    held = 1  # height of the left end
    h = H
    effective = splu(sp.csc_matrix((K + 2 / h * C + 4 / h**2 * M)[free][:, free]))
    x, v, a = np.zeros((3, q.size))
    weight = float(rope.state.motion.reaction[0, 1])
    times, pulls = [], []
    for k in range(1, round(end / H) + 1):
        at = drop_motion(k * h)
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


def measure_slack() -> Finding:
    ours, fine, (t, pull) = drop(Solver(), SHOWN), drop(Solver(), SHOWN, elements=120), linear_drop(SHOWN)
    # a leg clamped at both ends buckles under 4 pi^2 EI / l^2
    buckling = 4 * math.pi**2 * Rope.EI / (0.5 * LENGTH) ** 2
    return Finding(
        counterexample=(
            # one wave up and down of the prescribed acceleration against a blow: no bound but "not nearly"
            Measurement(
                "linear: largest pull, part of the largest one", float(pull.max() / fine.pull.max()), "1", "<", 0.5
            ),
        ),
        ours=(
            Measurement(
                "largest push on the conveyance over what buckles the leg",
                -float(ours.pull.min()) / buckling,
                "1",
                ">",
                10.0,
            ),
            Measurement("time not reached", SHOWN - float(ours.t[-1]), "s", "<", 1e-9),
            # buckles of some metres on elements of 0.5 m; the tolerance of the step allows 2 %
            Measurement(
                f"largest pull of {1e-3 * fine.pull.max():.3g} kN, elements of 0.5 m to 0.25 m",
                abs(float(ours.pull.max() / fine.pull.max()) - 1),
                "1",
                "<",
                0.05,
            ),
            # generalized-alpha takes what the steps do not resolve; it must be small against what moves
            Measurement(
                "energy that the balance does not explain, part of the largest kinetic energy",
                float(np.abs(ours.unexplained).max() / ours.kinetic.max()),
                "1",
                "<",
                0.02,
            ),
        ),
        figure=Figure(
            "A conveyance falls away under its rope, and stops",
            "time, s",
            "pull of the rope on the conveyance, kN",
            (
                Curve("rope linearised about its hanging shape", t, 1e-3 * pull),
                Curve("ours", ours.t, 1e-3 * ours.pull),
                Curve("ours, elements half as long", fine.t, 1e-3 * fine.pull, "--"),
            ),
        ),
    )


def measure_snatch() -> Finding:
    fixed = Solver(tolerance=1e6, rho_inf=1.0, step_max=0.005, step_min=0.005)
    undamped = drop(fixed, beta_K=0.0)
    counterexample = drop(fixed)
    ours, fine, uncontrolled = (drop(Solver(tolerance=tolerance)) for tolerance in (1.0, 0.1, 1e6))
    largest = ours.kinetic.max()
    return Finding(
        counterexample=(
            Measurement("rho_inf = 1, fixed step: time reached", float(counterexample.t[-1]), "s", "<", 0.9 * END),
            Measurement("the same without material damping: time reached", float(undamped.t[-1]), "s", "<", 0.9 * END),
        ),
        ours=(
            Measurement("time not reached", END - float(ours.t[-1]), "s", "<", 1e-9),
            Measurement(
                f"snatch of {1e-3 * fine.pull.max():.3g} kN against ten times the tolerance",
                abs(float(ours.pull.max() / fine.pull.max()) - 1),
                "1",
                "<",
                0.05,
            ),
            Measurement(
                "energy that the balance does not explain, part of the largest kinetic energy",
                float(np.abs(ours.unexplained).max() / largest),
                "1",
                "<",
                0.05,
            ),
            Measurement(
                "the same with a tenth of the tolerance",
                float(np.abs(fine.unexplained).max() / largest),
                "1",
                "<",
                0.02,
            ),
            # of second order in the step, and control takes several times as many steps
            Measurement(
                "the energy that the balance does not explain over that of steps of 5 ms",
                float(np.abs(ours.unexplained).max() / np.abs(uncontrolled.unexplained).max()),
                "1",
                "<",
                0.1,
            ),
        ),
        figure=Figure(
            "Slack, and taut again at 0.27 s",
            "time, s",
            "pull of the rope on the conveyance, kN",
            (
                Curve("ours", ours.t, 1e-3 * ours.pull),
                Curve("rho_inf = 1, fixed step, until it stops", counterexample.t, 1e-3 * counterexample.pull, "--"),
                Curve("the same without material damping", undamped.t, 1e-3 * undamped.pull, ":"),
            ),
        ),
        message=counterexample.stopped,
    )


ENTRIES = (
    Entry("slack-rope", "A leg that goes slack and is compressed", measure_slack),
    Entry("snatch-load", "A snatch load without dissipation at high frequencies", measure_snatch),
    *falling.ENTRIES,
    *bulging.ENTRIES,
    *turn_over.ENTRIES,
    *hockling.ENTRIES,
)
