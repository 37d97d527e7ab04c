"""A linear model in its sparse second-order form: responses, modes, and a choice of its inputs and outputs.

M x'' + D x' + K x = B u ,     y = C x + C_v x' + C_a x'' + D_u u .
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse.linalg import splu

from hoist_demo.design.equal_ropes import equal_ropes, merged_coordinates, modes_of_fewer
from hoist_demo.design.sparse_modes import BandProgress, sparse_modes
from rope_model.arrays import Array

#: What moves in a mode: the hoist, or the rope along its legs, in the loop's plane, out of it, or about itself.
PARTS = ("hoist", "vertical", "in plane", "out of plane", "twist")
#: Coordinates up to which all modes at once take less time than those of a band.
MAX_DENSE_SIZE = 600
_SLOWEST = 2 * np.pi * 1e-3  #: rad/s, below which a motion is none of vibration.
_DIRECTION = (1, 0, 2, 1, 0, 2, 3)  #: Of a node's coordinates, by PARTS behind the first.


@dataclass(frozen=True)
class UndampedModes:
    """Undamped modes: frequencies [Hz], damping ratios of the diagonal of D, shapes (coordinates, modes) of unit mass.

    ``shares`` (PARTS, modes) are the parts of the kinetic energy.
    """

    frequencies: Array
    damping: Array
    shapes: Array
    shares: Array


@dataclass
class _Finder:
    """Finds modes up to a square of the angular frequency, and tells which part of all problems is done."""

    largest: float  # 1/s^2
    progress: BandProgress
    problems: int
    done: int = 0

    def modes(self, K: sp.csc_matrix, M: sp.csc_matrix) -> tuple[Array, Array]:
        """Return squares of angular frequencies and shapes of the next problem."""

        def advance(part: float) -> None:
            self.progress((self.done + part) / self.problems)

        if K.shape[0] <= MAX_DENSE_SIZE:
            below = (-np.inf, self.largest)
            found: tuple[Array, Array] = eigh(K.toarray(), M.toarray(), subset_by_value=below)
        else:
            found = sparse_modes(K, M, self.largest, advance)
        self.done += 1
        return found


@dataclass(frozen=True)
class LinearModel:
    """A model in its sparse second-order form, SI units.

    Coordinates come in the order of ``names``: free ones, those ``held`` whose accelerations are
    inputs, those that lag. A rope's are "rope.NODE.k", k from 0 to 6 for r, r' and theta; of ropes
    that differ "rope.NAME.NODE.k", and their outputs begin with their names. ``rest_inputs`` and
    ``rest_outputs`` are the values from which u and y count; outputs that have none rest at 0.
    """

    at: float  # height of the left conveyance over the travel
    names: tuple[str, ...]
    held: int  # number of held coordinates
    lags: int  # number of coordinates that lag
    mass: sp.csc_matrix
    damping: sp.csc_matrix
    stiffness: sp.csc_matrix
    inputs: tuple[str, ...]
    B: Array
    outputs: tuple[str, ...]
    maps: tuple[sp.csr_matrix, sp.csr_matrix, sp.csr_matrix]  # C, C_v and C_a
    through: Array  # D_u
    rest_inputs: Array
    rest_outputs: Array

    @property
    def free(self) -> int:
        """Number of coordinates that vibrate."""
        return len(self.names) - self.held - self.lags

    @property
    def driven(self) -> list[int]:
        """Held coordinates that an input moves."""
        return [k for k in range(self.free, self.free + self.held) if self.B[k].any()]

    def response(self, s: Iterable[complex]) -> NDArray[np.complex128]:
        """Transfer functions (len(s), outputs, inputs) at complex frequencies [rad/s]."""
        moved = self._moved()
        M, D, K = (moved.T @ A @ moved for A in (self.mass, self.damping, self.stiffness))
        C, C_v, C_a = (A @ moved for A in self.maps)
        B = (moved.T @ self.B).astype(complex)
        responses = []
        for z in s:
            x = splu((z * z * M + z * D + K).tocsc()).solve(B)
            responses.append((C + z * C_v + z * z * C_a) @ x + self.through)
        return np.array(responses)

    def _moved(self) -> sp.csc_matrix:
        """Return all coordinates by those that the inputs move: held ones may rest, equal ropes move alike."""
        moves = np.ones(len(self.names), dtype=bool)
        held = slice(self.free, self.free + self.held)
        moves[held] = np.any(self.B[held] != 0.0, axis=1)
        names = [name for name, moved in zip(self.names, moves, strict=True) if moved]
        parts = [A[moves][:, moves] for A in (self.mass, self.damping, self.stiffness)]
        pushed = np.any(self.B[moves] != 0.0, axis=1)
        groups = [
            group
            for group in equal_ropes(names, [*parts, *(A.T.tocsc() for A in parts)])
            if not any(pushed[rope.start : rope.stop].any() for rope in group)
        ]
        chosen = sp.eye(len(self.names), format="csc")[:, moves]
        return chosen @ merged_coordinates(len(names), groups)

    def modes(self, highest: float, progress: BandProgress = lambda part: None) -> UndampedModes:
        """Return the modes up to a frequency [Hz], held coordinates at rest and without what lags.

        ``progress`` hears which part of the band is done.
        """
        n = self.free
        K, M = (0.5 * (A + A.T)[:n, :n].tocsc() for A in (self.stiffness, self.mass))
        largest = (2 * np.pi * highest) ** 2
        groups = equal_ropes(self.names[:n], (K, M))
        finder = _Finder(largest, progress, 1 + len(groups))
        squares, shapes = modes_of_fewer(K, M, groups, finder.modes)
        omega = np.sqrt(np.maximum(squares, 0.0))
        damping = np.einsum("ij,ij->j", shapes, self.damping[:n, :n] @ shapes) / (
            2 * np.maximum(omega, _SLOWEST)
        )
        # kinetic energy by the coordinates' first part: the hoist, or a direction of the rope
        kind = [
            "hoist" if not x.startswith("rope.") else PARTS[1 + _DIRECTION[int(x[-1])]]
            for x in self.names[:n]
        ]
        energy = shapes * (M @ shapes)
        shares = np.array([energy[[part == x for x in kind]].sum(axis=0) for part in PARTS])
        return UndampedModes(omega / (2 * np.pi), damping, shapes, shares)

    def selected(self, inputs: Iterable[str], outputs: Iterable[str]) -> LinearModel:
        """Return the model with these inputs and outputs only; ValueError for others than it has."""
        columns = _indices(inputs, self.inputs, "inputs")
        rows = _indices(outputs, self.outputs, "outputs")
        return replace(
            self,
            inputs=tuple(self.inputs[k] for k in columns),
            B=self.B[:, columns],
            outputs=tuple(self.outputs[k] for k in rows),
            maps=tuple(A[rows] for A in self.maps),
            through=self.through[np.ix_(rows, columns)],
            rest_inputs=self.rest_inputs[columns],
            rest_outputs=self.rest_outputs[rows],
        )


def _indices(names: Iterable[str], available: tuple[str, ...], what: str) -> list[int]:
    if isinstance(names, str):
        raise ValueError(f"{what} = {names!r} must be a list of names: give [{names!r}]")
    names = tuple(names)
    if missing := [name for name in names if name not in available]:
        raise ValueError(
            f"{what} {', '.join(missing)} must be among {', '.join(available)}: choose from them"
        )
    return [available.index(name) for name in names]
