"""The element with one thing done differently: what the entries' counterexamples are built of."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from typing import Any
from unittest.mock import patch

import casadi as ca
import numpy as np
from rope_model.simulation import rope_kernels

from rope_model.physics import element
from rope_model.physics.frame import FrameRate, smallest_rotation_rate


@contextmanager
def modified_element(
    frame_rate: FrameRate = smallest_rotation_rate, gauss_points: int = 3
) -> Iterator[None]:
    """Ropes made inside have the element with another frame of the section or another quadrature."""
    points, weights = np.polynomial.legendre.leggauss(gauss_points)
    places: dict[str, Any] = {"POINTS": 0.5 + 0.5 * points, "WEIGHTS": 0.5 * weights}
    places["FRAME_SIZE"] = 6 * gauss_points + 3
    uncached = element.element_functions.__wrapped__

    @cache
    def functions(fidelity: element.ElementFidelity = "torsional") -> element.ElementFunctions:
        with patch.multiple(element, **places):
            twin = uncached(fidelity, frame_rate)
        return (
            twin
            if frame_rate is smallest_rotation_rate
            else replace(twin, transport=_none(twin.transport))
        )

    made_anew = {
        name: getattr(rope_kernels, name).__wrapped__ for name in ("rope_parts", "rope_functions")
    }
    with (
        patch.multiple(rope_kernels, **made_anew),
        patch.object(element, "element_functions", functions),
    ):
        yield


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
