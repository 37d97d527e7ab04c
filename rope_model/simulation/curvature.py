"""The permanent curvature of a rope along its present shape: physics.initial_curvature from the left end on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..parameters import Rope
from ..physics.element import ElementFidelity
from ..physics.initial_curvature import START, directors

Array = NDArray[np.float64]


def is_curved(rope: Rope, fidelity: ElementFidelity) -> bool:
    """Whether a permanent curvature acts: in the complete model alone sections have a direction."""
    return rope.initial_curvature > 0 and fidelity == "torsional"


def curved(rope: Rope, q: Array, lengths: Array) -> Array:
    """(elements, physics.curved_element.CURVED): what the rope ``q`` has in the reference."""
    numbers, e1 = np.zeros((lengths.size, 13)), START
    numbers[:, 9], numbers[:, 10] = q[:-1, 6], q[1:, 6]
    numbers[:, 11:] = rope.initial_curvature, rope.EI
    nodes = np.concatenate((q[:-1], q[1:]), axis=1).tolist()
    for row, of_nodes, l in zip(numbers, nodes, lengths.tolist(), strict=True):
        *row[:9], x, y, z = directors(rope.initial_curvature_angle, l, of_nodes, e1)
        e1 = x, y, z
    return numbers
