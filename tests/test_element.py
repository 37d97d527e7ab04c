"""Every force against its energy, every tangent against its force, the frames against frames built in numbers."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import pytest
from conftest import Chain, portable_system, rotation, straight
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rope_model.physics import costello
from rope_model.physics.element import BALANCE, PARAMETERS, element_functions
from rope_model.physics.frame import FrameRate, pole_change_angle, smallest_rotation_rate, tait_bryan_rate
from rope_model.simulation.statics import find_equilibrium

Array = NDArray[np.float64]

ELEMENT = element_functions()
STRAIN = ("axial", "coupling", "torsion", "bending")
SEEDS = range(6)
MATERIAL = {
    "rho": 1.3,
    "g": 9.81,
    "Qa": 5.0,
    "Qs": 0.8,
    "Qk": 0.3,
    "Qd": 2.0,
    "EI": 1.5,
    "rhoJ": 0.4,
    "beta_K": 0.3,
}
NOTHING = dict.fromkeys(MATERIAL, 0.0)


@dataclass(frozen=True)
class State:
    """An element somewhere, in some motion."""

    q: Array
    v: Array
    a: Array
    l: float
    pole: Array

    def P(self, **material: float) -> Array:
        assert tuple(material) == PARAMETERS[:9]
        return np.array([*material.values(), *self.pole])


def random_state(seed: int) -> State:
    """A bent, twisted, stretched element turned anywhere; every strain is of order 0.1 to 1."""
    rng = np.random.default_rng(seed)
    l, turn = rng.uniform(0.5, 2.0), rotation(rng.normal(size=3))
    q = np.zeros(14)
    q[0:3], q[7:10] = rng.normal(size=3), 0.0
    q[3:6], q[10:13] = turn @ ([1.2, 0.0, 0.0] + 0.25 * rng.normal(size=(2, 3)))[..., None][:, :, 0].T @ np.eye(2)[:, :1].ravel(), 0.0
    return State(q, q, q, l, q[:3])
