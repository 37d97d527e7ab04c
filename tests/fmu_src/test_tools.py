"""The rope's FMUs in tools from the package index; ssp_driver winds hoist and rope as a system in ecos and libcosim."""

import ctypes.util
import importlib.util
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from checkout import NATIVE, ROOT
from exports import FLAVOURS, Flavour
from lxml import etree
from native_host import OK, Host
from numpy.testing import assert_allclose
from scenes import ends_at, fixed_steps
from tools import INPUTS, environment, require

from fmu_src.interface import case_with
from hoist_demo.command_line.main import main
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding
from rope_model import BalanceRope, EndMotion, balance_rope, rope_120
from rope_model.compiler import find_compiler
from rope_model.engine import NativeRope
from rope_model.reference.rope import ReferenceRope

H = 0.01
TRAVEL = 90.0
REFERENCE = s_curve(Winding(travel=TRAVEL, start_delay=0.0))
PART = 400  # steps, with a transformation
WINDING = round((REFERENCE.duration + 1.0) / H)
SIDES = ("left", "right")
FORCES = [*map(".".join, product(SIDES, ("fx", "fy", "fz", "mx", "my", "mz")))]


#: the rope in Python takes ten times as long; test_rope_fmu compares it with the rope in process
WITH_PYTHON_SLOW = [
    pytest.param(x, marks=[pytest.mark.slow] * (x == "python")) for x in sorted(FLAVOURS)
]


def run(
    command: list[str], where: dict[str, str], folder: Path
) -> subprocess.CompletedProcess[str]:
    files: Any = {"cwd": folder, "stdin": subprocess.DEVNULL}
    return subprocess.run(
        command, capture_output=True, text=True, timeout=120, check=False, env=where, **files
    )


@pytest.fixture(scope="module", params=sorted(FLAVOURS))
def exported(request: Any, fmu_of: Callable[[str], Path]) -> tuple[Flavour, Path]:
    return FLAVOURS[request.param], fmu_of(request.param)


def in_process(native: bool, steps: int, lift: float = 0.0) -> np.ndarray:
    """(steps, 12) end forces and moments of the rope in process, all of it ``lift`` (m) higher."""
    scene = rope_120().scene.with_(solver=fixed_steps(H))
    rope: BalanceRope = ReferenceRope(scene)
    if native:
        rope = NativeRope(scene)
    rows = []

    def ends(t: float) -> list:
        return [replace(end, y=end.y + lift) for end in ends_at(REFERENCE, TRAVEL, t)]

    rope.initialize(0.0, *ends(0.0))
    for k in range(steps):
        h = (k + 1) * H - k * H
        assert rope.advance_to(k * H + h, *ends(k * H), k * H).valid
        rows.append([*rope.signals(FORCES).values()])
    assert rope.state.counts.transformations > 0
    return np.array(rows)


@pytest.mark.parametrize("exported", WITH_PYTHON_SLOW, indirect=True)
@pytest.mark.parametrize("steps", [PART, pytest.param(WINDING, marks=pytest.mark.slow)])
def test_forces_in_fmpy_are_those_of_the_rope_in_process(
    exported: tuple[Flavour, Path], steps: int
) -> None:
    """simulate_fmu sets the inputs of t_k and steps to t_k + H: it has no inputs of a step's end."""
    flavour, fmu = exported
    times = H * np.arange(steps + 1)
    motions = [input_values(*ends_at(REFERENCE, TRAVEL, t)) for t in times]
    signals = np.rec.fromarrays([times, *np.array(motions).T], names=["time", *INPUTS])
    start = {"solver.step_max": H, "solver.tolerance": 1e6}
    times_of: dict[str, float] = {"stop_time": steps * H, "output_interval": H}
    result = fmpy.simulate_fmu(
        str(fmu), start_values=start, input=signals, output=FORCES, **times_of
    )
    found = np.array([list(row)[1:] for row in result[1:]])
    expected = in_process(flavour.native, steps)
    largest = np.maximum(np.abs(expected).max(axis=0), 1.0)
    allowed = flavour.tolerance * largest
    if flavour.native:
        # what the last bits of the heights do to each force, as another compiler's may: the same higher up
        allowed = np.maximum(
            allowed, 3 * np.abs(expected - in_process(True, steps, 7.3)).max(axis=0)
        )
        assert (allowed < 1e-7 * largest).all()
    assert (np.abs(found - expected).max(axis=0) < allowed).all()


#: the head of a manifest by FMPy's copy of the FMI 3.0 schema; what is in it has the tables of FMI-LS-REF below
MANIFEST = """<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema" xmlns:ls="http://fmi-standard.org/fmi-ls-manifest">
<xs:import namespace="http://fmi-standard.org/fmi-ls-manifest" schemaLocation="{}"/>
<xs:element name="fmiReferences"><xs:complexType>
<xs:sequence><xs:any processContents="skip" maxOccurs="unbounded"/></xs:sequence>
<xs:attributeGroup ref="ls:ALayeredStandardManifest"/></xs:complexType></xs:element></xs:schema>"""
LAYER = "org.fmi-standard.fmi-ls-ref"


@pytest.mark.parametrize("exported", WITH_PYTHON_SLOW, indirect=True)
def test_fmpy_meets_the_reference_experiment_inside(
    exported: tuple[Flavour, Path], tmp_path: Path
) -> None:
    with zipfile.ZipFile(exported[1]) as archive:
        archive.extractall(tmp_path)
    folder = tmp_path / "extra" / LAYER
    schemas = Path(fmpy.__file__).with_name("schema") / "fmi3"
    manifest = etree.parse(folder / "fmi-ls-manifest.xml")
    etree.XMLSchema(
        etree.XML(MANIFEST.format(schemas / "fmi3LayeredStandardManifest.xsd"))
    ).assertValid(manifest)
    assert manifest.getroot().get("{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-name") == LAYER
    (related,) = manifest.getroot()
    kinds = {"type": "application/x-ma-ls-experiments", "role": "experiment/smoke-test"}
    assert (related.tag, related.attrib) == ("Related", {**kinds, "source": "BalanceRope.exp"})
    experiments = etree.parse(folder / related.get("source")).getroot()
    (experiment,) = experiments
    assert (experiments.tag, {*experiments.attrib}, experiment.tag) == (
        "Experiments",
        {"name"},
        "Experiment",
    )
    start, stop, step, tolerance = (
        float(experiment.get(name)) for name in ("startTime", "stopTime", "stepSize", "tolerance")
    )
    assert {*experiment.attrib} == {
        "name",
        "description",
        "startTime",
        "stopTime",
        "stepSize",
        "tolerance",
    }
    assert [(one.tag, [*one.attrib]) for one in experiment] == [
        ("Stimuli", ["source"]),
        ("References", ["source"]),
    ]
    stimuli, expected = (fmpy.read_csv(folder / one.get("source")) for one in experiment)
    outputs = expected.dtype.names[1:]
    times: dict[str, float] = {"start_time": start, "stop_time": stop, "output_interval": step}
    result = fmpy.simulate_fmu(str(exported[1]), input=stimuli, output=outputs, **times)
    for name in ("time", *outputs):
        # a hundredth of the relative tolerance: this is the machine that computed the references
        assert_allclose(
            result[name], expected[name], rtol=0.01 * tolerance, atol=tolerance, err_msg=name
        )


# equal steps, whatever their error: the instants of the events are the claim
EVENTS = {
    "solver.step_max": 0.005,
    "solver.tolerance": 1e6,
    "rope.installed_twist": 2.0,
    "sump.level": -14.3,
    "left.swivel.mode": 2,
    "left.swivel.start": 0,
    "left.swivel.release_time": 0.133,
    "guard.torque": 0.5,
    "guard.torque_delay": 0.08,
}
STEP = 0.05
STARTS = [STEP * k for k in range(10)]


def falling_ends(t: float) -> tuple[EndMotion, EndMotion]:
    y = -t * t - 0.05 * t**3
    vy = -2.0 * t - 0.15 * t * t
    ay = -2.0 - 0.3 * t
    return EndMotion(y=y, vy=vy, ay=ay), EndMotion(y=90.0 + y, vy=vy, ay=ay)


def input_values(left: EndMotion, right: EndMotion) -> list[float]:
    """Return values in the order of INPUTS."""
    return [left.y, left.vy, left.ay, right.y, right.vy, right.ay]


def falling(t: float) -> dict[str, float]:
    return dict(zip(INPUTS, input_values(*falling_ends(t)), strict=True))


@pytest.mark.skipif("native-3" not in FLAVOURS, reason="needs a C compiler")
def test_event_mode_returns_at_each_event_and_takes_motions_that_are_held_through_it(
    unpacked: Any,
) -> None:
    """Release, slips and sticks of a swivel, a guard's trip, a strike; over steps that are long beside them."""

    def run(events: bool, given: int = 0) -> tuple[list[float], list[float]]:
        rope = Host(*unpacked("native-3"), events=events)
        returned = list[float]()
        answers = [ctypes.c_bool()] * 5
        rope.start(**EVENTS | {"inputs.given": given})
        for t in STARTS:
            assert rope.give(falling(t)) == rope.do_step(t, STEP) == OK, rope.said
            while (now := rope.reached.value) < t + STEP - 1e-9:
                returned.append(now)
                assert rope.call("EnterEventMode") == OK, rope.said
                assert (
                    rope.call(
                        "UpdateDiscreteStates", *map(ctypes.byref, [*answers, ctypes.c_double()])
                    )
                    == OK
                )
                state = rope.state()
                for _ in range(2):  # a host may repeat a step
                    assert (
                        rope.restore(state)
                        == rope.call("EnterStepMode")
                        == rope.do_step(now, t + STEP - now)
                        == OK
                    )
                rope.forget(state)
        found = rope.get(
            "inputs.repeated",
            "inputs.misfit.acceleration",
            "left.fy",
            "right.fy",
            "left.swivel.angle",
        )
        rope.free()
        return returned, found

    happened = {EVENTS["left.swivel.release_time"]}
    rope = balance_rope(case_with("rope-120", "standard", EVENTS).scene)
    assert rope.initialize(0.0, EndMotion(ay=-2.0), EndMotion(y=90.0, ay=-2.0)).valid
    for t in STARTS:
        assert rope.advance_to(t + STEP, *falling_ends(t), t).valid
        happened |= {event.t for event in rope.state.events if event.what.startswith(SIDES)}
    happened |= {rope.state.guard.time, *(near.touched_at for near in rope.state.nearest)} - {0.0}
    none, plain = run(events=False)
    times, early = run(events=True)
    assert none == []
    assert_allclose(times, sorted(happened), rtol=0, atol=1e-4)
    assert plain[0] == early[0] == 0
    assert max(plain[1], early[1]) < 1e-3 * 9.81  # none that is told
    assert_allclose(early[2:], plain[2:], rtol=2e-3)
    rope = Host(*unpacked("native-3"), events=True)
    rope.start(**EVENTS | {"left.swivel.mode": 1, "left.swivel.release_time": STEP})
    assert rope.give(falling(0.0)) == rope.do_step(0.0, STEP) == OK, rope.said
    assert_allclose(
        rope.get("left.swivel.torque"), 0.0, atol=1e-9
    )  # released at the end of the step, in which it held
    rope.free()
    assert_allclose(
        run(events=True, given=2)[1][2:4], run(events=False, given=2)[1][2:4], rtol=2e-2
    )


def simulate_without_python(flavour: Flavour, fmu: Path, folder: Path) -> int:
    require("ecos")
    if sys.platform != "linux":
        pytest.skip("the command line of ecos is run on Linux only")
    # the wheel's program is not marked executable
    packaged = importlib.util.find_spec("ecospy")
    assert packaged is not None
    program = folder / "ecos"
    shutil.copy(Path(str(packaged.origin)).parent / "binaries" / "ecos", program)
    program.chmod(0o755)
    where = environment()
    libraries = freed_blocks(folder)
    if not flavour.native:
        # of several on this machine, the one that the packages are for
        library = ctypes.util.find_library(
            f"python{sys.version_info.major}.{sys.version_info.minor}"
        )
        if library is None:
            pytest.skip(
                "the Python FMU needs libpython preloaded, and this Python has no shared library"
            )
        libraries.append(library)
        where["PYTHONPATH"] = os.pathsep.join(sys.path)
    where["LD_PRELOAD"] = " ".join(libraries)
    # with fewer than ten steps this version of ecos divides by zero when it tells its progress
    command = [
        str(program),
        "simulate",
        "--path",
        str(fmu),
        "--stopTime",
        "0.2",
        "--stepSize",
        "0.01",
    ]
    done = run(command, where, folder)
    print(done.stdout[-2000:] + done.stderr[-2000:])
    return done.returncode


@pytest.mark.parametrize("exported", WITH_PYTHON_SLOW, indirect=True)
def test_tool_without_python_runs_the_fmu_and_uses_no_freed_memory(
    exported: tuple[Flavour, Path], tmp_path
) -> None:
    assert simulate_without_python(*exported, tmp_path) == 0
    written = next(tmp_path.rglob("*.csv")).read_text().splitlines()
    column = next(i for i, name in enumerate(written[0].split(",")) if "status.valid" in name)
    assert {line.split(",")[column].strip() for line in written[1:]} == {"1"}
    assert len(written) > 20


def freed_blocks(folder: Path) -> list[str]:
    """A library to preload that makes any use of freed C++ memory fatal, where it can be compiled."""
    if (compiler := find_compiler()) is None:
        return []
    source = NATIVE / "freed_blocks.c"
    library = folder / "freed_blocks.so"
    command = [*compiler, "-std=c99", "-O1", "-fPIC", "-shared", str(source), "-o", str(library)]
    subprocess.run(command, check=True, capture_output=True)
    return [str(library)]


@pytest.mark.slow
@pytest.mark.skipif("native-2" not in FLAVOURS, reason="needs a C compiler")
def test_the_worked_program_of_the_tools_page_prints_what_it_says(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "howto" / "import.md").read_text(encoding="utf-8")
    blocks = (block.partition("```")[0] for block in page.split("```python\n")[1:])
    (program,) = (block for block in blocks if "left.fy" in block)
    (tmp_path / "build").mkdir()
    require("libcosim")
    assert (
        main(
            ["export", "--native", "--platform", "host", "--ssp", "--out", str(tmp_path / "build")]
        )
        == 0
    )
    done = run([sys.executable, "-c", program], environment(), tmp_path)
    assert "t = 25.00 s: left conveyance at 89.999 m, balance rope -8241 N" in done.stdout, (
        done.stderr[-2000:]
    )
