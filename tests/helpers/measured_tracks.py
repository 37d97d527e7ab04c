"""Measured motions of the rope, of the script in the examples."""

import importlib
import sys
from functools import cache
from typing import Any

import numpy as np
from checkout import EXAMPLES
from numpy.typing import NDArray

Array = NDArray[np.float64]


def example(name: str) -> Any:
    if str(EXAMPLES) not in sys.path:
        sys.path.append(str(EXAMPLES))
    return importlib.import_module(name)


def camera() -> Any:
    return example("camera_track")


@cache
def markers() -> Array:
    places: Array = camera().marker_places()
    return places
