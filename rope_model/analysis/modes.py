"""Natural modes about an equilibrium: K x = omega^2 M x, with the symmetric tangent of the engine.

The modes are those of the complete model, whatever the fidelity; contact is left out.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import eigvals_banded
from scipy.sparse.linalg import eigsh

from rope_model.analysis.chain_matrices import of_blocks
from rope_model.arrays import Array
from rope_model.engine import NativeRope
from rope_model.physics.node import NODE_DOF, POSITION

#: N/m, rounding by Qa / l of a zero stiffness, as of a swivel that turns freely
ZERO_STIFFNESS = 1e-5
_Z = 2  #: of a position


@dataclass(frozen=True)
class Modes:
    """Lowest modes: frequencies (n,) in Hz, shapes (n, nodes, 7), and fraction of the motion out of plane (n,).

    ``out_of_plane`` is the fraction of the Z motion in the nodes' squared displacement: near 1 or
    near 0 for a rope without coupling, in between with it.
    """

    frequencies: Array
    shapes: Array
    out_of_plane: Array


class NoModesError(ValueError):
    """The rope has no modes: it is rigid, or its equilibrium is unstable."""


def natural_modes(rope: NativeRope, count: int = 8) -> Modes:
    """Return the ``count`` lowest modes, without damping, of a rope at rest.

    Raises NoModesError if the equilibrium is unstable and has no such frequency, or if the rope is
    a rigid model's, which is no equilibrium of the complete one.
    """
    if rope.fidelity == "rigid":
        raise NoModesError("a rigid rope has no modes: set model.fidelity = 'torsional'")
    free = rope.linear_facts().free
    return modes_of(of_blocks(*rope.tangent(q=1.0)), of_blocks(*rope.tangent(a=1.0)), free, count)


def modes_of(
    stiffness: sp.csc_matrix, mass: sp.csc_matrix, free: NDArray[np.bool_], count: int
) -> Modes:
    """Return the ``count`` lowest modes of a chain with these matrices, whose coordinates are ``free`` (nodes, 7).

    Raises NoModesError if the equilibrium is unstable and has no such frequency.
    """
    lowest = softest(stiffness, free)
    if lowest < -ZERO_STIFFNESS:
        raise NoModesError(
            f"the equilibrium is unstable: its softest stiffness, {lowest:.3g} N/m, is negative; use less twist"
        )
    moving = np.flatnonzero(free.ravel())
    K = stiffness[moving][:, moving]
    M = mass[moving][:, moving]
    start = np.ones(moving.size)  # ARPACK's own start is random
    squares, vectors = eigsh(0.5 * (K + K.T), count, M, sigma=0.0, v0=start)
    order = np.argsort(squares)
    shapes = np.zeros((count, free.size))
    shapes[:, moving] = vectors[:, order].T
    shapes = shapes.reshape(count, *free.shape)
    motion = np.sum(shapes[:, :, POSITION] ** 2, axis=1)
    return Modes(
        frequencies=np.sqrt(np.maximum(squares[order], 0.0)) / (2 * np.pi),
        shapes=shapes,
        out_of_plane=motion[:, _Z] / np.sum(motion, axis=1),
    )


def softest(stiffness: sp.csc_matrix, free: NDArray[np.bool_]) -> float:
    """Return the smallest eigenvalue of a chain's stiffness (N/m; N m for theta): negative if it is unstable."""
    moving = np.flatnonzero(free.ravel())
    K = stiffness[moving][:, moving]
    # the chain couples neighbouring nodes only
    band = np.zeros((2 * NODE_DOF, moving.size))
    for k in range(2 * NODE_DOF):
        band[k, : moving.size - k] = K.diagonal(-k)
    return float(eigvals_banded(band, lower=True, select="i", select_range=(0, 0))[0])
