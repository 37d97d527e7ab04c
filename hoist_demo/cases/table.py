"""Hoists by name, the files of hoist_demo/cases/hoists, and those of the user by path."""

from functools import cache
from pathlib import Path

from hoist_demo.cases.case import BUILTIN_HOISTS, DEFAULT_HOIST, Case
from hoist_demo.cases.hoist_file import HoistFile, read_builtin
from hoist_demo.files.reading import read

NATIVE_ENDING = "_native"  #: End of the name of a native FMU of FMI 2.0.
BUILD = Path("build")  #: Folder of exported FMUs.


def fmu_name(hoist: str, end: str = "") -> str:
    """Return the name of the rope's FMU: the hoist's; balance_rope for the default hoist."""
    stem = "balance_rope" if hoist == DEFAULT_HOIST else Path(hoist).stem
    return f"{stem}{end}.fmu"


#: FMU that is wound where it is there and nothing else is asked for.
DEFAULT_FMU = BUILD / fmu_name(DEFAULT_HOIST, NATIVE_ENDING)


def find_case(name: str) -> Case:
    """Return the hoist of a file, or of this name; ValueError with all names when there is none."""
    if name in BUILTIN_HOISTS:
        return read_builtin(name).case
    if name.endswith(".toml"):
        path = Path(name)
        changed = path.stat().st_mtime_ns if path.is_file() else 0
        return _read(path, changed)
    raise ValueError(
        f"hoist = {name!r} must be a file, NAME.toml, or one of {', '.join(BUILTIN_HOISTS)}: "
        "choose one"
    )


@cache
def _read(path: Path, _changed: int) -> Case:
    return read(path, HoistFile).case
