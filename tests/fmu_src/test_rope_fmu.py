"""The exported FMU of each flavour beside the rope in process: values, states, derivatives, refusals."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from checkout import ROOT
from exports import FLAVOURS, NATIVE
from native_host import ERROR, OK, Host
from numpy.testing import assert_allclose, assert_array_equal
from scenes import fixed_steps, hung, smooth_trip
from stand_in import RUNNERS, live

from docs.variables import interface_page
from fmu_src.native.export import export_native
from fmu_src.python.export import export_fmu
from fmu_src.shell.build import PLATFORMS, available_platforms, host_platform
from hoist_demo.command_line.main import main
from rope_model import BalanceRope, Scene, Swivel, balance_rope, rope_120
from rope_model.method.stepping import MIN_INTERVAL
from rope_model.reference.outputs import COMPUTED_NAMES
from rope_model.signals.signal_table import LOADS, SHAPE_POINTS, SIGNALS

H = 0.02
#: steps of a comparison with the rope in process: the first transformation is in the 50th
LAST = 80
HERE = (host_platform(),)
#: steps as long as the host's
EVEN = {"inputs_at_step_end": True, "solver.step_max": H, "solver.tolerance": 1e6}
SIDES = ("left", "right")
COMPARED = [
    *map(".".join, product(SIDES, ("fx", "fy", "fz", "mx", "my", "mz", "fy_mean"))),
    "loop.x",
    "loop.y",
    "loop.z",
    "loop.yaw",
    "loop.clearance",
    "stress.bending_max",
    "energy.total",
]
SWIVELS = {
    "left.swivel.mode": 2,
    "left.swivel.release_time": 0.3,
    "right.swivel.mode": 2,
    "right.swivel.release_time": 0.3,
}
python_only = pytest.mark.parametrize("host", ["python"], indirect=True)
#: FMI 2.0 has the same functions, and the reference rope takes much longer
QUICK_WITH_FMI_3 = [
    pytest.param(x, marks=[pytest.mark.slow] * (x != "native-3")) for x in sorted(FLAVOURS)
]
REALS = ("Real", "Float64")
Unpacked = Callable[[str], tuple[Path, str]]


@pytest.fixture(params=sorted(FLAVOURS))
def host(request: pytest.FixtureRequest, unpacked: Unpacked) -> Iterator[Host]:
    made = Host(*unpacked(request.param))
    yield made
    made.free()


def move(host: Host, t: float) -> None:
    for side, end in zip(("left", "right"), smooth_trip(t, 20.0, 5.0, 90.0), strict=True):
        host.set(**{f"{side}.{key}": getattr(end, key) for key in ("y", "vy", "ay")})


def compared(host: Host) -> list[str]:
    """What is compared of an FMU: of COMPARED what its flavour computes."""
    return [name for name in COMPARED if name in host.variables]


def run(host: Host, first: int, last: int, part: float = 1.0) -> list[list[float]]:
    """Steps of ``part`` H with the inputs of their end, and what is compared."""
    record = []
    names = compared(host)
    for k in range(round(first / part), round(last / part)):
        move(host, (k + 1) * part * H)
        assert host.step(k * part * H, part * H) == ""
        record.append(host.get(*names))
    return record


def is_native(host: Host) -> bool:
    return "left.added_mass" in host.variables


def new_rope(scene: Scene, native: bool) -> BalanceRope:
    if native:
        return balance_rope(scene)
    return balance_rope(scene, "reference")


def test_swivels_of_each_flavour_start_where_they_do_in_process(host: Host) -> None:
    names = [*map(".".join, product(SIDES, ("swivel.torque", "swivel.angle")))]
    host.start(**{"left.swivel.mode": 2, "right.swivel.mode": 2})
    healthy = Swivel(mode="coulomb")
    scene = rope_120().scene.with_(left=healthy, right=healthy)
    rope = new_rope(scene, is_native(host))
    hung(rope, *smooth_trip(0.0, 20.0, 5.0, 90.0))
    assert abs(rope.signals()["left.swivel.angle"]) > 0.1
    assert_allclose(host.get(*names), [*rope.signals(names).values()], rtol=0, atol=1e-7)


@cache
def in_process(native: bool) -> tuple[np.ndarray, BalanceRope]:
    """What is compared after each of LAST steps, and the rope after the last."""
    scene = rope_120().scene.with_(solver=fixed_steps(H))
    rope = new_rope(scene, native)
    expected = []
    hung(rope, *smooth_trip(0.0, 20.0, 5.0, 90.0))
    names = [name for name in COMPARED if native or name in COMPUTED_NAMES]
    for k in range(LAST):
        # the time is rounded as that of the FMU
        rope.advance_to(k * H + H, *smooth_trip((k + 1) * H, 20.0, 5.0, 90.0))
        expected.append([*rope.signals(names).values()])
    return np.array(expected), rope


def test_fmu_equals_the_rope_in_process_to_the_bit(host: Host) -> None:
    host.start(**EVEN)
    record = np.array(run(host, 0, LAST))
    expected, rope = in_process(is_native(host))
    assert rope.state.counts.transformations > 0
    real = [v.name for v in host.variables.values() if v.type in REALS and v.causality == "output"]
    assert np.all(np.isfinite(np.hstack([host.get(name)[0] for name in real])))
    counts = "count.transformations", "count.steps"
    assert host.get(*counts) == [*rope.signals(counts).values()]
    assert_array_equal(record, expected)
    for name in ("x", "y", "z", "s", "tension", "bending", "torsion"):
        points = [f"shape.{name}[{i + 1}]" for i in range(SHAPE_POINTS)]
        if points[0] not in SIGNALS or not (is_native(host) or points[0] in COMPUTED_NAMES):
            continue
        if host.fmi == 3:
            (ours,) = host.get(f"shape.{name}")
        else:
            ours = host.get(*points)
        assert_array_equal(ours, [*rope.signals(points).values()], err_msg=name)


def elsewhere(path: str, folder: str, state: str, first: int, last: int) -> str:
    other = Host(Path(path), folder)
    other.go_on_from(Path(state).read_bytes())
    return repr(run(other, first, last))


def in_another_process(call: str) -> str:
    where = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path])}
    command = [sys.executable, "-c", f"import test_rope_fmu as t; print(t.{call})"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=where)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout.strip().splitlines()[-1]


@pytest.mark.parametrize("host", QUICK_WITH_FMI_3, indirect=True)
def test_states_go_on_to_the_bit_after_half_steps_and_in_another_process(
    host: Host, unpacked: Unpacked, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    """Over transformations and swivel events; there in an instance not yet initialised, of other parameters."""
    host.start(**EVEN, **{"rope.installed_twist": 2.0}, **SWIVELS)
    run(host, 0, 20)
    state = host.state()
    saved = tmp_path / "state"
    saved.write_bytes(host.write(state))
    before = host.get("count.swivel_events")[0]
    here = run(host, 20, LAST)
    assert host.get("count.swivel_events")[0] > before
    assert host.get("count.transformations")[0] > 0
    host.restore(state)
    run(host, 20, LAST, part=0.5)
    host.restore(state)
    host.forget(state)
    assert run(host, 20, LAST) == here
    path, folder = map(str, unpacked(request.node.callspec.params["host"]))
    assert in_another_process(
        f"elsewhere({path!r}, {folder!r}, {str(saved)!r}, 20, {LAST})"
    ) == repr(here)


@pytest.mark.parametrize("host", NATIVE, indirect=True)
@pytest.mark.parametrize("at_step_end", [True, False])
def test_directional_derivatives_are_those_of_a_step(host: Host, at_step_end: bool) -> None:
    host.start(inputs_at_step_end=at_step_end)
    run(host, 0, 30)
    state = host.state()
    # a position alone is a misfit beyond 1e-7 m, which is not followed as a smaller one; larger changes of the
    # acceleration are followed by other internal steps
    for name, size in {"left.y": 1e-9, "right.vy": 1e-7, "left.ay": 1e-5, "right.ax": 1e-3}.items():
        forces = []
        for change in (-size, size, 0.0):
            host.restore(state)
            move(host, 31 * H)
            host.set(**{name: host.get(name)[0] + change})
            assert host.step(30 * H, H) == ""
            forces.append(host.get(*LOADS))
        difference = (np.array(forces[1]) - forces[0]) / (2 * size)
        derivatives = [host.derivative(force, name) for force in LOADS]
        # the rest is the rounding of the differences
        assert_allclose(derivatives, difference, atol=0.01 * np.abs(difference).max(), err_msg=name)


@python_only
def test_the_python_flavour_describes_what_the_reference_rope_computes_and_no_derivatives(
    host: Host, unpacked: Unpacked
) -> None:
    description = fmpy.read_model_description(str(unpacked("python")[1]))
    assert not description.coSimulation.providesDirectionalDerivative
    assert "inputs.given = all" in description.description
    outputs = {v.name for v in description.modelVariables if v.causality == "output"}
    assert {name for name in outputs if not name.startswith("status.")} == {*COMPUTED_NAMES}
    # the native flavour has all of them, with the same value references
    both = fmpy.read_model_description(str(unpacked("native-2")[1])).modelVariables
    references = {v.name: v.valueReference for v in both}
    ours = {v.name: v.valueReference for v in description.modelVariables}
    assert ours.items() <= references.items()
    host.start()
    with pytest.raises(AssertionError, match="export the native flavour"):
        host.derivative("left.fy", "left.y")


@pytest.mark.parametrize(
    "way",
    [pytest.param(x, marks=[pytest.mark.slow] * (x != "counted")) for x in RUNNERS],
)
def test_a_whole_life_with_failed_calls_is_clean_and_takes_no_memory_while_stepping(
    tmp_path: Path, way: str, fmu_of: Callable[[str], Path]
) -> None:
    platform = host_platform()
    if way in PLATFORMS:
        platform = way
    if platform not in available_platforms():
        pytest.skip("needs ziglang")
    if platform == host_platform():
        fmu = fmu_of("native-2")
    else:
        fmu = export_native(tmp_path / "rope.fmu", platforms=(platform,))
    assert live(fmu, tmp_path, way) == [0, 0]


@pytest.mark.skipif(
    sys.platform != "linux" or shutil.which("nm") is None, reason="needs Linux and nm"
)
@pytest.mark.parametrize(
    ("kind", "memory", "unused"), [("native-2", set(), []), ("native-3", {"calloc", "free"}, [])]
)
def test_the_library_needs_of_libc_what_the_page_lists(
    kind: str, memory: set[str], unused: list[str], unpacked: Unpacked
) -> None:
    page = (ROOT / "docs" / "howto" / "accuracy.md").read_text(encoding="utf-8")
    listed: set[str] = set()
    for line in page.splitlines():
        if line.startswith("- of `"):
            listed |= {*re.findall(r"`(\w+)`", line)}
    folder = Path(unpacked(kind)[1])
    library = next((folder / "binaries").rglob("BalanceRope.so"))
    told = subprocess.run(
        ["nm", "-D", "-u", library], capture_output=True, text=True, check=True
    ).stdout
    # compilers write some of them in other words
    words = {"bcmp": ["memcmp"], "sincos": ["sin", "cos"], "strtol": ["atoi"]}
    needed: set[str] = set()
    for symbol in re.findall(r"\bU (\S+)", told):
        name = re.sub(r"^__isoc\d+_|@.*", "", symbol)
        needed |= {*words.get(name, [name])}
    # the assertion is that of ROPE_CHECKS in tests/quick: FMUs that are shipped have none
    assert needed - listed == memory | {"__assert_fail"}
    text = "".join(
        path.read_text(encoding="utf-8") for path in (folder / "sources").glob("*.[chi]*")
    )
    assert [name for name in sorted(listed) if not re.search(rf"\b{name}\(", text)] == unused


@pytest.mark.slow
def test_instances_are_independent_of_one_another_and_of_another_fmu(
    unpacked: Unpacked, tmp_path: Path
) -> None:
    other = export_fmu(tmp_path / "long.fmu", "rope-240", "draft", platforms=HERE)
    fmus = (*(unpacked("python"),) * 2, (other, fmpy.extract(str(other), str(tmp_path / "long"))))
    hosts = [Host(*fmu) for fmu in fmus]
    for each in hosts:
        each.start(**EVEN, **{"right.y": 90.0})
    records: list[list[Any]] = [[], [], []]
    for k in range(30):
        for record, each in zip(records, hosts, strict=True):
            record += run(each, k, k + 1)
    assert records[0] == records[1]
    assert [each.get("rope.length")[0] for each in hosts] == [120.0, 120.0, 240.0]
    for each in hosts:
        each.free()


@python_only
def test_the_python_flavour_refuses_what_is_not_published_and_names_the_native_one(
    host: Host,
) -> None:
    host.set(**{"air.density": 1.2})
    assert host.enter() == OK
    assert host.call("ExitInitializationMode") == ERROR
    assert "air.density = 1.2 must be 0 for the reference rope" in host.said[-1]
    assert host.said[-1].endswith("take the native flavour, balance-rope export")
    assert host.hang({}) == OK


def test_an_export_of_more_than_the_published_system_names_parameter_and_native(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "rope.fmu"
    assert main(["export", "--python", "--set", "air.density=1.2", "--out", str(out)]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert "air.density = 1.2 must be 0" in line
    assert line.endswith("take the native flavour, balance-rope export")
    assert not out.exists()


def test_the_shell_asks_the_rope_for_no_step_that_it_would_skip() -> None:
    text = (ROOT / "fmu_src" / "shell" / "component.c").read_text(encoding="utf-8")
    (resolution,) = re.findall(r"#define TIME_RESOLUTION (\S+)", text)
    assert float(resolution) >= MIN_INTERVAL


def test_same_sources_give_the_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1767225600")
    first, second = (
        export_fmu(tmp_path / name / "a.fmu", platforms=HERE).read_bytes()
        for name in ("one", "two")
    )
    assert first == second


def test_interface_page_is_up_to_date() -> None:
    page = ROOT / "docs" / "reference" / "variables.md"
    assert page.read_text(encoding="utf-8") == interface_page(), (
        "run python -m docs.variables > the page"
    )
