"""C sources to the binaries of an FMU, for all platforms from any one machine with the ziglang package.

Without ziglang the host's own C compiler builds for the host.  Binaries are cached under the hash of all that goes
into them, and are the same bytes for the same sources, compiler and target.
"""

from __future__ import annotations

import hashlib
import importlib.util
import logging
import platform
import struct
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from rope_model.numerics.kernels import cache_folder, find_compiler

progress = logging.getLogger("balance_rope.progress")

FLAGS = ("-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno", "-fvisibility=hidden", "-shared", "-s")


class Platform(NamedTuple):
    """Name of the target for ziglang, of its folder in FMI 2.0, and ending of its libraries."""

    target: str
    folder2: str
    suffix: str


#: FMI 3.0's names of the platforms.  FMI 2.0 has none for aarch64: on Linux the name of FMI 3.0 serves there too, on
#: macOS the two processors share one library
PLATFORMS: dict[str, Platform] = {
    "x86_64-linux": Platform("x86_64-linux-gnu.2.17", "linux64", ".so"),
    "aarch64-linux": Platform("aarch64-linux-gnu.2.17", "aarch64-linux", ".so"),
    "x86_64-windows": Platform("x86_64-windows-gnu", "win64", ".dll"),
    "x86_64-darwin": Platform("x86_64-macos", "darwin64", ".dylib"),
    "aarch64-darwin": Platform("aarch64-macos", "darwin64", ".dylib"),
}
_PROCESSORS = {"amd64": "x86_64", "arm64": "aarch64"}


def host_platform() -> str:
    """FMI 3.0's name of the platform that this Python runs on."""
    processor = platform.machine().lower()
    return f"{_PROCESSORS.get(processor, processor)}-{'windows' if sys.platform == 'win32' else sys.platform}"


def available_platforms() -> tuple[str, ...]:
    """What can be built here: all with ziglang, the host's with another C compiler, else nothing."""
    if importlib.util.find_spec("ziglang") is not None:
        return tuple(PLATFORMS)
    return (host_platform(),) if find_compiler() and host_platform() in PLATFORMS else ()


def binaries(sources: Mapping[str, str], identifier: str, fmi: int, platforms: Sequence[str]) -> dict[str, bytes]:
    """Path in the FMU -> library, of the C files and headers in ``sources``."""
    built = {name: library(sources, identifier, name).read_bytes() for name in platforms}
    paths: dict[str, bytes] = {}
    for name, code in built.items():
        folder = PLATFORMS[name].folder2 if fmi == 2 else name
        path = f"binaries/{folder}/{identifier}{PLATFORMS[name].suffix}"
        paths[path] = universal([built[n] for n in built if PLATFORMS[n].folder2 == folder]) if path in paths else code
    return paths


def library(sources: Mapping[str, str], identifier: str, name: str) -> Path:
    """The compiled library for the platform ``name``; ValueError when it cannot be built here."""
    if name not in available_platforms():
        could = ", ".join(available_platforms()) or "none, without a C compiler"
        raise ValueError(
            f"the platform {name!r} cannot be built here; can be: {could}. "
            "The ziglang package builds for all: pip install ziglang"
        )
    command = _compiler(name)
    version = subprocess.run([*command[:3], "--version"], capture_output=True, text=True, check=False).stdout
    parts = [identifier, version, *command[1:], *(f"{key}\0{text}" for key, text in sorted(sources.items()))]
    key = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:20]
    made = cache_folder() / f"fmu-{name}-{key}{PLATFORMS[name].suffix}"
    if not made.exists():
        made.parent.mkdir(parents=True, exist_ok=True)
        progress.info("compiling %s for %s, some 10 s", identifier, name)
        with tempfile.TemporaryDirectory(dir=made.parent) as folder:
            _compile(command, sources, Path(folder), f"{identifier}{PLATFORMS[name].suffix}").replace(made)
    return made


def _compiler(name: str) -> list[str]:
    """The command that compiles for the platform, without the files."""
    flags = list(FLAGS)
    if not name.endswith("windows"):
        flags.append("-fPIC")
    if name.endswith("linux"):
        flags.append("-Wl,--build-id=none")
    if importlib.util.find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[name].target, *flags]
    return [*(find_compiler() or ()), *flags]


def _compile(command: Sequence[str], sources: Mapping[str, str], folder: Path, name: str) -> Path:
    for file, text in sources.items():
        (folder / file).write_text(text, encoding="utf-8", newline="\n")
    files = sorted(file for file in sources if file.endswith(".c"))
    more = [f"-Wl,-install_name,@rpath/{name}"] if name.endswith(".dylib") else []
    loader = ["-ldl"] if name.endswith(".so") and any("<dlfcn.h>" in text for text in sources.values()) else []
    # in the folder, by relative names: no path of this machine gets into the library
    done = subprocess.run(
        [*command, *more, *files, "-o", name, "-lm", *loader], cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)} failed: {done.stderr[-2000:]}")
    return folder / name


def universal(libraries: Sequence[bytes]) -> bytes:
    """One macOS library of several processors' (fat Mach-O: a table of offsets, then the libraries)."""
    page = 1 << 14
    table, body, offset = struct.pack(">II", 0xCAFEBABE, len(libraries)), b"", page
    for code in libraries:
        cpu, subtype = struct.unpack_from("<II", code, 4)
        table += struct.pack(">IIIII", cpu, subtype, offset, len(code), 14)
        padded = code + bytes(-len(code) % page)
        body, offset = body + padded, offset + len(padded)
    return table.ljust(page, b"\0") + body
