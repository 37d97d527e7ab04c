"""The FMUs of the rope that are tested, each exported once in a run of the tests."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from fmu_src.export import export_fmu


@dataclass(frozen=True)
class Flavour:
    """How a rope FMU is made, and how close to the rope in process it must be."""

    export: Callable[[Path], Path]
    fmi: int
    native: bool
    tolerance: float  # of a force, relative to its largest value


FLAVOURS = {"python": Flavour(export_fmu, fmi=2, native=False, tolerance=1e-12)}
