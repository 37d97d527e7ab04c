"""The drive's libraries for other platforms, run here in emulators by a small host in C.

Its outputs must be those of this platform's library.  Linux on aarch64 runs under qemu's user emulation with the C
library of Debian's libc6-arm64-cross, Windows under wine.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from exports import export_drive
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scenes import ends_at
from stand_in import RUNNERS

from fmu_src.native.build import PLATFORMS, host_platform
from fmu_src.native.export import header_folder
from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import s_curve

ROOT = Path(__file__).resolve().parent.parent
STEPS = 1000
H = 0.01  # s
OUTPUTS = ("left.y", "left.vy", "left.ay", "drive.torque", "left.fy", "right.fy", "left.mx", "loop.y", "loop.yaw")


def run(fmu: Path, platform: str) -> NDArray[np.float64]:
    """Outputs (STEPS, outputs) of the library for ``platform`` in the first 10 s of the 120 m winding."""
    with tempfile.TemporaryDirectory() as name, zipfile.ZipFile(fmu) as archive:
        folder, target = Path(name), PLATFORMS[platform]
        described = ElementTree.fromstring(archive.read("modelDescription.xml"))
        path = f"binaries/{target.folder2}/{described.find('CoSimulation').get('modelIdentifier')}{target.suffix}"
        library = folder / Path(path).name
        library.write_bytes(archive.read(path))
        command = [*RUNNERS[platform], _compile(folder, platform), f"./{library.name}", described.get("guid")]
        # wine keeps its settings in the folder as well
        where = {**os.environ, "WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all"}
        options = {"input": script(described), "capture_output": True, "text": True, "check": False}
        done = subprocess.run(list(map(str, command)), cwd=folder, env=where, **options)
    assert done.returncode == 0, done.stderr[-500:]
    return np.array([float.fromhex(line) for line in done.stdout.split()]).reshape(STEPS, -1)


def script(described: ElementTree.Element) -> str:
    """Commands for foreign_host: the rope follows the reference, the drive runs under the forces at the start."""
    references = {str(v.get("name")): v.get("valueReference") for v in described.iter("ScalarVariable")}
    outputs = {v.get("name") for v in described.iter("ScalarVariable") if v.get("causality") == "output"}
    reference = s_curve(find_case("rope-120").winding)
    lines = []
    if "inputs_at_step_end" in references:
        lines.append(f"b {references['inputs_at_step_end']} 1")
    lines.append("i")
    for k in range(STEPS):
        if "left.y" not in outputs:
            for side, end in zip(("left", "right"), ends_at(reference, 90.0, (k + 1) * H), strict=True):
                values = {"y": end.y, "vy": end.vy, "ay": end.ay}
                lines += [f"r {references[f'{side}.{name}']} {value!r}" for name, value in values.items()]
        lines.append(f"s {k * H!r} {H!r}")
        lines += [f"g {references[name]}" for name in OUTPUTS if name in outputs]
    return "\n".join(lines) + "\n"


def _compile(folder: Path, platform: str) -> Path:
    host = folder / ("host.exe" if platform.endswith("windows") else "host")
    compiler = [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[platform].target, "-std=c99", "-O1"]
    source = ROOT / "tests" / "native" / "foreign_host.c"
    libraries = [] if platform.endswith("windows") else ["-ldl"]
    subprocess.run([*compiler, f"-I{header_folder()}", str(source), "-o", str(host), *libraries], check=True)
    return host


@pytest.mark.slow
@pytest.mark.parametrize("platform", ["aarch64-linux", "x86_64-windows"])
def test_library_in_the_emulator_gives_the_values_of_this_platform(platform: str, tmp_path: Path) -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("ziglang is not installed: pip install ziglang")
    if shutil.which(RUNNERS[platform][0]) is None:
        pytest.skip(f"no emulator for {platform}: apt-get install qemu-user-static libc6-arm64-cross, or wine")
    drive = export_drive(tmp_path / "drive.fmu", (host_platform(), platform))
    expected, found = run(drive, host_platform()), run(drive, platform)
    # only tanh may round otherwise, in another C library
    assert_allclose(found, expected, rtol=0, atol=1e-14 * np.maximum(np.abs(expected).max(axis=0), 1e-12))
