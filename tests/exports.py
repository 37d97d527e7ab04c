"""The FMUs that are tested."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from fmu_src.export import export_fmu
from fmu_src.interface import Variable
from fmu_src.native.build import available_platforms, host_platform
from fmu_src.native.export import export_native
from fmu_src.native.model_fmu import export_model
from fmu_src.profile import ALL, FULL, Profile
from hoist_demo.drive_fmu.description import drive_model
from hoist_demo.parameters import SETUPS


@dataclass(frozen=True)
class Flavour:
    """How an FMU of the rope is made, and how close to the rope in process it must be."""

    export: Callable[[Path], Path]
    fmi: int
    native: bool
    tolerance: float  # of a force, relative to its largest value


FLAVOURS: dict[str, Flavour] = {}
#: whether the rope itself is there in C; else a stand-in takes its place in the archives
NATIVE_ROPE = importlib.util.find_spec("rope_model.native.build") is not None


def python(destination: Path) -> Path:
    """Exports the Python flavour for this platform."""
    return export_fmu(destination, profile=FULL, platforms=(host_platform(),))


def native(
    fmi: int,
    platforms: Sequence[str] | None = None,
    profile: Profile = FULL,
) -> Callable[[Path], Path]:
    """Exports the native FMU; for all platforms that can be built here if None."""

    def export(destination: Path) -> Path:
        rope = None if NATIVE_ROPE else stand_in()
        return export_native(destination, fmi=fmi, platforms=platforms, rope=rope, profile=profile)

    return export


def stand_in() -> dict[str, str]:
    """Hanging weights behind rope.h."""
    root = Path(__file__).parent
    files = (root / "native" / "stand_in.c", root.parent / "rope_model" / "native" / "rope.h")
    return {path.name: path.read_text(encoding="utf-8") for path in files}


if host_platform() in available_platforms():
    FLAVOURS["python"] = Flavour(python, fmi=2, native=False, tolerance=1e-12)
if NATIVE_ROPE and host_platform() in available_platforms():
    FLAVOURS |= {
        f"native-{fmi}": Flavour(native(fmi, (host_platform(),)), fmi=fmi, native=True, tolerance=1e-9)
        for fmi in (2, 3)
    }


def export_drive(destination: Path, platforms: Sequence[str] = (host_platform(),), fmi: int = 2) -> Path:
    """The hoist drive of the 120 m scene."""
    drive = drive_model(SETUPS["rope-120"])
    table = [Variable(*variable) for variable in drive.variables]
    return export_model(
        destination, drive.name, drive.description, table, drive.sources, drive.attachments, platforms, fmi
    )


def drive_everywhere(fmi: int) -> Callable[[Path], Path]:
    """Exports the hoist drive for all platforms that can be built here."""
    return lambda destination: export_drive(destination, available_platforms(), fmi)


#: every kind of archive that is exported
ARCHIVES: dict[str, Callable[[Path], Path]] = {
    "python": FLAVOURS["python"].export,
    "python-lean": export_fmu,
    "native-2": native(2),
    "native-2-lean": native(2, (host_platform(),), Profile()),
    "native-3": native(3),
    "native-3-scalar": native(3, (host_platform(),), Profile(ALL, arrays=False)),
    "native-3-least": native(3, (host_platform(),), Profile(())),
    "drive-2": drive_everywhere(2),
    "drive-3": drive_everywhere(3),
}
