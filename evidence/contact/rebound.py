"""A straight rope that strikes a floor flat, all of it at once: exact for any spring, by Hunt and Crossley's integral.

Without weight the rope's depth p obeys rho p_tt = -s(p) (1 + lambda p_t), so that over the whole contact

    p_t / lambda - log(1 + lambda p_t) / lambda^2

is the same as it comes and as it goes: the rebound depends on the speed alone, not on the spring.
"""

import math
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from evidence.statics import OUT_OF_PLANE, StaticBoundary
from rope_model.numerics.generalized_alpha import restart, step
from rope_model.parameters import Rope, Scene
from rope_model.physics.element import parameters
from rope_model.rules.generalized_alpha import Coefficients
from rope_model.shaft_parameters import Contact, Shaft, Sump
from rope_model.simulation.contact.obstacles import find_obstacles
from rope_model.simulation.rope_kernels import RopeKernels
from rope_model.simulation.rope_system import RopeSystem

#: m of rope, in so many elements, and the gap below it
LENGTH, ELEMENTS, GAP = 2.0, 2, 0.01


class Rebound(NamedTuple):
    """Speeds (m/s) and largest depth (m) of an impact, and its energy unexplained over the kinetic energy before."""

    speed: float
    depth: float
    unexplained: float


def rebound(speed: float, damping: float, stiffness: float, h: float) -> Rebound:
    """An impact at ``speed`` (m/s), with steps of ``h`` (s), without numerical dissipation."""
    rope = Rope(length=LENGTH, Qb=0.0, Qc=0.0, beta_K=0.0)
    contact = Contact(stiffness=stiffness, damping=damping, friction=0.0)
    bodies = find_obstacles(
        Scene(rope=rope, shaft=Shaft(sump=Sump(level=-GAP - 0.5 * rope.diameter), contact=contact))
    )
    assert bodies
    q = np.zeros((ELEMENTS + 1, 7))
    q[:, 0], q[:, 3] = np.linspace(0.0, LENGTH, ELEMENTS + 1), 1.0
    kernels = partial(RopeKernels, ELEMENTS, "portable", fidelity="planar")
    parts = np.diff(q[:, 0]), np.array(parameters(rope, 0.0)), StaticBoundary.at(q, OUT_OF_PLANE), q
    system = RopeSystem(
        kernels(), *parts, obstacles=bodies, contact_kernels=partial(kernels, features=bodies.kinds)
    )
    v = np.zeros_like(q)
    v[:, 1] = -speed
    motion, start = restart(system, 0.0, q, v, np.zeros_like(q))
    before, dissipated, depth, method = start.balance["kinetic"], 0.0, 0.0, Coefficients(1.0)
    while motion.v[0, 1] <= 0 or motion.q[0, 1] < -GAP:
        result = step(system, motion, h, method, 1e-12)
        assert result.motion is not None, result.newton
        dissipated += (
            h
            * system.losses(
                0.5 * (motion.q + result.motion.q), (result.motion.q - motion.q) / h
            ).contact
        )
        motion = result.motion
        depth = max(depth, -GAP - float(motion.q[0, 1]))
    after = system.evaluate(motion.q, motion.v, motion.a, motion.reaction).balance
    left = after["kinetic"] + after["contact"] + dissipated - before
    return Rebound(float(motion.v[:, 1].mean()), depth, left / before)


def exact_speed(speed: float, damping: float) -> float:
    """Speed of the rebound, m/s."""

    def integral(p_t: float) -> float:
        return p_t / damping - math.log1p(damping * p_t) / damping**2

    most = min(speed, (1.0 - 1e-12) / damping)
    return float(brentq(lambda x: integral(-x) - integral(speed), 0.0, most, xtol=1e-14))
