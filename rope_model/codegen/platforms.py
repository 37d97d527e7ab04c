"""Platforms of native code, and the libraries for them in an installed package.

A library in the package has the hash of its sources in its name and is used for these sources only.
A checkout has none.
"""

import platform
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from rope_model.compiler import short_hash


class Platform(NamedTuple):
    """Target of ziglang, folder in FMI 2.0, and suffix of libraries."""

    target: str
    folder2: str
    suffix: str


MACOS = "11.0"  #: Oldest version of macOS on which libraries load, the first for both processors.
#: platforms by their names in FMI 3.0. FMI 2.0 has none for aarch64: on Linux it takes the name of
#: FMI 3.0, on macOS both processors share one library
PLATFORMS: dict[str, Platform] = {
    "x86_64-linux": Platform("x86_64-linux-gnu.2.17", "linux64", ".so"),
    "aarch64-linux": Platform("aarch64-linux-gnu.2.17", "aarch64-linux", ".so"),
    "x86_64-windows": Platform("x86_64-windows-gnu", "win64", ".dll"),
    "x86_64-darwin": Platform(f"x86_64-macos.{MACOS}", "darwin64", ".dylib"),
    "aarch64-darwin": Platform(f"aarch64-macos.{MACOS}", "darwin64", ".dylib"),
}
_PROCESSORS = {"amd64": "x86_64", "arm64": "aarch64"}
_SYSTEMS = {"win32": "windows"}


def host_platform() -> str:
    """Return FMI 3.0's name of the platform that this Python runs on."""
    processor = platform.machine().lower()
    return f"{_PROCESSORS.get(processor, processor)}-{_SYSTEMS.get(sys.platform, sys.platform)}"


def prebuilt_file(package: Path, sources: Mapping[str, str], identifier: str, name: str) -> Path:
    """Return the path in ``package`` of the library of these sources (text by file name) for the platform ``name``."""
    key = short_hash(*(part for item in sorted(sources.items()) for part in item))
    suffix = PLATFORMS[name].suffix if name in PLATFORMS else ""
    return package / "prebuilt" / f"{identifier}-{name}-{key}{suffix}"


def prebuilt_platforms(package: Path) -> set[str]:
    """Return the platforms for which ``package`` contains libraries."""
    files = [path.name for path in (package / "prebuilt").glob("*")]
    return {name for name in PLATFORMS if any(f"-{name}-" in file for file in files)}


def text_hash(package: Path) -> str:
    """Return the hash of a package's Python text; generated files belong to one hash."""
    files = sorted(package.rglob("*.py"))
    return short_hash(
        *(
            x
            for f in files
            for x in (f.relative_to(package).as_posix(), f.read_text(encoding="utf-8"))
        )
    )
