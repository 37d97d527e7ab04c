"""Nodes of a rope: rows of seven coordinates, and their arc lengths."""

from typing import Annotated, TypeAlias

import numpy as np

from rope_model.arrays import Array
from rope_model.physics.elementary import Vector

SIDES = ("left", "right")  #: ends of the rope, and the conveyances to which they are fixed
END_NODE = (0, -1)  #: rows of the ends in arrays of nodes
#: columns of r, r' and theta in a node's row
POSITION = slice(0, 3)
SLOPE = slice(3, 6)
ANGLE = 6
NODE_DOF = 7

#: r and r' of a node
PointRow: TypeAlias = Annotated[Vector, ANGLE]
#: row of a node
NodeRow: TypeAlias = Annotated[Vector, NODE_DOF]
#: rows of both nodes of an element, one behind the other
ElementRows: TypeAlias = Annotated[Vector, 2 * NODE_DOF]


def arc_lengths(lengths: Array) -> Array:
    """Return the arc lengths (m) of the nodes from the left end, for element lengths from left to right."""
    return np.concatenate(([0.0], np.cumsum(lengths)))
