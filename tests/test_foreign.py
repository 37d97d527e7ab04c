"""The drive's libraries for other platforms in emulators, where there are any (foreign_platforms tells which)."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from exports import export_drive
from foreign_platforms import emulator, run
from numpy.testing import assert_allclose

from fmu_src.native.build import host_platform


@pytest.mark.slow
@pytest.mark.parametrize("platform", ["aarch64-linux", "x86_64-windows"])
def test_library_in_the_emulator_gives_the_values_of_this_platform(platform: str, tmp_path: Path) -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("ziglang is not installed: pip install ziglang")
    if emulator(platform) is None:
        pytest.skip(f"no emulator for {platform}: apt-get install qemu-user-static libc6-arm64-cross, or wine64")
    drive = export_drive(tmp_path / "drive.fmu", (host_platform(), platform))
    expected, found = run(drive, host_platform()), run(drive, platform)
    # only tanh may round otherwise, in another C library
    assert_allclose(found, expected, rtol=0, atol=1e-14 * np.maximum(np.abs(expected).max(axis=0), 1e-12))
