"""Exudyn's planar beam and cable elements, and their nodes' coordinates in terms of ours (r, r', angle)."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from evidence.tables import Array

CABLE_NODE, BEAM_NODE = "NodePoint2DSlope1", "NodeRigidBody2D"
CABLE, BEAM = "ObjectANCFCable2D", "ObjectBeamGeometricallyExact2D"


@dataclass(frozen=True)
class Element:
    """One of Exudyn's elements, three coordinates of an end node of which are prescribed; ``options`` are its own."""

    key: str
    label: str
    item: str
    node: str
    middle: bool = False  # has a node in its middle
    options: dict[str, Any] = field(default_factory=dict)

    def coordinates(self, q: Array) -> Array:
        """Return its nodes' coordinates for ours, (nodes, 7), in the plane."""
        if self.node == CABLE_NODE:
            return q[:, [0, 1, 3, 4]]
        return np.column_stack((q[:, :2], np.unwrap(np.arctan2(q[:, 4], q[:, 3]))))

    def ours(self, c: Array) -> Array:
        """Return (nodes, 7): r, r' and a zero angle for its nodes' coordinates."""
        q = np.zeros((c.shape[0], 7))
        if self.node == CABLE_NODE:
            q[:, [0, 1, 3, 4]] = c
        else:
            q[:, [0, 1]], q[:, 3], q[:, 4] = c[:, :2], np.cos(c[:, 2]), np.sin(c[:, 2])
        return q


ELEMENTS = {
    e.key: e
    for e in (
        Element("ancf", "ANCFCable2D, Gauss", CABLE, CABLE_NODE, options={"useReducedOrderIntegration": 1}),
        Element("ancf-lobatto", "ANCFCable2D, Lobatto", CABLE, CABLE_NODE, options={"useReducedOrderIntegration": 2}),
        Element("beam", "BeamGeometricallyExact2D, linear", BEAM, BEAM_NODE),
        Element("beam-quadratic", "BeamGeometricallyExact2D, quadratic", BEAM, BEAM_NODE, middle=True),
    )
}
