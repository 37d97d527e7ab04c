"""Time integration that breaks: varying steps, undamped high frequencies, retries that remember."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from evidence.claims import above, below
from rope_model.numerics.generalized_alpha import Coefficients, Motion, restart, step
from rope_model.parameters import Layout, Mesh, Rope, Scene, Solver
from rope_model.simulation.rope_system import ANGLE, POSITION, RopeSystem

from .entry import Entry, Finding
from .trips import hang

PORTABLE = Solver(kernels="portable")

# order

RHO = 0.6
END = 0.8  # s
#: steps, repeated: the ratios stay the same when the steps are refined
VARYING = (0.6, 1.2, 0.9, 1.8, 0.5, 1.0)
STEPS = (320, 640)
#: continues a motion by a step of the given length
Stepper = Callable[[RopeSystem, Motion, float], Motion]


@cache
def pushed_rope() -> tuple[RopeSystem, Motion]:
    """Soft enough for the steps to resolve its waves (order is a limit), hanging, and given a speed."""
    rope = Rope(length=6.0, mass_per_length=2.0, Qa=400.0, Qb=25.0, Qc=25.0, Qd=20.0, EI=20.0, rhoJ=0.2, beta_K=2e-3)
    mesh = Mesh(kind="eem", elements=8)
    simulator = hang(Scene(rope=rope, layout=Layout(spacing=1.6), mesh=mesh, solver=PORTABLE))
    system, q = simulator.system, simulator.state.motion.q
    bump = np.sin(np.pi * np.linspace(0.0, 1.0, len(q))) ** 2
    v = np.zeros_like(q)
    v[:, POSITION] = 0.4 * bump[:, None] * [1.0, 0.5, 0.8]
    v[:, ANGLE] = 0.5 * bump
    return system, restart(system, 0.0, q, v, simulator.state.motion.reaction)[0]


def take_step(system: RopeSystem, motion: Motion, h: float) -> Motion:
    """One step of ours."""
    result = step(system, motion, h, Coefficients(RHO), 1e-12)
    assert result.motion is not None, result.newton
    return result.motion


def step_without_recentring(system: RopeSystem, motion: Motion, h: float) -> Motion:
    """A step whose auxiliary acceleration is taken as it is, wherever it lives."""
    return take_step(system, replace(motion, a_rate=np.zeros_like(motion.a_rate)), h)


def integrate(stepper: Stepper, steps: int, pattern: tuple[float, ...]) -> Motion:
    """The pushed rope at END."""
    system, motion = pushed_rope()
    h = np.resize(np.array(pattern), steps)
    for t in END * np.cumsum(h) / h.sum():
        motion = stepper(system, motion, float(t) - motion.t)
    return motion


@cache
def exact() -> Motion:
    return integrate(take_step, 2560, (1.0,))


def order(stepper: Stepper, pattern: tuple[float, ...]) -> float:
    """Return the observed order of the nodes' places between the two finest of STEPS."""
    errors = [float(np.linalg.norm(integrate(stepper, steps, pattern).q - exact().q)) for steps in STEPS]
    return math.log2(errors[-2] / errors[-1])


def compare_orders(counterexample: Stepper, pattern: tuple[float, ...], name: str) -> Finding:
    """Compare the observed orders of ``counterexample`` and of ours."""
    # an observed order is within some 0.1 of the method's at these steps, so 1.4 is neither 1 nor 2 by chance
    theirs = below(f"observed order, {name}", order(counterexample, pattern), 1.4)
    return Finding((theirs,), (above("observed order, ours", order(take_step, pattern), 1.9),))


def varying_steps() -> Finding:
    return compare_orders(step_without_recentring, VARYING, "without re-centring")


ENTRIES = (Entry("varying-steps", "Varying steps", varying_steps, slow=True),)
