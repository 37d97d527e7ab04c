"""Rational Krylov bases for small models of several heights, with the same meaning at all of them.

A basis W has the hoist's own motions, which the rest follows slowly, and the responses
(s^2 M + s D + K)^-1 M W at a few complex s. Each height has the same motions, made orthonormal by
W (W^T M W)^(-1/2), the smallest change, so that matrices are smooth between heights.

Sources: A. Ruhe, Lin. Alg. Appl. 58, 1984; H. Panzer et al., Parametric model order reduction by
matrix interpolation, at-Automatisierungstechnik 58, 2010.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from hoist_demo.design.linear_model import LinearModel
from rope_model.arrays import Array

_SHIFT = 0.3  #: Re s / 2 pi of the basis [Hz].
_FIRST_SHIFT = 0.5  #: Im s of the first shift, over the band.
_SHIFT_STEP = 0.447  #: Im s from one shift to the next, over the band.
_SHIFT_WRAP = 1.2  #: Im s at which the shifts begin again, over the band.
#: Least kinetic energy of a motion that is new to a basis, over all that are new.
_RANK_TOLERANCE = 1e-3
#: Least kinetic energy of the new motions, over that of what they come from.
_RELATIVE_RANK_TOLERANCE = 1e-12


class NoSmallModel(ValueError):
    """Linear model of which no small model has errors within the bounds."""


class UnfitStates(NoSmallModel):
    """Number of states that no small model of a linear model has."""


class StateCount(NamedTuple):
    """Number of states of a small model; a motion takes two, and an odd one may be left over."""

    asked: int
    others: int  # of coordinates that lag, one each, and of those that an input moves, two each

    @property
    def motions(self) -> int:
        """Number of motions that vibrate."""
        return (self.asked - self.others) // 2

    def with_motions(self, motions: int) -> int:
        """Return the largest number of states that a model of so many motions may be asked for."""
        return 2 * motions + self.others + 1

    def require_motions(self, minimum: int, maximum: int) -> None:
        """Raise UnfitStates unless the motions are so many."""
        if not minimum <= self.motions <= maximum:
            low = 2 * minimum + self.others
            high = self.with_motions(maximum)
            raise UnfitStates(
                f"states = {self.asked} must be within {low} and {high}: take as many"
            )


def krylov_bases(models: Sequence[LinearModel], band: float, states: StateCount) -> list[Array]:
    """Return a basis (free, motions) of each height, with the same meaning at all heights.

    It has the hoist's motions, and responses to the inputs and to these.
    """
    count = states.motions
    n = models[0].free
    hoist_coordinates = [
        k for k, name in enumerate(models[0].names[:3]) if not name.startswith("rope.")
    ]
    minimum = max(len(hoist_coordinates), 1)
    states.require_motions(minimum, n - 3 + minimum)
    masses = [0.5 * (m.mass + m.mass.T)[:n, :n] for m in models]
    bases = [
        _orthonormal(_quasi_static_motions(m, hoist_coordinates), M)
        for m, M in zip(models, masses, strict=True)
    ]
    pushes = [
        np.hstack((M @ W, m.stiffness[:n, m.driven].toarray()))
        for m, M, W in zip(models, masses, bases, strict=True)
    ]
    for k in range(count):
        missing = count - bases[0].shape[1]
        if not missing:
            break
        s = 2 * np.pi * complex(_SHIFT, band * ((_FIRST_SHIFT + k * _SHIFT_STEP) % _SHIFT_WRAP))
        directions = [
            _krylov_directions(m, M, W, push, s)
            for m, M, W, push in zip(models, masses, bases, pushes, strict=True)
        ]
        energies = [x.T @ (M @ x) for x, M in zip(directions, masses, strict=True)]
        T = _common_directions(energies, missing)
        if not T.size:
            raise UnfitStates(
                f"states = {states.asked} must be at most {states.with_motions(bases[0].shape[1])}, "
                "for the inputs move no more: take fewer"
            )
        bases = [
            np.hstack((W, _orthonormal(x @ T, M)))
            for W, x, M in zip(bases, directions, masses, strict=True)
        ]
    return bases


def _quasi_static_motions(model: LinearModel, hoist_coordinates: Sequence[int]) -> Array:
    """Slow motions (free, coordinates) of the hoist's ``hoist_coordinates``, which the rest follows."""
    n = model.free
    rest = np.setdiff1d(np.arange(n), hoist_coordinates)
    K = (model.stiffness[:n, :n] + (2 * np.pi * _SHIFT) ** 2 * model.mass[:n, :n]).tocsc()
    W = np.eye(n)[:, hoist_coordinates]
    W[rest] = -splu(K[rest][:, rest].tocsc()).solve(K[rest][:, hoist_coordinates].toarray())
    return W


def _krylov_directions(
    model: LinearModel, M: sp.csc_matrix, W: Array, push: Array, s: complex
) -> Array:
    """Return motions at ``s`` under the ``push``, real and imaginary parts, less their parts in the basis ``W``."""
    n = model.free
    z = splu((s * s * model.mass + s * model.damping + model.stiffness)[:n, :n].tocsc()).solve(
        push.astype(complex)
    )
    x = np.hstack((z.real, z.imag))
    x = x / np.sqrt(np.maximum(np.einsum("ij,ij->j", x, M @ x), 1e-300))
    for _ in range(2):  # once is not enough for rounding
        x = x - W @ (W.T @ (M @ x))
    return np.asarray(x)


def _common_directions(energies: Sequence[Array], maximum: int) -> Array:
    """Return combinations (directions, up to ``maximum``) of directions with these kinetic energies.

    They are new at every height.
    """
    if min(np.trace(energy) for energy in energies) < _RELATIVE_RANK_TOLERANCE:
        return np.empty((len(energies[0]), 0))
    shares = [energy / np.trace(energy) for energy in energies]
    T = np.linalg.eigh(sum(shares))[1][:, ::-1][:, :maximum]
    while (
        T.shape[1] > 1
        and min(np.linalg.eigvalsh(T.T @ share @ T)[0] for share in shares) < _RANK_TOLERANCE
    ):
        T = T[:, :-1]
    return T


def _orthonormal(W: Array, M: sp.csc_matrix) -> Array:
    """Return W (W^T M W)^(-1/2), the orthonormal basis nearest to W."""
    squares, axes = np.linalg.eigh(W.T @ (M @ W))
    return np.asarray(W @ (axes / np.sqrt(squares)) @ axes.T)
