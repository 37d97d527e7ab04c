"""The reference rope with one thing done differently: what the entries' counterexamples are built of."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any
from unittest.mock import patch

import casadi as ca
import numpy as np

from evidence.statics import with_element
from rope_model.parameters import Scene
from rope_model.physics import element
from rope_model.physics.frame import FrameRate, smallest_rotation_rate
from rope_model.reference import stepping
from rope_model.reference.state import State


@contextmanager
def modified_element(
    frame_rate: FrameRate = smallest_rotation_rate, gauss_points: int = 3
) -> Iterator[None]:
    """Give reference ropes inside another frame of the section or another quadrature."""
    points, weights = np.polynomial.legendre.leggauss(gauss_points)
    places: dict[str, Any] = {"POINTS": 0.5 + 0.5 * points, "WEIGHTS": 0.5 * weights}
    places["FRAME_SIZE"] = 6 * gauss_points + 3
    with patch.multiple(element, **places):
        functions = element.element_functions.__wrapped__("torsional", frame_rate)
    if frame_rate is not smallest_rotation_rate:
        functions = replace(functions, transport=_none(functions.transport))
    with with_element(functions):
        yield


@contextmanager
def fixed_mesh() -> Iterator[None]:
    """Leave the mesh of reference ropes inside as it is at their start."""
    with patch.object(stepping, "with_mesh_for", _unchanged):
        yield


def _unchanged(scene: Scene, state: State, t: float) -> State:
    return state


def _none(transport: ca.Function) -> ca.Function:
    """A frame that is counted from no state is not carried along with it."""
    inputs = transport.sx_in()
    return ca.Function(transport.name(), inputs, [ca.SX.zeros(3)])


def tait_bryan_rate(p: Any, turn: Any, d: Any, change: Any) -> Any:
    """Turning of the source's Z-Y-X frame about the tangent while r' = ``d`` changes; singular at r' parallel to Z.

    It is counted from the axes: the reference ``p`` and its ``turn`` are not used.
    """
    length = (d[0] ** 2 + d[1] ** 2 + d[2] ** 2) ** 0.5
    return d[2] * (d[0] * change[1] - d[1] * change[0]) / ((d[0] ** 2 + d[1] ** 2) * length)
