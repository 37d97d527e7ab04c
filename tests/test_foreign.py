"""The drive's libraries for other platforms in emulators, where there are any (foreign_platforms tells which)."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
from exports import export_drive
from foreign_platforms import difference, emulator, run

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
    assert found.values is not None, found.reason
    assert expected.values is not None, expected.reason
    # only tanh may round otherwise, in another C library
    assert difference(found, expected) < 1e-14
