"""A hoist with several ropes that differ as one SSP: what is connected, how it moves, and what is refused."""

import zipfile
from pathlib import Path

import numpy as np
import pytest
from exports import FLAVOURS
from fmpy.ssp.ssd import read_ssd
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from test_ssp import wind as in_tool
from test_tools import require

from balance_rope import main
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import rope_parameters
from hoist_demo.parameters import Coupling
from hoist_demo.ropes.definition import read_ropes

STEPS = 500
ROPES = """
[ropes]
title = "Two ropes of which one is short"
case = "rope-120"
level = "draft"

[fixed]
model.fidelity = "torsional"
winding.travel = 20.0

[[rope]]
name = "sound"
z = -0.2

[[rope]]
name = "short"
z = 0.2
rope.length = 118.8
rope.Qb = -2.336e5
rope.Qc = -2.336e5
"""
SIGNALS = ("drive:left.y", "drive:right.y", "drive:drive.torque", "sound:left.fy", "short:left.fy", "short:right.fy")

pytestmark = pytest.mark.skipif("native-2" not in FLAVOURS, reason="needs a C compiler")


def export(folder: Path, text: str, *more: str) -> int:
    (folder / "ropes.toml").write_text(text, encoding="utf-8")
    arguments = ["--native", "--platform", "host", "--ropes", str(folder / "ropes.toml"), *more]
    return main(["export", *arguments, "--out", str(folder / "rope.fmu")])


@pytest.fixture(scope="module")
def ssp(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("ropes")
    assert export(folder, ROPES, "--ssp") == 0
    return folder / "rope.ssp"


def wind(tool: str, ssp: Path) -> NDArray[np.float64]:
    """(STEPS, SIGNALS)."""
    return in_tool(tool, ssp, STEPS, *SIGNALS)


def test_each_rope_pulls_at_an_input_of_its_own_and_all_follow_the_same_motion(ssp: Path) -> None:
    connections = read_ssd(str(ssp)).system.connections  # against the schema of SSP 1.0
    found = {(c.startElement, c.startConnector, c.endElement, c.endConnector) for c in connections}
    motions = [f"{side}.{name}" for side in ("left", "right") for name in ("y", "vy", "ay")]
    expected = {("drive", name, rope, name) for rope in ("sound", "short") for name in motions}
    for rope in ("sound", "short"):
        expected |= {(rope, f"{side}.fy_mean", "drive", f"{rope}.{side}.fy_mean") for side in ("left", "right")}
    assert found == expected
    with zipfile.ZipFile(ssp) as archive:
        assert {f"resources/{name}.fmu" for name in ("drive", "sound", "short")} < set(archive.namelist())


def test_system_of_ropes_moves_as_their_group_in_process(ssp: Path) -> None:
    found = wind("fmpy_adding", ssp)
    ropes = read_ropes(ssp.with_name("ropes.toml"), rope_parameters())
    host = Host(ropes.group(), ropes.hoist, ropes.run.winding, Coupling(scheme="impulse-preserving"), ropes.run.gains)
    recording = host.run().recording
    names = [
        "conveyance.left.y",
        "conveyance.right.y",
        "drive.torque",
        "sound.left.fy",
        "short.left.fy",
        "short.right.fy",
    ]
    expected = np.array([recording[name] for name in names]).T[1 : STEPS + 1]
    assert np.ptp(found[:, 0]) > 3.0
    assert abs(found[0, 4]) < 0.999 * abs(found[0, 3])
    scale = np.abs(expected).max(axis=0)
    # the host steps drive and ropes one after the other, the system at once with the motion extrapolated over 10 ms
    assert_allclose(found[:, :3] / scale[:3], expected[:, :3] / scale[:3], rtol=0.0, atol=1e-5)
    assert_allclose(found[:, 3:] / scale[3:], expected[:, 3:] / scale[3:], rtol=0.0, atol=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("tool", "oracle"), [("ecos", "fmpy_adding"), ("libcosim", "fmpy_counting")])
def test_tool_winds_the_ropes_as_a_loop_over_what_fmpy_read(ssp: Path, tool: str, oracle: str) -> None:
    require(tool)
    assert_allclose(wind(tool, ssp), wind(oracle, ssp), rtol=1e-13, atol=0.0)
