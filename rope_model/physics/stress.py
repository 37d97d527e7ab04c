"""Nominal stresses of a wire rope, as in a solid round bar of its diameter; ``rope`` is that of a scene."""

import math
from typing import Annotated, Any

from rope_model.parameters import Rope
from rope_model.physics.costello import torque
from rope_model.physics.element import STRAINS
from rope_model.physics.elementary import Scalar, Vector, sqrt


def bending_stress(rope: Rope, k: Scalar) -> Scalar:
    """Return the largest bending stress (Pa) at the curvature ``k`` (1/m)."""
    return 32 * rope.EI * k / (math.pi * rope.diameter**3)


def material_values(
    rope: Rope, torsional: Scalar, strains: Annotated[Vector, len(STRAINS)]
) -> tuple[Any, Any, Any, Any]:
    """Return bending and torsional stress (Pa), curvature (1/m), torque (N m) at ``strains``, see element.STRAINS.

    ``torsional`` is 1, or 0 for a fidelity that computes no torsion, and so no torque.
    """
    e, tau, k, e_t, tau_t = strains
    root = sqrt(rope.torsion_damping)
    # as the element has it: the damping belongs to the moment that is balanced
    damping = rope.beta_K * root * torque(rope.Qs, 0.0, rope.Qd, 0.0, e_t, root * tau_t)
    moment = torque(rope.Qs, rope.Qk, rope.Qd, rope.Qe, e, tau) + damping
    # the largest shear stress
    stress = 16 * abs(moment) / (math.pi * rope.diameter**3)
    # adding 0.0 turns -0 into +0
    return bending_stress(rope, k), stress * torsional, k, moment * torsional + 0.0
