"""Errors of a winding against a reference, as every page states them."""

from typing import Any

import numpy as np


def force_error(force: Any, exact: Any) -> float:
    """Return the root mean square of the end forces' error over the largest force."""
    exact = np.asarray(exact)
    return float(np.sqrt(np.mean((np.asarray(force) - exact) ** 2)) / np.max(np.abs(exact)))


def place_error(places: Any, exact: Any) -> float:
    """Return the largest distance of the loop's lowest points (samples, 3), m."""
    return float(np.max(np.linalg.norm(np.asarray(places) - exact, axis=1)))


def end_error(forces: Any, exact: Any) -> float:
    """Return the root mean square of the worse end's error over the largest force; (samples, 6), left and right."""
    off, force = (np.reshape(x, (-1, 2, 3)) for x in (np.asarray(forces) - exact, exact))
    worse = np.sqrt(np.mean(np.sum(off**2, axis=2), axis=0)).max()
    return float(worse / np.linalg.norm(force, axis=2).max())
