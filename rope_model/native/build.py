"""The native rope's C sources, complete, and the library they make."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from ..numerics.kernels import cache_folder, compile_library, find_compiler
from .elements import element_code
from .tables import signal_numbers

_FOLDER = Path(__file__).resolve().parent


@cache
def sources() -> dict[str, str]:
    """Text by file name: what is written by hand, and what is generated from the element and the table of signals."""
    written = {
        p.name: p.read_text(encoding="utf-8") for p in sorted(_FOLDER.iterdir()) if p.suffix in (".c", ".h", ".inc")
    }
    return written | {"elements.inc": element_code(), "signal_numbers.h": signal_numbers()}


@cache
def library() -> Path:
    """The compiled library, from the cache of kernels when it is there.

    Raises RuntimeError without a C compiler, CalledProcessError when that fails.
    """
    if (compiler := find_compiler()) is None:
        raise RuntimeError("the native rope needs a C compiler; install one, or the ziglang package")
    return compile_library(sources(), compiler, cache_folder(), "rope")
