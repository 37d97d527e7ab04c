"""The FMUs that are tested."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from fmu_src.export import export_fmu
from fmu_src.interface import Variable
from fmu_src.native.build import host_platform
from fmu_src.native.model_fmu import export_model
from hoist_demo.drive_fmu.description import drive_model
from hoist_demo.parameters import SETUPS


@dataclass(frozen=True)
class Flavour:
    """How an FMU of the rope is made, and how close to the rope in process it must be."""

    export: Callable[[Path], Path]
    fmi: int
    native: bool
    tolerance: float  # of a force, relative to its largest value


FLAVOURS = {"python": Flavour(export_fmu, fmi=2, native=False, tolerance=1e-12)}


def export_drive(destination: Path) -> Path:
    """The hoist drive of the 120 m scene, for this platform."""
    drive = drive_model(SETUPS["rope-120"])
    table = [Variable(*variable) for variable in drive.variables]
    return export_model(
        destination, drive.name, drive.description, table, drive.sources, drive.attachments, (host_platform(),)
    )
