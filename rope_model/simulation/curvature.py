"""Permanent curvature along the present shape of a rope: physics.initial_curvature from the left end on."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from rope_model.arrays import Array
from rope_model.parameters import Rope
from rope_model.physics.curved_element import curvature_along
from rope_model.physics.element import ElementFidelity
from rope_model.physics.initial_curvature import (
    CURVATURES,
    PLUMB,
    START,
    carried_director,
    curvature_components,
    max_curvature,
)

Director = tuple[float, float, float]


@lru_cache(maxsize=64)
def is_curved(rope: Rope, fidelity: ElementFidelity) -> bool:
    """Return whether a permanent curvature acts: sections have a direction in the complete model only."""
    return fidelity == "torsional" and max_curvature(rope) > 0


def partly_curved(rope: Rope, fraction: float) -> Rope:
    """Return the rope with a ``fraction`` of its permanent curvature."""
    return replace(rope, **{name: fraction * getattr(rope, name) for name in CURVATURES})


def start_director(q: Array) -> Director:
    """Return e1 of the permanent curvature at the left end of a rope ``q`` (nodes, 7) that is hung up."""
    return carried_director(START, PLUMB, q[0, 3:6].tolist())


def curved_reference(rope: Rope, q: Array, lengths: Array, director: Director) -> Array:
    """Return the entries of the rope ``q`` in the reference (elements, physics.curved_element.CURVATURE_SIZE).

    ``director`` is e1 at the left end.
    """
    nodes = np.concatenate((q[:-1], q[1:]), axis=1)
    components = np.array(curvature_components(rope, np.cumsum(lengths) - lengths, lengths))
    _, k0 = curvature_along(lengths.size)(director, components, lengths[None], nodes.T)
    return np.column_stack((np.array(k0).T, q[:-1, 6], q[1:, 6], np.full(lengths.size, rope.EI)))
