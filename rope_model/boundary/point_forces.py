"""Forces that a host applies to points of the rope.

They act until others are applied; they are no part of its state.  The shape functions of an element
distribute them to its nodes, so that their power is that at their points.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from rope_model.arrays import Array
from rope_model.physics import hermite
from rope_model.physics.node import ANGLE

#: tolerance for points beyond the rope's ends, over its length
BEYOND_ENDS = 1e-9


@dataclass(frozen=True)
class PointForces:
    """Forces on points of the rope; they change linearly between two instants."""

    s: Array  #: (n,), arc lengths of the points in ascending order, m
    at_start: Array  #: (n, 3), forces at ``start``, N
    at_stop: Array  #: (n, 3), forces at ``stop``, N
    start: float  #: s
    stop: float  #: s

    def __post_init__(self) -> None:
        shape = (self.s.size, 3)
        if not (self.at_start.shape == shape == self.at_stop.shape):
            shapes = f"{self.at_start.shape} and {self.at_stop.shape}"
            raise ValueError(
                f"forces have the shapes {shapes}, both must be {shape}: give three components per place"
            )
        if not self.start < self.stop:
            raise ValueError(
                f"start = {self.start:g} s must be before stop = {self.stop:g} s: give the step's ends"
            )
        if not (np.diff(self.s) >= 0.0).all():
            raise ValueError("s goes back along the rope and must ascend: sort the places")

    def require_on(self, length: float) -> None:
        """Raise ValueError unless all points are on a rope of this ``length`` (m), up to rounding."""
        if self.s.size and not (
            -BEYOND_ENDS * length <= self.s[0] and self.s[-1] <= (1.0 + BEYOND_ENDS) * length
        ):
            reach = f"from {self.s[0]:g} m to {self.s[-1]:g} m"
            raise ValueError(
                f"s goes {reach} and must be between 0 and the rope's length = {length:g} m: mend the places"
            )


NO_FORCES = PointForces(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)), 0.0, 1.0)


def elements_at(s: Array, lengths: Array) -> tuple[Array, Array]:
    """Return the element of each point, and its shape functions there (4, n)."""
    ends = np.cumsum(lengths)
    elements: Any = np.searchsorted(ends[:-1], s)
    l = lengths[elements]
    return elements, np.array(hermite.shape_functions((s - (ends[elements] - l)) / l, l))


def at_places(x: Array, elements: Array, N: Array) -> Array:
    """Return the values (n, 3) at points of ``x`` (nodes, 6 or more), which has r, r' in its rows."""
    ends = np.concatenate((x[elements, :ANGLE], x[elements + 1, :ANGLE]), axis=1).reshape(-1, 4, 3)
    return np.asarray(np.einsum("kn,nki->ni", N, ends))
