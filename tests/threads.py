"""A host in C (tests/native/threads.c) in which threads instantiate and step an FMU of the rope at once."""

from __future__ import annotations

import ctypes.util
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import fmpy
from native_host import SMALL

from fmu_src.native.export import header_folder

ROOT = Path(__file__).resolve().parent.parent
THREADS, STEPS = 16, 10
OUTPUTS = ("left.fy", "right.mx", "loop.y", "energy.kinetic")


def why_not() -> str:
    if sys.platform != "linux" or shutil.which("cc") is None:
        return "needs Linux and a C compiler"
    return "" if _python() else "needs this Python's shared library"


def _python() -> str | None:
    return ctypes.util.find_library(f"python{sys.version_info.major}.{sys.version_info.minor}")


def build(folder: Path, flags: Sequence[str] = ()) -> Path:
    program, here = folder / "threads", ROOT / "tests" / "native"
    command = ["cc", "-std=gnu99", "-O1", *flags, f"-I{header_folder()}", here / "threads.c", "-o", program]
    subprocess.run([*command, "-ldl", "-lm", "-lpthread"], check=True)
    return program


def run(program: Path, fmu: Path, unzipped: Path, threads: int = THREADS) -> subprocess.CompletedProcess[str]:
    """One run, in a process of its own; a Python FMU finds the packages that this one has."""
    description = fmpy.read_model_description(str(fmu))
    variables = {v.name: v for v in description.modelVariables}
    given = [(variables[name], value) for name, value in SMALL.items()]
    entries = [f"{v.type[0].lower()}:{v.valueReference}:{value}" for v, value in given]
    motion = [variables[f"left.{name}"].valueReference for name in ("y", "vy", "ay")]
    outputs = [variables[name].valueReference for name in OUTPUTS]
    binary = next((unzipped / "binaries").rglob("BalanceRope.so"))
    resources = (unzipped / "resources").resolve().as_uri()
    command = [program, binary, description.guid, resources, threads, STEPS, *motion, *entries, "--", *outputs]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONHOME"}
    environment |= {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "LD_PRELOAD": _python() or ""}
    environment |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = list(map(str, command))
    return subprocess.run(command, capture_output=True, text=True, timeout=600, check=False, env=environment)
