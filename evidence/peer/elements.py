"""Exudyn's beam and cable elements, and their nodes' coordinates in terms of ours (r, r', angle)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Element:
    """One of Exudyn's elements; ``options`` are its own, ``held`` the prescribed coordinates of an end node."""

    key: str
    label: str
    item: str
    node: str
    held: tuple[int, ...]
    middle: bool = False  # has a node in its middle
    options: dict[str, Any] = field(default_factory=dict)

    def coordinates(self, q: Array) -> Array:
        """Its nodes' coordinates for ours, (nodes, 7), in the plane."""
        match self.node:
            case "NodePoint2DSlope1":
                return q[:, [0, 1, 3, 4]]
            case "NodePointSlope1":
                return q[:, :6]
            case "NodeRigidBody2D":
                return np.column_stack((q[:, :2], np.unwrap(np.arctan2(q[:, 4], q[:, 3]))))
            case _:
                angle = np.unwrap(np.arctan2(q[:, 4], q[:, 3]))
                return np.column_stack((q[:, :3], np.array([euler_parameters(a, 0.0) for a in angle])))

    def ours(self, c: Array) -> Array:
        """(nodes, 7): r, r' and a zero angle for its nodes' coordinates."""
        q = np.zeros((c.shape[0], 7))
        match self.node:
            case "NodePoint2DSlope1":
                q[:, [0, 1, 3, 4]] = c
            case "NodePointSlope1":
                q[:, :6] = c
            case "NodeRigidBody2D":
                q[:, [0, 1]], q[:, 3], q[:, 4] = c[:, :2], np.cos(c[:, 2]), np.sin(c[:, 2])
            case _:
                e0, e1, e2, e3 = c[:, 3:].T
                q[:, :3] = c[:, :3]
                q[:, 3:6] = np.column_stack(
                    (1 - 2 * (e2 * e2 + e3 * e3), 2 * (e1 * e2 + e0 * e3), 2 * (e1 * e3 - e0 * e2))
                )
        return q


def euler_parameters(angle: float, twist: float) -> Array:
    """Turned by ``angle`` about Z after ``twist`` about X."""
    c, s, ct, st = np.cos(angle / 2), np.sin(angle / 2), np.cos(twist / 2), np.sin(twist / 2)
    return np.array([c * ct, c * st, s * st, s * ct])


_PLANAR, _SLOPE, RIGID = "NodePoint2DSlope1", "NodePointSlope1", "NodeRigidBodyEP"
_ANCF_2D, BEAM_2D = "ObjectANCFCable2D", "ObjectBeamGeometricallyExact2D"
ELEMENTS = {
    e.key: e
    for e in (
        Element("ancf", "ANCFCable2D, Gauss", _ANCF_2D, _PLANAR, (0, 1, 2), options={"useReducedOrderIntegration": 1}),
        Element(
            "ancf-lobatto",
            "ANCFCable2D, Lobatto",
            _ANCF_2D,
            _PLANAR,
            (0, 1, 2),
            options={"useReducedOrderIntegration": 2},
        ),
        Element("beam", "BeamGeometricallyExact2D, linear", BEAM_2D, "NodeRigidBody2D", (0, 1, 2)),
        Element("beam-quadratic", "BeamGeometricallyExact2D, quadratic", BEAM_2D, "NodeRigidBody2D", (0, 1, 2), True),
        Element(
            "ancf-3d",
            "ANCFCable (3-D)",
            "ObjectANCFCable",
            _SLOPE,
            (0, 1, 2, 3, 5),
            options={"useReducedOrderIntegration": 1},
        ),
        Element("beam-3d", "BeamGeometricallyExact (3-D)", "ObjectBeamGeometricallyExact", RIGID, (0, 1, 2, 4, 5, 6)),
    )
}
