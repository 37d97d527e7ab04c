"""The permanent curvature of a rope along its present shape: physics.initial_curvature from the left end on."""

import numpy as np
from numpy.typing import NDArray

from rope_model.parameters import Rope
from rope_model.physics.curved_element import directors_along
from rope_model.physics.element import ElementFidelity
from rope_model.physics.initial_curvature import START

Array = NDArray[np.float64]


def is_curved(rope: Rope, fidelity: ElementFidelity) -> bool:
    """Whether a permanent curvature acts: in the complete model alone sections have a direction."""
    return rope.initial_curvature > 0 and fidelity == "torsional"


def curved_reference(rope: Rope, q: Array, lengths: Array) -> Array:
    """Return (elements, physics.curved_element.CURVED): numbers of the rope ``q`` in the reference."""
    nodes, one = np.concatenate((q[:-1], q[1:]), axis=1), np.ones(lengths.size)
    along = directors_along(lengths.size)
    _, d = along(START, rope.initial_curvature_angle * one[None], lengths[None], nodes.T)
    numbers = q[:-1, 6], q[1:, 6], rope.initial_curvature * one, rope.EI * one
    return np.column_stack((np.array(d).T, *numbers))
