"""Types of fixtures and arrays, an unstrained rope, differences, rotations."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Array = NDArray[np.float64]
Capture = pytest.CaptureFixture[str]
Patch = pytest.MonkeyPatch
#: gives the FMU of a kind, and the folder into which it is unpacked
Unpacked = Callable[[str], tuple[Path, str]]


def slow_if(is_slow: bool) -> tuple[pytest.MarkDecorator, ...]:
    """Return the marks of a test's parameter."""
    if is_slow:
        return (pytest.mark.slow,)
    return ()


def straight(s: Array) -> Array:
    """(nodes, 7): an unstrained rope along X."""
    q = np.zeros((s.size, 7))
    q[:, 0] = s
    q[:, 3] = 1.0
    return q


def difference(f: Callable[[Array], Any], x: Any, step: float = 1e-5) -> Array:
    """Columns df/dx_i by central differences, which err by the square of the step and by rounding over it."""
    at = np.array(x)
    columns = [
        (np.asarray(f(at + d)) - np.asarray(f(at - d))) / (2 * step) for d in step * np.eye(at.size)
    ]
    return np.stack(columns, axis=-1)


def rotation(vector: Array) -> Array:
    """(3, 3): turning by |vector| about ``vector``."""
    angle = float(np.linalg.norm(vector))
    axis = vector
    if angle > 0:
        axis = vector / angle
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
