"""Natural modes about an equilibrium: K x = omega^2 M x with the element's own tangent.

This module needs scipy; nothing in an FMU imports it.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.linalg import eigvals_banded
from scipy.sparse.linalg import eigsh

from rope_model.physics.element import NODE_DOF, element_functions
from rope_model.simulation.rope_kernels import rope_element
from rope_model.simulation.rope_system import ANGLE, POSITION, Array, RopeSystem

#: N/m, rounding by Qa / l of a zero stiffness, as of a swivel that turns freely
ROUNDING = 1e-5


@dataclass(frozen=True)
class Modes:
    """Lowest modes: frequencies (n,) in Hz, shapes (n, nodes, 7), and fraction of the motion out of plane (n,).

    ``out_of_plane`` is the fraction of the Z motion in the nodes' squared displacement: near 1 or near 0 for a rope
    without coupling, in between with it.
    """

    frequencies: Array
    shapes: Array
    out_of_plane: Array


def natural_modes(system: RopeSystem, q: Array, count: int = 8) -> Modes:
    """Return the ``count`` lowest modes about the equilibrium ``q`` (nodes, 7), without damping.

    Raises ValueError if the equilibrium is unstable and has no such frequency.
    """
    if (soft := softest(system, q)) < -ROUNDING:
        raise ValueError(
            f"the equilibrium is unstable: its softest stiffness, {soft:.3g} N/m, is negative; use less twist"
        )
    free = np.flatnonzero(system.free.ravel())
    stiffness, mass = (
        assemble_matrix(system, q, c)[free][:, free] for c in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    )
    start = np.ones(free.size)  # ARPACK's own start is random
    squares, vectors = eigsh(0.5 * (stiffness + stiffness.T), count, mass, sigma=0.0, v0=start)
    order = np.argsort(squares)
    shapes = np.zeros((count, q.size))
    shapes[:, free] = vectors[:, order].T
    shapes = shapes.reshape(count, *q.shape)
    motion = np.sum(shapes[:, :, POSITION] ** 2, axis=1)
    return Modes(
        frequencies=np.sqrt(np.maximum(squares[order], 0.0)) / (2 * np.pi),
        shapes=shapes,
        out_of_plane=motion[:, 2] / np.sum(motion, axis=1),
    )


def softest(system: RopeSystem, q: Array) -> float:
    """Return the smallest eigenvalue of the tangent stiffness (N/m; N m for theta): negative if ``q`` is unstable."""
    free = np.flatnonzero(system.free.ravel())
    stiffness = assemble_matrix(system, q, (1.0, 0.0, 0.0))[free][:, free]
    # the chain couples neighbouring nodes only
    band = np.zeros((2 * NODE_DOF, free.size))
    for k in range(2 * NODE_DOF):
        band[k, : free.size - k] = stiffness.diagonal(-k)
    return float(eigvals_banded(band, lower=True, select="i", select_range=(0, 0))[0])


def assemble_matrix(system: RopeSystem, q: Array, c: tuple[float, float, float]) -> sp.csc_matrix:
    """Return the sparse c[0] dR/dq + c[1] dR/dv + c[2] dR/da of all nodes at rest in ``q``, away from bodies."""
    n, zeros = system.lengths.size, np.zeros_like(q)
    frames, P = system.with_reference(q, system.z).element_data(q, zeros)
    if system.kernels.fidelity != "torsional":  # whose frames have no entries of the section's
        sides = np.hstack((q[:-1], q[1:])).T
        frames = np.hstack(
            (
                np.asarray(element_functions().reference.map(n)(sides, system.lengths[None, :])).T,
                frames,
            )
        )
    angles = np.column_stack((q[:, :ANGLE], q[:, ANGLE] + system.frame_turn(q)))
    q_e, v_e = (np.hstack((x[:-1], x[1:])).T for x in (angles, zeros))
    J = rope_element("torsional", system.kernels.features).tangent.map(n)(
        q_e,
        v_e,
        v_e,
        system.lengths[None, :],
        frames.T,
        np.tile(P[:, None], n),
        *(np.full((1, n), x) for x in c),
        q_e,
    )[1]
    return assembled(np.asarray(J), n) + sp.diags(c[2] * system.node_mass.ravel())


def assembled(J: Array, n: int) -> sp.csc_matrix:
    """Return the sparse matrix of a chain of ``n`` elements from theirs, side by side (2 dof, 2 dof n)."""
    blocks = J.reshape(2 * NODE_DOF, n, 2 * NODE_DOF).transpose(1, 0, 2)
    local = NODE_DOF * np.arange(n)[:, None] + np.arange(2 * NODE_DOF)
    rows = np.broadcast_to(local[:, :, None], blocks.shape)
    columns = np.broadcast_to(local[:, None, :], blocks.shape)
    size = NODE_DOF * (n + 1)
    return sp.csc_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))
