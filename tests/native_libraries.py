"""Native FMUs with the rope in them, and numbers that no host should give them."""

import math
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
from native_raw import Library

VERSIONS = (2, 3)


@pytest.fixture(scope="module")
def libraries(tmp_path_factory: pytest.TempPathFactory, fmu_of: Callable[[str], Path]) -> dict[int, Library]:
    made = {}
    for fmi in VERSIONS:
        folder = tmp_path_factory.mktemp(f"fmi{fmi}")
        path = fmu_of(f"native-{fmi}")
        made[fmi] = Library(path, fmpy.extract(str(path), str(folder / "unzipped")))
    return made


@pytest.fixture(params=VERSIONS)
def library(request: pytest.FixtureRequest, libraries: dict[int, Library]) -> Library:
    return libraries[request.param]


HOSTILE = [math.nan, math.inf, -math.inf, 0.0, -0.0, -1.0, 5e-324, 2.2e-308, 1e-300, 1e-9, 1e-3, 1.0, 1e3, 1e9, 1e300]
#: of entries that make large ropes, which are slow, only what is refused or small
TAME: dict[str, list[float]] = {
    "rope.length": [math.nan, math.inf, 0.0, -1.0, 1e-300, 1e-9, 5.0, 60.0, 1e5, 1e300],
    "mesh.coarse_length": [math.nan, 0.0, -1.0, 1e-300, 1e-9, 0.5, 3.0, 1e300],
    "mesh.loop_error": [math.nan, 0.0, -1.0, 1.0, 1e300],
    "mesh.elements": [-1, 0, 1, 2, 3, 50, 20001, 2**31 - 1, -(2**31)],
    "mesh.kind": [-1, 0, 1, 3, 2**31 - 1],
    **{f"mesh.counts[{k}]": [-4, 0, 1, 4, 8, 40, 2**31 - 8] for k in range(1, 6)},
}
WHOLE = [-(2**31), -1, 0, 1, 2, 3, 4, 5, 2**31 - 1]


def hostile(name: str, kind: str) -> list[float]:
    return TAME.get(name, HOSTILE if kind in ("Real", "Float64") else list(map(float, WHOLE)))
