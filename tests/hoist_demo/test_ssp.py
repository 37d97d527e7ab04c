"""Hoist drive and one rope or several as one SSP, wound in tools (see ssp_driver for what each tool does)."""

import functools
import json
import subprocess
import sys
import zipfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import ssp_driver
from exports import FLAVOURS, NATIVE
from fmpy.ssp.ssd import read_ssd
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from rope_groups import rope_in_process, ropes_in
from systems import COUPLING, STOP, system
from tools import IMPORTS, INPUTS, environment, require

from fmu_src.shell.build import host_platform
from fmu_src.ssp import Component, System, SystemNumber, export_ssp
from hoist_demo.cases.case import HOISTS
from hoist_demo.cases.table import find_case
from hoist_demo.command_line.main import main
from hoist_demo.cosimulation.host import Host
from hoist_demo.drive_fmu.description import duration
from hoist_demo.export.system import RopeFmu, export_hoist
from hoist_demo.parameters import Coupling

PART = 800  # steps until it runs at full speed
STEPS = 2600  # of the trip of 90 m and its arrival
NAMES = [
    "conveyance.left.y",
    "conveyance.right.y",
    "conveyance.left.vy",
    "drive.torque",
    "left.fy",
    "right.fy",
]
TOOLS = [("ecos", "fmpy_adding"), ("libcosim", "fmpy_counting")]
FEW = 500  # steps of several ropes


#: the Python rope takes minutes for the winding; test_tools has it in the tools
@pytest.fixture(scope="module", params=NATIVE)
def ssp(
    request: Any, tmp_path_factory: pytest.TempPathFactory, fmu_of: Callable[[str], Path]
) -> Path:
    folder = tmp_path_factory.mktemp(request.param)
    return system(folder, fmu_of(request.param), fmu_of(f"drive-{FLAVOURS[request.param].fmi}"))


@functools.cache
def wind(tool: str, ssp: Path, steps: int = STEPS, *signals: str) -> NDArray[np.float64]:
    """(steps, signals)."""
    command = [sys.executable, str(Path(ssp_driver.__file__)), tool, str(ssp), str(steps), *signals]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=300, check=False, env=environment()
    )
    line = next((line for line in done.stdout.splitlines() if line.startswith("RESULT ")), None)
    assert line is not None, done.stdout[-2000:] + done.stderr[-2000:]
    return np.array(json.loads(line.removeprefix("RESULT ")))


@pytest.mark.parametrize(
    ("ssp", "tool", "oracle", "steps"),
    [
        # one tool for each version of FMI
        ("native-2", "libcosim", "fmpy_counting", PART),
        ("native-3", "ecos", "fmpy_adding", PART),
        pytest.param("native-2", "ecos", "fmpy_adding", PART, marks=pytest.mark.slow),
        *(
            pytest.param(kind, *tool, STEPS, marks=pytest.mark.slow)
            for kind in NATIVE
            for tool in TOOLS
        ),
    ],
    indirect=["ssp"],
)
@pytest.mark.skipif("native-3" not in FLAVOURS, reason="needs a C compiler")
def test_tool_winds_the_system_as_a_loop_over_what_fmpy_read(
    ssp: Path, tool: str, oracle: str, steps: int
) -> None:
    require(tool)
    if ssp.parent.name.startswith("native-3") and 3 not in IMPORTS[tool]:
        pytest.skip(f"{tool} does not import FMI 3")
    found = wind(tool, ssp, steps)
    expected = wind(oracle, ssp, steps)
    # the same calls in the same order
    assert_allclose(found, expected, rtol=1e-13, atol=0.0)


@functools.cache
def wound_in_process() -> NDArray[np.float64]:
    """(STEPS, NAMES)."""
    # the connections carry mean forces
    recording = (
        Host(rope_in_process("rope-120"), coupling=Coupling(scheme="impulse-preserving"))
        .run()
        .recording
    )
    return np.array([recording[name] for name in NAMES]).T[1 : STEPS + 1]


@pytest.mark.parametrize(
    "ssp", [pytest.param("native-2", marks=pytest.mark.slow), "native-3"], indirect=True
)
def test_system_moves_as_the_host_loop_in_process(ssp: Path) -> None:
    found = wind("fmpy_adding", ssp)
    expected = wound_in_process()
    assert found[-1, 0] == pytest.approx(90.0, abs=0.01)
    # the host steps drive and rope one after the other, the tools at once with the motion extrapolated over 10 ms:
    # the rest is the jerk, 0.5 m/s3 x H x a rope of 960 kg, and the waves that it raises
    scale = np.abs(expected).max(axis=0)
    assert_allclose(found[:, :4] / scale[:4], expected[:, :4] / scale[:4], rtol=0.0, atol=2e-6)
    assert_allclose(found[:, 4:] / scale[4:], expected[:, 4:] / scale[4:], rtol=0.0, atol=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize("ssp", ["native-2", "native-3"], indirect=True)
def test_fixed_step_master_reaches_the_stop_time_of_the_file(ssp: Path) -> None:
    found = wind("master", ssp)
    expected = wind("fmpy_adding", ssp)
    assert abs(len(found) - STOP / ssp_driver.H) <= 1
    assert_allclose(found[:STEPS], expected, rtol=0.0, atol=0.0)


#: hoist and trip of installed sizes: payload on one side, shaft, head rope modes, guides and their play
INSTALLED = {"kiruna-355": -40.0, "monopol-1000": 4.0, "four ropes": 4.0}


@pytest.mark.slow
@pytest.mark.skipif("native-3" not in FLAVOURS, reason="needs a C compiler")
@pytest.mark.parametrize("name", INSTALLED)
def test_system_of_an_installed_hoist_moves_as_the_host_loop_in_process(
    tmp_path: Path, name: str
) -> None:
    if name in HOISTS:
        case = find_case(name)
        members = ()
        rope = partial(rope_in_process, name)
    else:
        case = find_case("kiruna-355")
        path = tmp_path / "ropes.toml"
        head = 'name = "ropes"\nlike = "kiruna-355"\nlevel = "draft"'
        # of alternating lay beside the centres; the last is short
        ropes = [
            f"[[rope]]\nz = {0.3 * k}\nx_left = 0.1\nnumber = 1\nQb = {5e4 * (-1) ** k}"
            for k in range(4)
        ]
        path.write_text(
            "\n".join([head, 'model.fidelity = "torsional"', *ropes, "length = 391.0\n"]),
            encoding="utf-8",
        )
        read = ropes_in(path)
        case = replace(case, hoist=read.hoist)
        members = read.ropes
        rope = partial(getattr, read, "plant")
    case = replace(case, winding=replace(case.winding, travel=INSTALLED[name], settle=5.0))
    steps = round(duration(case.winding) / 0.005) - 200
    fmu = RopeFmu(fmi=3, platforms=(host_platform(),))
    ssp = export_hoist(tmp_path, case, members, fmu).system
    ends = [*map(".".join, product(("left", "right"), ("fy", "fx", "fz", "my")))]
    ropes = [one.name for one in members] or ["rope"]
    asked = [f"drive:{x}" for x in ("left.y", "right.y", "left.vy", "drive.torque")]
    asked += map(":".join, product(ropes, ends))
    names = NAMES[:4]
    if members:
        names += map(".".join, product(ropes, ends))
    else:
        names += ends
    found = []
    hosts = []
    for every, tool in ((1, "fmpy_5_ms"), (2, "fmpy_2.5_ms")):
        found.append(wind(tool, ssp, every * steps, *asked)[every - 1 :: every])
        coupling = Coupling(step=0.005 / every, scheme="impulse-preserving")
        run = Host(rope(), case.hoist, case.winding, coupling, gains=case.gains).run().recording
        hosts.append(np.array([run[x] for x in names]).T[every : every * steps + 1 : every])
    assert np.ptp(found[0][:, 0]) > 0.99 * abs(case.winding.travel)
    # held forces make the acceleration jump at the samples, and the tools extrapolate motions by a step: both couplings
    # are of first order, and a step of H errs by twice what H/2 changes
    error = sum(2.0 * np.abs(one - half).max(axis=0) for one, half in (found, hosts))
    scale = np.abs(hosts[0]).max(axis=0)
    assert (error[:5] < 0.02 * scale[:5]).all()
    assert (np.abs(found[0] - hosts[0]).max(axis=0) < error).all()


def test_structure_is_valid_ssp_and_connects_every_signal_of_both(ssp: Path) -> None:
    description = read_ssd(str(ssp))  # against the schema of SSP 1.0
    assert {c.startConnector for c in description.system.connections} == {
        *INPUTS,
        "left.fy_mean",
        "right.fy_mean",
    }
    with zipfile.ZipFile(ssp) as archive:
        assert archive.namelist() == [
            "SystemStructure.ssd",
            "resources/drive.fmu",
            "resources/rope.fmu",
        ]
        text = archive.read("SystemStructure.ssd").decode()
    assert '<ssd:DefaultExperiment startTime="0.0" stopTime="35.0">' in text


def test_system_of_ssp_2_has_the_types_of_fmi_3_and_names_the_statuses_of_its_data(
    tmp_path: Path, fmu_of
) -> None:
    """Against the schemas of SSP 2.0 and SSP Traceability 1.1, which pyssp-standard carries."""
    xmlschema = pytest.importorskip("xmlschema")
    schemas = Path(pytest.importorskip("pyssp_standard").__file__).parent / "resources"
    components = [
        Component("drive", fmu_of("drive-3"), {}),
        Component("rope", fmu_of("native-3"), COUPLING),
    ]
    data = [
        SystemNumber("rope.Qb", 2.3e5, "N.m", "published"),
        SystemNumber("hoist.sheave_radius", 1.25, "m", "assumed"),
    ]
    whole = System("Hoist", STOP, ssp_driver.H, version="2.0", data=data)
    made = export_ssp(tmp_path / "hoist.ssp", components, whole)
    with zipfile.ZipFile(made) as archive:
        archive.extractall(tmp_path)
    structure = tmp_path / "SystemStructure.ssd"
    statuses = tmp_path / "resources" / "data.srmd"
    xmlschema.XMLSchema(schemas / "ssp2" / "SystemStructureDescription.xsd").validate(structure)
    xmlschema.XMLSchema11(schemas / "SRMD11.xsd").validate(statuses)
    root = ElementTree.parse(structure).getroot()
    assert {one[0].tag.partition("}")[2] for one in root.iterfind(".//{*}Connector")} == {"Float64"}
    assert [one.get("source") for one in root.iterfind("{*}MetaData")] == ["resources/data.srmd"]
    told = {
        one.get("keyword"): one.text
        for one in ElementTree.parse(statuses).iterfind(".//{*}ClassificationEntry")
    }
    assert told == {one.name: one.status for one in data}


def test_same_fmus_give_the_same_bytes(ssp: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(tmp_path)
    rope = tmp_path / "resources" / "rope.fmu"
    drive = tmp_path / "resources" / "drive.fmu"
    assert system(tmp_path, rope, drive).read_bytes() == ssp.read_bytes()


ROPES = """
name = "Two ropes of which one is short"
like = "rope-120"
level = "draft"
model.fidelity = "torsional"
winding.travel = 20.0

[[rope]]
name = "sound"
z = -0.2

[[rope]]
name = "short"
z = 0.2
length = 118.8
Qb = -2.336e5
Qc = -2.336e5
"""
SIGNALS = (
    "drive:left.y",
    "drive:right.y",
    "drive:drive.torque",
    "sound:left.fy",
    "short:left.fy",
    "short:right.fy",
)


def export(folder: Path, text: str, *more: str) -> int:
    (folder / "ropes.toml").write_text(text, encoding="utf-8")
    arguments = [str(folder / "ropes.toml"), "--native", "--platform", "host", *more]
    return main(["export", *arguments, "--out", str(folder / "rope.fmu")])


@pytest.fixture(scope="module")
def ropes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if "native-2" not in FLAVOURS:
        pytest.skip("needs a C compiler")
    folder = tmp_path_factory.mktemp("ropes")
    assert export(folder, ROPES, "--ssp") == 0
    return folder / "rope.ssp"


def test_each_rope_pulls_at_an_input_of_its_own_and_all_follow_the_same_motion(ropes: Path) -> None:
    connections = read_ssd(str(ropes)).system.connections  # against the schema of SSP 1.0
    found = {(c.startElement, c.startConnector, c.endElement, c.endConnector) for c in connections}
    motions = [*map(".".join, product(("left", "right"), ("y", "vy", "ay")))]
    expected = set()
    for rope in ("sound", "short"):
        expected |= {("drive", name, rope, name) for name in motions}
        expected |= {
            (rope, f"{side}.fy_mean", "drive", f"{rope}.{side}.fy_mean")
            for side in ("left", "right")
        }
    assert found == expected
    with zipfile.ZipFile(ropes) as archive:
        assert {f"resources/{name}.fmu" for name in ("drive", "sound", "short")} < set(
            archive.namelist()
        )


@pytest.mark.slow
def test_system_of_ropes_moves_as_their_group_in_process(ropes: Path) -> None:
    found = wind("fmpy_adding", ropes, FEW, *SIGNALS)
    read = ropes_in(ropes.with_name("ropes.toml"))
    host = Host(
        read.plant,
        read.hoist,
        read.run.winding,
        Coupling(scheme="impulse-preserving"),
        read.run.gains,
    )
    recording = host.run(lambda _, t: t < (FEW + 1) * ssp_driver.H).recording
    names = ["conveyance.left.y", "conveyance.right.y", "drive.torque"]
    names += ["sound.left.fy", "short.left.fy", "short.right.fy"]
    expected = np.array([recording[name] for name in names]).T[1 : FEW + 1]
    assert np.ptp(found[:, 0]) > 3.0
    assert abs(found[0, 4]) < 0.999 * abs(found[0, 3])
    scale = np.abs(expected).max(axis=0)
    # the host steps drive and ropes one after the other, the system at once with the motion extrapolated over 10 ms
    assert_allclose(found[:, :3] / scale[:3], expected[:, :3] / scale[:3], rtol=0.0, atol=1e-5)
    assert_allclose(found[:, 3:] / scale[3:], expected[:, 3:] / scale[3:], rtol=0.0, atol=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("tool", "oracle"), TOOLS)
def test_tool_winds_the_ropes_as_a_loop_over_what_fmpy_read(
    ropes: Path, tool: str, oracle: str
) -> None:
    require(tool)
    found, expected = (wind(x, ropes, FEW, *SIGNALS) for x in (tool, oracle))
    assert_allclose(found, expected, rtol=1e-13, atol=0.0)
