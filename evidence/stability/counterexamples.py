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
from rope_model.physics.frame import FrameRate
from rope_model.reference import stepping
from rope_model.reference.state import State


@contextmanager
def modified_frame(frame_rate: FrameRate) -> Iterator[None]:
    """Give reference ropes inside another frame of the section."""
    functions = element.element_functions("torsional", frame_rate)
    functions = replace(functions, transport=_none(functions.transport))
    with with_element(functions):
        yield


@contextmanager
def pointwise_strain(gauss_points: int) -> Iterator[None]:
    """Give reference ropes inside the axial energy of the strain at each of so many Gauss points.

    Damping keeps the assumed strain.
    """
    functions = element.element_functions()
    q, v, a, q_prestress = (ca.SX.sym(name, 14) for name in ("q", "v", "a", "q_prestress"))
    l = ca.SX.sym("l")
    F = ca.SX.sym("F", element.FRAME_SIZE)
    P = ca.SX.sym("P", len(element.PARAMETERS))
    c_q, c_v, c_a = (ca.SX.sym(name) for name in ("c_q", "c_v", "c_a"))
    relative = element.relative_coordinates()

    def mean(count: int, power: int) -> Any:
        """Return the mean of a power of the strain by ``count`` Gauss points."""
        total = ca.SX(0)
        for x, weight in zip(*np.polynomial.legendre.leggauss(count), strict=True):
            slope = (element.interpolation(0.5 + 0.5 * x, l) @ relative @ q)[:3]
            total += 0.5 * weight * (ca.norm_2(slope) - 1) ** power
        return total

    assumed = element.AxialStrain.of(mean(3, 1), *element.strains_at_nodes(q))
    Qa = element.parameters_from(P).Qa
    stiffness, force = ca.hessian(
        0.5 * l * Qa * (mean(gauss_points, 2) - element.mean_square(assumed)), q
    )
    tangent_arguments = [q, v, a, l, F, P, c_q, c_v, c_a, q_prestress]
    R, J = functions.tangent(*tangent_arguments)
    functions = functions.replaced(
        residual=([q, v, a, l, F, P], [functions.residual(q, v, a, l, F, P) + force]),
        tangent=(tangent_arguments, [R + force, J + c_q * stiffness]),
    )
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
