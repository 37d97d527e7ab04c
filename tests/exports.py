"""The FMUs that are tested."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from fmu_src.export import export_fmu
from fmu_src.interface import Variable
from fmu_src.native.build import available_platforms, host_platform
from fmu_src.native.export import export_native
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


def export_drive(destination: Path, platforms: Sequence[str] = (host_platform(),)) -> Path:
    """The hoist drive of the 120 m scene."""
    drive = drive_model(SETUPS["rope-120"])
    table = [Variable(*variable) for variable in drive.variables]
    return export_model(destination, drive.name, drive.description, table, drive.sources, drive.attachments, platforms)


def native_with_stand_in(destination: Path, fmi: int) -> Path:
    """The native FMU around the stand-in for the rope, for all platforms that can be built here."""
    root = Path(__file__).parent
    files = (root / "native" / "stand_in.c", root.parent / "rope_model" / "native" / "rope.h")
    rope = {path.name: path.read_text(encoding="utf-8") for path in files}
    return export_native(destination, fmi=fmi, rope=rope)


def drive_everywhere(destination: Path) -> Path:
    """The hoist drive for all platforms that can be built here."""
    return export_drive(destination, available_platforms())


#: every kind of archive that is exported
ARCHIVES: dict[str, Callable[[Path], Path]] = {
    **{name: flavour.export for name, flavour in FLAVOURS.items()},
    "native-2": lambda path: native_with_stand_in(path, 2),
    "native-3": lambda path: native_with_stand_in(path, 3),
    "drive": drive_everywhere,
}
