"""Compilation of C sources to the binaries of an FMU, with ziglang for all platforms.

Without ziglang the host's own C compiler builds for the host.  An installed package contains
libraries for all platforms.  Others are cached under the hash of all that determines them.  The
same sources, compiler and target give the same bytes.
"""

import importlib.util
import logging
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from fmu_src.shell.mach_o import universal
from rope_model import compiler as kernels
from rope_model.codegen.platforms import PLATFORMS as PLATFORMS
from rope_model.codegen.platforms import host_platform as host_platform
from rope_model.codegen.platforms import prebuilt_file, prebuilt_platforms

progress = logging.getLogger("balance_rope.progress")

_PACKAGE = Path(__file__).resolve().parent
CURE = "ziglang builds for all: pip install 'balance-rope[compiler]'"

FLAGS = ("-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno", "-shared", "-s")
#: an FMU exports only the functions of FMI; CasADi marks its own
_HIDDEN = ("-fvisibility=hidden", "-DCASADI_SYMBOL_EXPORT=")


def available_platforms() -> tuple[str, ...]:
    """Return the platforms for which libraries can be compiled here, or are in the package."""
    return tuple(name for name in PLATFORMS if name in _compilable() | prebuilt_platforms(_PACKAGE))


def _compilable() -> set[str]:
    if importlib.util.find_spec("ziglang") is not None:
        return set(PLATFORMS)
    if kernels.find_compiler():
        return {host_platform()}
    return set()


def choose_platforms(names: Sequence[str] | None) -> tuple[str, ...]:
    """Choose the named platforms, or all with None; ValueError if there is none."""
    chosen = available_platforms() if names is None else tuple(names)
    if not chosen:
        raise ValueError(f"no platform to build for: install a C compiler; {CURE}")
    return chosen


def missing_platforms() -> str | None:
    """Return the platforms that cannot be built here, with the reason; None if all can."""
    missing = [name for name in PLATFORMS if name not in available_platforms()]
    if not missing:
        return None
    reason = "there is no C compiler here"
    compiler = kernels.find_compiler()
    if compiler:
        reason = f"{Path(compiler[0]).name} builds for this machine only"
    return f"{', '.join(missing)}: {reason}; {CURE}"


def binaries(
    sources: Mapping[str, str], model: str, fmi: int, platforms: Sequence[str], identifier: str
) -> dict[str, bytes]:
    """Return libraries by path in the FMU, made of the ``sources`` of the model.

    In FMI 2.0 macOS has one folder for both processors, and so one library.
    """
    by_path: dict[str, list[bytes]] = {}
    for name in platforms:
        folder = PLATFORMS[name].folder2 if fmi == 2 else name
        path = f"binaries/{folder}/{identifier}{PLATFORMS[name].suffix}"
        code = library(sources, model, name, f", FMI {fmi}.0").read_bytes()
        by_path.setdefault(path, []).append(code)
    return {
        path: universal(codes) if len(codes) > 1 else codes[0] for path, codes in by_path.items()
    }


def library(sources: Mapping[str, str], identifier: str, name: str, version: str = "") -> Path:
    """Return the library of an FMU for the platform ``name``, installed, cached or compiled.

    ``version`` is added to the message about the compilation.  ValueError if the library is not
    available here.
    """
    prebuilt = prebuilt_file(_PACKAGE, sources, identifier, name)
    if prebuilt.exists():
        return prebuilt
    return _build(sources, identifier, name, version, *_HIDDEN)


def open_library(sources: Mapping[str, str], identifier: str, name: str) -> Path:
    """Return ``library`` for ctypes, with all functions of the sources visible."""
    return _build(sources, identifier, name, "")


def _build(
    sources: Mapping[str, str], identifier: str, name: str, version: str, *more: str
) -> Path:
    if name in prebuilt_platforms(_PACKAGE) and name not in _compilable():
        raise ValueError(
            f"the package has no compiled {identifier} for {name!r} of this structure "
            f"(drives: up to 4 head rope modes), and nothing here compiles it. {CURE}"
        )
    if name not in PLATFORMS or name not in _compilable():
        could = ", ".join(available_platforms()) or "none, without a C compiler"
        raise ValueError(f"the platform {name!r} cannot be built here; can be: {could}. {CURE}")
    compiler = _compiler()
    flags = (*_flags(name), *more)
    objects = kernels.object_files(sources, compiler, flags, kernels.cache_folder())
    key = kernels.short_hash(identifier, *(file.name for file in objects.values()))
    target = kernels.cache_folder() / f"fmu-{name}-{key}{PLATFORMS[name].suffix}"
    file_name = f"{identifier}{target.suffix}"

    def make() -> None:
        progress.warning("compiling %s for %s%s, up to a minute", identifier, name, version)
        kernels.compile_objects(sources, [*compiler, *flags], objects)
        command = [*compiler, *flags]
        if target.suffix == ".dylib":
            command.append(f"-Wl,-install_name,@rpath/{file_name}")
        libraries = _libraries(sources, compiler, name)
        kernels.link_library(command, objects.values(), target, file_name, libraries)

    try:
        return kernels.make_once(target, make)
    except subprocess.CalledProcessError as error:
        raise RuntimeError(
            f"{' '.join([*compiler, *flags])} failed: {error.stderr[-2000:]}"
        ) from error


def _libraries(sources: Mapping[str, str], compiler: Sequence[str], name: str) -> list[str]:
    """Return the linker's flags for libraries of the platform ``name``."""
    if not name.endswith("linux"):
        return []
    libraries = []
    if any("<dlfcn.h>" in text for text in sources.values()):
        libraries.append("-ldl")
    if "ziglang" in compiler:
        # zig's own library is not needed, and compiling it would take 14 s
        libraries += ["-nostdlib", "-lc", "-Wl,-z,defs"]
    return libraries


def _compiler() -> tuple[str, ...]:
    if importlib.util.find_spec("ziglang") is not None:
        return (sys.executable, "-m", "ziglang", "cc")
    return kernels.find_compiler() or ()


def _flags(name: str) -> tuple[str, ...]:
    linux = name.endswith("linux")
    flags: list[str] = []
    if importlib.util.find_spec("ziglang") is not None:
        flags += ["-target", PLATFORMS[name].target]
    flags += FLAGS
    if not name.endswith("windows"):
        flags.append("-fPIC")
    if linux:
        flags.append("-Wl,--build-id=none")
    return tuple(flags)
