"""Tools of the package index that import FMUs."""

import importlib.util
import os
import sysconfig
from pathlib import Path

import pytest
from signal_names import of_both_ends

INPUTS = [*of_both_ends("y", "vy", "ay")]

PACKAGES = {"fmpy": "fmpy", "libcosim": "libcosimpy", "ecos": "ecospy"}

#: versions of FMI that the tool imports
IMPORTS = {"fmpy": {2, 3}, "libcosim": {2}, "ecos": {2, 3}}


def environment() -> dict[str, str]:
    """Ecos finds libtbb in the environment's lib, where the package tbb puts it."""
    return {**os.environ, "LD_LIBRARY_PATH": str(Path(sysconfig.get_path("data")) / "lib")}


def require(tool: str) -> None:
    if importlib.util.find_spec(PACKAGES[tool]) is None:
        pytest.skip(
            f"{PACKAGES[tool]} is not installed; it has no wheel for this platform or Python"
        )
