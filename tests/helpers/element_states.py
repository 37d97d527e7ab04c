"""An element with random numbers for its state, and what its functions give there."""

from dataclasses import dataclass

import numpy as np
import pytest
from shared import Array, rotation

from rope_model.physics.element import BALANCE, PARAMETERS, element_functions

ELEMENT = element_functions()
STRAIN = ("axial", "coupling", "torsion", "bending")
seeds = pytest.mark.parametrize("seed", range(6))
MATERIAL = {
    "rho": 1.3,
    "g": 9.8,
    "Qa": 5.0,
    "Qs": 0.8,
    "Qk": 0.3,
    "Qd": 2.0,
    "EI": 1.5,
    "rhoJ": 0.4,
}
MATERIAL |= {"beta_K": 0.3, "root_a": 1.3, "root_b": 0.7, "Qe": 0.6, "rhoJ_x": 0.2}
#: a central difference with this step errs by its square, and by rounding over it: both below 1e-9
STEP = 1e-5


@dataclass(frozen=True)
class State:
    """An element somewhere, in some motion; the frame is counted from ``reference`` (14,)."""

    q: Array
    v: Array
    a: Array
    l: float
    reference: Array

    @property
    def F(self) -> Array:
        """What the frame is counted from, as the element takes it."""
        return np.asarray(ELEMENT.reference(self.reference, self.l)).ravel()

    def P(self, **material: float) -> Array:
        return np.array([material.get(name, 0.0) for name in PARAMETERS])


def some_state(seed: int) -> State:
    """A bent, twisted, stretched element turned anywhere; strains are of order 0.1 to 1."""
    rng = np.random.default_rng(seed)
    l = rng.uniform(0.5, 2.0)
    turn = rotation(rng.normal(size=3))
    slopes = (np.array([1.2, 0.0, 0.0]) + 0.25 * rng.normal(size=(2, 3))) @ turn.T
    left = rng.normal(size=3)
    right = left + l * (slopes.mean(axis=0) + 0.1 * rng.normal(size=3))
    q = np.concatenate((left, slopes[0], rng.normal(size=1), right, slopes[1], rng.normal(size=1)))
    # another shape, with tangents that are not opposite
    reference = q + 0.3 * rng.normal(size=14)
    return State(q, rng.normal(size=14), rng.normal(size=14), l, reference)


def residual(q: Array, v: Array, a: Array, l: float, F: Array, P: Array) -> Array:
    return np.asarray(ELEMENT.residual(q, v, a, l, F, P)).ravel()


def balance(q: Array, v: Array, l: float, F: Array, P: Array) -> dict[str, float]:
    return dict(
        zip(BALANCE, np.asarray(ELEMENT.balance(q, v, l, F, P)).ravel().tolist(), strict=True)
    )


def energy(q: Array, v: Array, l: float, F: Array, P: Array, names: tuple[str, ...]) -> float:
    parts = balance(q, v, l, F, P)
    return sum(parts[name] for name in names)


def turned(q: Array, turn: Array) -> Array:
    """All vectors of an element's degrees of freedom turned, theta kept."""
    y = q.copy()
    for k in (0, 3, 7, 10):
        y[k : k + 3] = turn @ q[k : k + 3]
    return y
