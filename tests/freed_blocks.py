"""The library that makes any use of freed C++ memory fatal (native/freed_blocks.c)."""

import subprocess
import sys
from pathlib import Path

import pytest

from rope_model.numerics.kernels import find_compiler

SOURCE = Path(__file__).parent / "native" / "freed_blocks.c"


def freed_blocks(folder: Path) -> Path:
    """The library to preload; skips the test where there is no preloading or no compiler."""
    compiler = find_compiler()
    if sys.platform != "linux" or compiler is None:
        pytest.skip("preloads a library that is compiled here, on Linux")
    library = folder / "freed_blocks.so"
    command = [*compiler, "-std=c99", "-O1", "-fPIC", "-shared", str(SOURCE), "-o", str(library)]
    subprocess.run(command, check=True, capture_output=True)
    return library
