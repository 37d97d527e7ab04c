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

from hoist_demo.design.sparse_modes import Progress, sparse_modes

Array = NDArray[np.float64]
#: What moves in a mode: the hoist, or the rope along its legs, in the loop's plane, out of it, or about itself.
PARTS = ("hoist", "vertical", "in plane", "out of plane", "twist")
MOST_DENSE = 600  #: Coordinates up to which all modes at once take less time than those of a band.
_SLOWEST = 2 * np.pi * 1e-3  #: rad/s, below which a motion is none of vibration.
_DIRECTION = (1, 0, 2, 1, 0, 2, 3)  #: Of a node's coordinates, by PARTS behind the first.


@dataclass(frozen=True)
class Modes:
    """Undamped modes: frequencies [Hz], damping ratios of the diagonal of D, shapes (coordinates, modes) of unit mass.

    `shares` (PARTS, modes) are the parts of the kinetic energy.
    """

    frequencies: Array
    damping: Array
    shapes: Array
    shares: Array


@dataclass(frozen=True)
class LinearModel:
    """A model in its sparse second-order form, SI units.

    Coordinates come in the order of `names`: free ones, those `held` whose accelerations are inputs, those that lag.
    A rope's are "rope.NODE.k", k from 0 to 6 for r, r' and theta; of ropes that differ "rope.NAME.NODE.k", and their
    outputs begin with their names. `rest_inputs` and `rest_outputs` are the values from
    which u and y count; outputs that have none rest at 0.
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

    def response(self, s: Iterable[complex]) -> NDArray[np.complex128]:
        """Transfer functions (len(s), outputs, inputs) at complex frequencies [rad/s]."""
        C, C_v, C_a = self.maps
        responses = []
        for z in s:
            x = splu((z * z * self.mass + z * self.damping + self.stiffness).tocsc()).solve(
                self.B.astype(complex)
            )
            responses.append((C + z * C_v + z * z * C_a) @ x + self.through)
        return np.array(responses)

    def modes(self, highest: float, progress: Progress = lambda part: None) -> Modes:
        """Return the modes up to a frequency [Hz], held coordinates at rest and without what lags.

        `progress` hears which part of the band is done.
        """
        n = self.free
        K, M = (0.5 * (A + A.T)[:n, :n].tocsc() for A in (self.stiffness, self.mass))
        largest = (2 * np.pi * highest) ** 2
        if n <= MOST_DENSE:
            squares, shapes = eigh(K.toarray(), M.toarray(), subset_by_value=(-np.inf, largest))
        else:
            squares, shapes = sparse_modes(K, M, largest, progress)
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
        return Modes(omega / (2 * np.pi), damping, shapes, shares)

    def selected(self, inputs: Iterable[str], outputs: Iterable[str]) -> LinearModel:
        """Return the model with these inputs and outputs only; ValueError for others than it has."""
        columns, rows = (
            _places(inputs, self.inputs, "inputs"),
            _places(outputs, self.outputs, "outputs"),
        )
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


def _places(wanted: Iterable[str], there: tuple[str, ...], what: str) -> list[int]:
    wanted = tuple(wanted)
    if missing := [name for name in wanted if name not in there]:
        raise ValueError(
            f"{what} {', '.join(missing)} must be among {', '.join(there)}: choose from them"
        )
    return [there.index(name) for name in wanted]
