"""Compilation of C sources to the binaries of an FMU, for all platforms on any machine with the ziglang package.

Without ziglang the host's own C compiler builds for the host.  An installed package contains libraries for all
platforms.  Others are cached under the hash of all that determines them.  The same sources, compiler and target give
the same bytes.
"""

import importlib.util
import logging
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from fmu_src.native.mach_o import universal
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
    """Return the platforms of this machine: all with ziglang, else the compiler's, and those of the package."""
    return tuple(name for name in PLATFORMS if name in _compilable() | prebuilt_platforms(_PACKAGE))


def _compilable() -> set[str]:
    if importlib.util.find_spec("ziglang") is not None:
        return set(PLATFORMS)
    return {host_platform()} if kernels.find_compiler() else set()


def choose_platforms(names: Sequence[str] | None) -> tuple[str, ...]:
    """Choose the named platforms, or all with None; ValueError if there is none."""
    chosen = available_platforms() if names is None else tuple(names)
    if not chosen:
        raise ValueError(f"no platform to build for: install a C compiler; {CURE}")
    return chosen


def missing_platforms() -> str:
    """Return the platforms that cannot be built here, with the reason; '' if all can."""
    if not (missing := [name for name in PLATFORMS if name not in available_platforms()]):
        return ""
    compiler = kernels.find_compiler()
    why = (
        f"{Path(compiler[0]).name} builds for this machine only"
        if compiler
        else "there is no C compiler here"
    )
    return f"{', '.join(missing)}: {why}; {CURE}"


def binaries(
    sources: Mapping[str, str], model: str, fmi: int, platforms: Sequence[str], identifier: str
) -> dict[str, bytes]:
    """Return libraries by path in the FMU, made of the C files and headers in ``sources`` of the model."""
    built = {
        name: library(sources, model, name, f", FMI {fmi}.0").read_bytes() for name in platforms
    }
    paths: dict[str, bytes] = {}
    for name, code in built.items():
        folder = PLATFORMS[name].folder2 if fmi == 2 else name
        path = f"binaries/{folder}/{identifier}{PLATFORMS[name].suffix}"
        paths[path] = (
            universal([built[n] for n in built if PLATFORMS[n].folder2 == folder])
            if path in paths
            else code
        )
    return paths


def library(sources: Mapping[str, str], identifier: str, name: str, version: str = "") -> Path:
    """Return the library of an FMU for the platform ``name``: the package's, the cached one, or a compiled one.

    ``version`` is added to the message about the compilation.  ValueError if the library is not available here.
    """
    brought = prebuilt_file(_PACKAGE, sources, identifier, name)
    return brought if brought.exists() else _build(sources, identifier, name, version, *_HIDDEN)


def open_library(sources: Mapping[str, str], identifier: str, name: str) -> Path:
    """Return ``library`` for ctypes, with all functions of the sources visible."""
    return _build(sources, identifier, name, "")


def _build(
    sources: Mapping[str, str], identifier: str, name: str, version: str, *more: str
) -> Path:
    if name in prebuilt_platforms(_PACKAGE) and name not in _compilable():
        raise ValueError(
            f"the package has no compiled {identifier} for {name!r} of this structure (drives: up to 4 head rope "
            f"modes), and nothing here compiles it. {CURE}"
        )
    if name not in PLATFORMS or name not in _compilable():
        could = ", ".join(available_platforms()) or "none, without a C compiler"
        raise ValueError(f"the platform {name!r} cannot be built here; can be: {could}. {CURE}")
    compiler, flags = _compiler(), (*_flags(name), *more)
    objects = kernels.object_files(sources, compiler, flags, kernels.cache_folder())
    key = kernels.short_hash(identifier, *(file.name for file in objects.values()))
    target = kernels.cache_folder() / f"fmu-{name}-{key}{PLATFORMS[name].suffix}"

    def make() -> None:
        progress.warning("compiling %s for %s%s, up to a minute", identifier, name, version)
        more = (
            ["-ldl"]
            if name.endswith("linux") and any("<dlfcn.h>" in text for text in sources.values())
            else []
        )
        if name.endswith("linux") and "ziglang" in compiler:
            # zig's own library is not needed, and compiling it would take 14 s
            more += ["-nostdlib", "-lc", "-Wl,-z,defs"]
        kernels.compile_objects(sources, [*compiler, *flags], objects)
        own_name = (
            [f"-Wl,-install_name,@rpath/{identifier}{target.suffix}"]
            if target.suffix == ".dylib"
            else []
        )
        command = [*compiler, *flags, *own_name]
        kernels.link_library(
            command, objects.values(), target, f"{identifier}{target.suffix}", more
        )

    try:
        return kernels.make_once(target, make)
    except subprocess.CalledProcessError as error:
        raise RuntimeError(
            f"{' '.join([*compiler, *flags])} failed: {error.stderr[-2000:]}"
        ) from error


def _compiler() -> tuple[str, ...]:
    if importlib.util.find_spec("ziglang") is not None:
        return (sys.executable, "-m", "ziglang", "cc")
    return kernels.find_compiler() or ()


def _flags(name: str) -> tuple[str, ...]:
    target: tuple[str, ...] = ()
    if importlib.util.find_spec("ziglang") is not None:
        # link-time optimisation, where ziglang's linker supports it: a tenth faster
        target = "-target", PLATFORMS[name].target, *(("-flto",) if name.endswith("linux") else ())
    position = () if name.endswith("windows") else ("-fPIC",)
    return (
        *target,
        *FLAGS,
        *position,
        *(("-Wl,--build-id=none",) if name.endswith("linux") else ()),
    )
