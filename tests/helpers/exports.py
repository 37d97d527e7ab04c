"""The FMUs that are tested."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from stand_in import VERSIONS, stand_in

from fmu_src.native.export import export_model, export_native
from fmu_src.profile import ALL, FULL, Profile
from fmu_src.python.export import export_fmu
from fmu_src.shell.build import available_platforms, host_platform
from hoist_demo.cases.table import find_case
from hoist_demo.drive_fmu.description import drive_model
from rope_model.cases import Level


@dataclass(frozen=True)
class Flavour:
    """How an FMU of the rope is made, and how close to the rope in process it must be."""

    export: Callable[[Path], Path]
    fmi: int
    native: bool
    tolerance: float  # of a force, relative to its largest value


FLAVOURS: dict[str, Flavour] = {}


def python(profile: Profile = FULL) -> Callable[[Path], Path]:
    return partial(export_fmu, profile=profile, platforms=(host_platform(),))


def native(
    fmi: int,
    platforms: Sequence[str] | None = None,
    profile: Profile = FULL,
    level: Level = "standard",
) -> Callable[[Path], Path]:
    return partial(export_native, fmi=fmi, platforms=platforms, profile=profile, level=level)


if host_platform() in available_platforms():
    FLAVOURS["python"] = Flavour(python(), fmi=2, native=False, tolerance=1e-12)
    FLAVOURS |= {
        f"native-{fmi}": Flavour(
            native(fmi, (host_platform(),)), fmi=fmi, native=True, tolerance=1e-9
        )
        for fmi in (2, 3)
    }

#: kinds of the flavour that is the complete model
NATIVE = [kind for kind, flavour in FLAVOURS.items() if flavour.native]


def export_drive(
    destination: Path, platforms: Sequence[str] = (host_platform(),), fmi: int = 2
) -> Path:
    """The hoist drive of the 120 m scene."""
    return export_model(destination, platforms, fmi, drive_model(find_case("rope-120")))


def export_stand_in(destination: Path, fmi: int) -> Path:
    """The native FMU with the stand-in for the rope."""
    return export_native(
        destination, fmi=fmi, platforms=(host_platform(),), rope=stand_in(), profile=FULL
    )


#: every kind of archive that is exported, for this platform
ARCHIVES: dict[str, Callable[[Path], Path]] = {
    "python": python(),
    "python-lean": python(profile=Profile()),
    "native-2": native(2, (host_platform(),)),
    "native-2-lean": native(2, (host_platform(),), Profile()),
    "native-3": native(3, (host_platform(),)),
    "native-3-scalar": native(3, (host_platform(),), Profile(ALL, arrays=False)),
    "native-3-least": native(3, (host_platform(),), Profile(())),
    "drive-2": partial(export_drive, fmi=2),
    "drive-3": partial(export_drive, fmi=3),
}
#: the same for all platforms that can be built here
ARCHIVES_EVERYWHERE: dict[str, Callable[[Path], Path]] = {
    "native-2 everywhere": native(2),
    "native-3 everywhere": native(3),
    "drive-2 everywhere": partial(export_drive, platforms=available_platforms(), fmi=2),
    "drive-3 everywhere": partial(export_drive, platforms=available_platforms(), fmi=3),
}
#: what the tests share: these, the FMU of the draft level, and those with the stand-in
EXPORTS = {**ARCHIVES, **ARCHIVES_EVERYWHERE, "draft": native(2, (host_platform(),), level="draft")}
EXPORTS |= {f"stand-in-{fmi}": partial(export_stand_in, fmi=fmi) for fmi in VERSIONS}
