"""The rope's FMUs wound in tools from the package index (see tool_driver for what each tool does)."""

import ctypes.util
import functools
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tool_driver
from exports import FLAVOURS, Flavour
from freed_blocks import freed_blocks
from numpy.typing import NDArray
from scenes import fixed_steps

from balance_rope import main
from rope_model.native.engine import NativeRope
from rope_model.parameters import rope_120
from rope_model.simulation.paths import EndMotion
from rope_model.simulation.simulator import RopeSimulator

WINDING = tool_driver.STEPS
SCENE = rope_120().scene.with_(solver=fixed_steps(tool_driver.H))
PART = 350  # steps, with two transformations
DRIVER = Path(tool_driver.__file__)
PACKAGES = {"fmpy": "fmpy", "libcosim": "libcosimpy", "ecos": "ecospy"}
#: versions of FMI that the tool imports
IMPORTS = {"fmpy": {2, 3}, "libcosim": {2}, "ecos": {2, 3}}


def environment() -> dict[str, str]:
    """Ecos finds libtbb in the environment's lib, where the package tbb puts it."""
    return {**os.environ, "LD_LIBRARY_PATH": str(Path(sysconfig.get_path("data")) / "lib")}


def require(tool: str) -> None:
    if importlib.util.find_spec(PACKAGES[tool]) is None:
        pytest.skip(f"{PACKAGES[tool]} is not installed; it has no wheel for this platform or Python")


def wind(tool: str, fmu: Path, reading: str, steps: int) -> NDArray[np.float64]:
    """(steps, 12) end forces and moments."""
    command = [sys.executable, str(DRIVER), tool, str(fmu), reading, str(steps)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, env=environment())
    said = done.stdout[-2000:] + done.stderr[-2000:]
    line = next((line for line in done.stdout.splitlines() if line.startswith("RESULT ")), None)
    assert line is not None, said
    assert done.returncode == 0, said
    return np.array(json.loads(line.removeprefix("RESULT ")))


@functools.cache
def in_process(native: bool, tool: str, reading: str, steps: int, lift: float = 0.0) -> NDArray[np.float64]:
    """The same by the rope in process, with the tool's clock, all of it ``lift`` (m) higher."""
    rope, rows = (NativeRope if native else RopeSimulator)(SCENE), []
    rope.initialize(0.0, *motions(0.0, lift))
    for k, (t, h) in enumerate(tool_driver.clock(tool, steps)):
        ends = motions((k + 1) * tool_driver.H, lift)
        if reading == "start":
            ends = [end.extrapolate(h) for end in motions(k * tool_driver.H, lift)]
        status = rope.advance_to(t + h, *ends)
        assert status.valid, status.message
        values = rope.signals(tool_driver.FORCES)
        rows.append([values[name] for name in tool_driver.FORCES])
    assert rope.state.counts.transformations > 0
    return np.array(rows)


def motions(t: float, lift: float = 0.0) -> list[EndMotion]:
    values = tool_driver.inputs(t)
    return [EndMotion(y=y + lift, vy=v, ay=a) for y, v, a in (values[:3], values[3:])]


def rounding(tool: str, reading: str, steps: int) -> NDArray[np.float64]:
    """(12,) what the last bits of the heights do to each force, as another compiler's may: the same higher up."""
    here, there = (in_process(True, tool, reading, steps, lift) for lift in (0.0, 7.3))
    return np.abs(here - there).max(axis=0)


@pytest.fixture(scope="module", params=sorted(FLAVOURS))
def exported(request: Any, fmu_of: Callable[[str], Path]) -> tuple[Flavour, Path]:
    return FLAVOURS[request.param], fmu_of(request.param)


@pytest.mark.parametrize(
    ("tool", "reading", "steps"),
    [
        ("fmpy", "start", PART),
        pytest.param("libcosim", "start", PART, marks=pytest.mark.slow),
        ("libcosim", "end", PART),
        ("ecos", "start", PART),
        pytest.param("ecos", "end", PART, marks=pytest.mark.slow),
        *(pytest.param(tool, "start", WINDING, marks=pytest.mark.slow) for tool in PACKAGES),
    ],
)
def test_forces_in_the_tool_are_those_of_the_rope_in_process(
    exported: tuple[Flavour, Path], tool: str, reading: str, steps: int
) -> None:
    flavour, fmu = exported
    require(tool)
    if flavour.fmi not in IMPORTS[tool]:
        pytest.skip(f"{tool} does not import FMI {flavour.fmi}")
    expected, found = in_process(flavour.native, tool, reading, steps), wind(tool, fmu, reading, steps)
    assert found.shape == expected.shape
    allowed = flavour.tolerance * np.maximum(np.abs(expected).max(axis=0), 1.0)
    if flavour.native:
        allowed = np.maximum(allowed, 3 * rounding(tool, reading, steps))
        assert (allowed < 1e-7 * np.maximum(np.abs(expected).max(axis=0), 1.0)).all()
    assert (np.abs(found - expected).max(axis=0) < allowed).all()


def simulate_without_python(flavour: Flavour, fmu: Path, folder: Path, *preloaded: Path) -> int:
    """Exit code of the program ecos, which leaves its record in ``folder``."""
    require("ecos")
    if sys.platform != "linux":
        pytest.skip("the command line of ecos is run on Linux only")
    # the wheel's program is not marked executable
    packaged = importlib.util.find_spec("ecospy")
    assert packaged is not None
    program = folder / "ecos"
    shutil.copy(Path(str(packaged.origin)).parent / "binaries" / "ecos", program)
    program.chmod(0o755)
    where, libraries = environment(), [str(library) for library in preloaded]
    if not flavour.native:
        # of several on this machine, the one that the packages are for
        library = ctypes.util.find_library(f"python{sys.version_info.major}.{sys.version_info.minor}")
        if library is None:
            pytest.skip("the Python FMU needs libpython preloaded, and this Python has no shared library")
        libraries.append(library)
        where["PYTHONPATH"] = os.pathsep.join(sys.path)
    if libraries:
        where["LD_PRELOAD"] = " ".join(libraries)
    # with fewer than ten steps this version of ecos divides by zero when it tells its progress
    command = [str(program), "simulate", "--path", str(fmu), "--stopTime", "0.2", "--stepSize", "0.01"]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env=where,
        cwd=folder,
        stdin=subprocess.DEVNULL,
    )
    print(done.stdout[-2000:] + done.stderr[-2000:])
    return done.returncode


def test_tool_without_python_runs_the_fmu(exported: tuple[Flavour, Path], tmp_path: Path) -> None:
    assert simulate_without_python(*exported, tmp_path) == 0
    written = next(tmp_path.rglob("*.csv")).read_text().splitlines()
    column = next(i for i, name in enumerate(written[0].split(",")) if "status.valid" in name)
    assert {line.split(",")[column].strip() for line in written[1:]} == {"1"}
    assert len(written) > 20


def test_tool_without_python_ends_without_use_of_freed_memory(exported: tuple[Flavour, Path], tmp_path: Path) -> None:
    assert simulate_without_python(*exported, tmp_path, freed_blocks(tmp_path)) == 0


@pytest.mark.skipif("native-2" not in FLAVOURS, reason="needs a C compiler")
def test_worked_programs_of_the_tools_page_print_what_it_says(tmp_path: Path) -> None:
    page = (Path(__file__).parent.parent / "docs" / "tools.md").read_text(encoding="utf-8")
    programs = [block.partition("```")[0] for block in page.split("```python\n")[1:]]
    assert len(programs) == 2
    (tmp_path / "build").mkdir()
    for tool, program in zip(("ecos", "libcosim"), programs, strict=True):
        require(tool)
        assert main(["export", "--native", "--platform", "host", "--ssp", "--out", str(tmp_path / "build")]) == 0
        command = [sys.executable, "-c", program]
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=120, check=False, env=environment(), cwd=tmp_path
        )
        assert "t = 25.00 s: left conveyance at 89.999 m, balance rope -8241 N" in done.stdout, done.stderr[-2000:]
