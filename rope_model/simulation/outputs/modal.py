"""Matrices of a RopeSystem for tests and evidence whose chains are no balance ropes; rope_model.analysis has the modes.

This module needs scipy; nothing in an FMU imports it.
"""

import numpy as np
import scipy.sparse as sp

from rope_model.analysis.chain_matrices import of_elements
from rope_model.arrays import Array
from rope_model.physics.node import ANGLE
from rope_model.physics.rope_element import rope_element
from rope_model.simulation.rope_system import RopeSystem


def assemble_matrix(system: RopeSystem, q: Array, c: tuple[float, float, float]) -> sp.csc_matrix:
    """Return the sparse c[0] dR/dq + c[1] dR/dv + c[2] dR/da of all nodes at rest in ``q``, away from bodies."""
    n, zeros = system.lengths.size, np.zeros_like(q)
    frames, P = system.with_reference(q, system.z).element_data(q, zeros)
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
    return of_elements(np.asarray(J), n) + sp.diags(c[2] * system.node_mass.ravel())
