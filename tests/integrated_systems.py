"""Systems for the tests of time integration."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from conftest import Chain
from numpy.typing import NDArray

from rope_model.numerics.generalized_alpha import Motion, restart
from rope_model.numerics.newton import NewtonReport, NewtonStatus, initial_progress, judge, report
from rope_model.parameters import Rope
from rope_model.simulation.rope_kernels import RopeKernels
from rope_model.simulation.rope_system import POSITION, RopeSystem, parameter_vector
from rope_model.simulation.stepping.statics import find_equilibrium, hanging_guess

Array = NDArray[np.float64]


def verdict_on(norms: Iterator[float], tolerance: float, most: int) -> NewtonReport:
    progress, verdict = initial_progress(), judge()
    for norm in itertools.islice(norms, most):
        progress = verdict(progress, norm, tolerance, True)
        if progress[0] != NewtonStatus.TOO_MANY.code:
            break
    return report(np.asarray(progress).ravel().tolist())


@dataclass(frozen=True)
class ShakenEnds(Chain):
    """Both ends held, the right one moved smoothly from rest."""

    def prescribed_motion(self, t: float, nodes: int) -> Array:
        q, v, a = motion = np.zeros((3, *self.values.shape))
        q += self.values
        w = 4.0
        way = 0.25 * np.array([1.0, 0.6, 0.8])
        q[-1, POSITION] += way * (w * t - np.sin(w * t)) / w
        v[-1, POSITION], a[-1, POSITION] = way * (1 - np.cos(w * t)), way * w * np.sin(w * t)
        return motion


@cache
def soft_rope() -> tuple[RopeSystem, Motion]:
    """Soft enough for the steps of the tests to resolve its waves: order is a limit."""
    rope = Rope(length=6.0, mass_per_length=2.0, Qa=400.0, Qb=30.0, Qc=20.0, Qd=20.0, EI=20.0, rhoJ=0.2, beta_K=2e-3)
    n = 8
    s = np.linspace(0.0, rope.length, n + 1)
    q = hanging_guess(s, np.array([-0.8, 0.0, 0.0]), np.array([0.8, 0.0, 0.0]))
    ends = ShakenEnds(np.zeros((n + 1, 7), dtype=bool), q, np.zeros((n + 1, 7)))
    ends.held[[0, -1]] = True
    ends.held[[0, -1], 4] = False
    system = RopeSystem(RopeKernels(n, "auto"), np.diff(s), parameter_vector(rope, 9.81), ends, q)
    at_rest = find_equilibrium(system, q)
    return system, restart(system, 0.0, at_rest.q, 0 * q, at_rest.reaction)[0]
