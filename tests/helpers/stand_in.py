"""A stand-in for the rope (tests/native/stand_in.c), and programs that live through an FMU's life."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import fmpy
import pytest
from checkout import NATIVE, ROOT
from signal_names import of_both_ends

from fmu_src.shell.build import PLATFORMS, host_platform
from fmu_src.shell.sources import HEADERS
from rope_model.codegen.interface_structures import interface_structures
from rope_model.codegen.tables import parameter_structures, signal_numbers

VERSIONS = (2, 3)
#: what is freed is filled, and what is written beside a block aborts when that is freed
CHECKED_HEAP = {
    "MALLOC_PERTURB_": "165",
    "MALLOC_CHECK_": "3",
    "LD_PRELOAD": "libc_malloc_debug.so.0",
}
#: platform -> what runs its programs here
RUNNERS = {
    host_platform(): (),
    "counted": (),
    "valgrind": ("valgrind", "--quiet", "--leak-check=full", "--error-exitcode=99"),
    "aarch64-linux": ("qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu"),
    "x86_64-windows": ("wine",),
    "sanitizers": (),
}
SANITIZED = ["-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover"]


def stand_in() -> dict[str, str]:
    files = (NATIVE / "stand_in.c", ROOT / "rope_model" / "csrc" / "rope.h")
    texts = {path.name: path.read_text(encoding="utf-8") for path in files}
    return texts | {
        "parameters.h": parameter_structures(),
        "interface_structures.h": interface_structures(),
        "signal_numbers.h": signal_numbers(),
    }


def live(fmu: Path, folder: Path, way: str) -> list[int]:
    """Allocations while stepping, in each of the lives of tests/native/life_cycle.c, run in one of RUNNERS.

    Two instances, states, refused calls, a failed initialisation, reset, all again.
    """
    runner = RUNNERS[way]
    if runner and shutil.which(runner[0]) is None:
        pytest.skip(f"needs {runner[0]}")
    name = host_platform()
    if way in PLATFORMS:
        name = way
    compiler = ["cc"]
    if way == "sanitizers":
        compiler += SANITIZED
    if name != host_platform():
        compiler = [
            sys.executable,
            "-m",
            "ziglang",
            "cc",
            "-target",
            PLATFORMS[name].target.replace("2.17", "2.31"),
        ]
    elif not name.endswith("linux") or shutil.which("cc") is None:
        pytest.skip("needs Linux and a C compiler")
    unzipped = Path(fmpy.extract(str(fmu), str(folder)))
    program = folder / "life.exe"
    source = str(NATIVE / "life_cycle.c")
    libraries = ["-lm"] if name.endswith("windows") else ["-ldl", "-lm"]
    command = [*compiler, "-std=gnu99", f"-I{HEADERS}", source, "-o", str(program), *libraries]
    subprocess.run(command, check=True)
    binary = (
        unzipped / "binaries" / PLATFORMS[name].folder2 / f"BalanceRope{PLATFORMS[name].suffix}"
    )
    if way == "sanitizers":
        files = map(str, sorted((unzipped / "sources").glob("*.c")))
        shared = [
            f"-I{HEADERS}",
            "-DFMI2_OVERRIDE_FUNCTION_PREFIX",
            "-DHAS_WIDE_FORMS=0",
            "-fPIC",
            "-shared",
            "-fvisibility=hidden",
            "-o",
            str(binary),
        ]
        subprocess.run([*compiler, "-std=gnu99", *shared, *files, "-lm"], check=True)
    description = fmpy.read_model_description(str(fmu))
    references = {v.name: str(v.valueReference) for v in description.modelVariables}
    given = [references[name] for name in of_both_ends("y", "vy", "ay")]
    command = [
        *runner,
        str(program),
        str(binary),
        description.guid,
        *given,
        references["status.warning"],
    ]
    environment = {**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": str(folder / "wine")}
    if way == host_platform():
        environment |= CHECKED_HEAP
    if way == "counted":
        counted = folder / "counted.so"
        source = NATIVE / "counted.c"
        subprocess.run(
            ["cc", "-shared", "-fPIC", "-O1", str(source), "-o", str(counted)], check=True
        )
        environment["LD_PRELOAD"] = str(counted)
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=600, check=False, env=environment
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return [int(line) for line in done.stdout.split()]
