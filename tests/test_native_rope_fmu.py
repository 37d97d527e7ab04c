"""The native FMU with the rope in it, beside the Python rope in process."""

from __future__ import annotations

import csv
import io
import math
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmu_driver import COMPARED, H, motion
from native_host import Host
from numpy.testing import assert_allclose
from stand_in import RUNNERS, VERSIONS, live

from fmu_src.native.build import available_platforms, host_platform
from fmu_src.native.export import export_native
from rope_model.parameters import rope_120
from rope_model.simulation.paths import EndMotion
from rope_model.simulation.sensitivity import LOADS
from rope_model.simulation.signal_table import SHAPE_POINTS
from rope_model.simulation.simulator import RopeSimulator

pytest.importorskip("rope_model.native.build")


@pytest.fixture(scope="module")
def fmus(fmu_of: Callable[[str], Path]) -> dict[int, Path]:
    return {fmi: fmu_of(f"native-{fmi}") for fmi in VERSIONS}


@pytest.fixture(scope="module")
def folders(fmus: dict[int, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[int, str]:
    return {fmi: fmpy.extract(str(path), str(tmp_path_factory.mktemp("unzipped"))) for fmi, path in fmus.items()}


@pytest.fixture(params=VERSIONS)
def host(request: pytest.FixtureRequest, fmus: dict[int, Path], folders: dict[int, str]) -> Iterator[Host]:
    made = Host(fmus[request.param], folders[request.param])
    yield made
    made.call("FreeInstance")


def move(host: Host, t: float) -> None:
    for side, values in zip(("left", "right"), motion(t), strict=True):
        host.set(**{f"{side}.{key}": value for key, value in values.items()})


def run(host: Host, first: int, last: int, part: float = 1.0) -> list[list[float]]:
    """Steps of ``part`` H over the winding of fmu_driver, and what is compared."""
    record = []
    for k in range(round(first / part), round(last / part)):
        move(host, (k + 1) * part * H)
        assert host.step(k * part * H, part * H) == ""
        record.append(host.get(*COMPARED))
    return record


def test_fmu_equals_the_python_rope(host: Host) -> None:
    host.start(inputs_at_step_end=True)
    record = np.array(run(host, 0, 250))
    rope = RopeSimulator(rope_120().scene)
    rope.initialize(0.0, *(EndMotion(**m) for m in motion(0.0)))
    expected = []
    for k in range(250):
        rope.advance_to(k * H + H, *(EndMotion(**m) for m in motion((k + 1) * H)))
        values = rope.signals()
        expected.append([values[name] for name in COMPARED])
    assert rope.state.counts.transformations > 0
    assert host.get("count.transformations", "count.steps") == [
        rope.state.counts.transformations,
        rope.state.counts.steps,
    ]
    # a position of 100 m known to two units in its last place, times the stiffness of an element of 0.25 m
    data = rope_120().scene.rope
    noise = 2 * math.ulp(100.0) * data.Qa / 0.25
    # and the torque that the same stretch makes, as a stress
    torsion = 16 / (math.pi * data.diameter**3) * 2 * math.ulp(100.0) * data.Qb / 0.25
    for name, ours, theirs in zip(COMPARED, record.T, np.array(expected).T, strict=True):
        assert_allclose(ours, theirs, rtol=0, atol=1e-9 * np.abs(theirs).max() + noise, err_msg=name)
    for name in ("x", "y", "z", "tension", "bending", "torsion"):
        points = [f"shape.{name}[{i + 1}]" for i in range(SHAPE_POINTS)]
        ours = host.get(f"shape.{name}")[0] if host.fmi == 3 else host.get(*points)
        theirs = np.array([values[point] for point in points])
        allowed = 1e-9 * np.abs(theirs).max() + (torsion if name == "torsion" else noise)
        assert_allclose(ours, theirs, rtol=0, atol=allowed, err_msg=name)


def test_reference_results_inside_are_met(host: Host, fmus: dict[int, Path]) -> None:
    with zipfile.ZipFile(fmus[host.fmi]) as archive:
        tables = []
        for kind in ("in", "ref"):
            text = archive.read(f"extra/org.balance-rope.reference/BalanceRope_{kind}.csv").decode()
            head, *rows = csv.reader(io.StringIO(text))
            tables.append((head[1:], [[float(cell) for cell in row[1:]] for row in rows]))
    (names, inputs), (outputs, results) = tables
    host.start()
    for k, (values, expected) in enumerate(zip(inputs, results, strict=True)):
        host.set(**dict(zip(names, values, strict=True)))
        assert_allclose(host.get(*outputs), expected, rtol=1e-8, atol=1e-6)
        assert host.step(k * H) == ""


def test_state_goes_on_to_the_bit_over_transformations_after_half_steps(host: Host) -> None:
    host.start(inputs_at_step_end=True)
    run(host, 0, 120)
    state = host.state()
    data = host.serialize(state)
    first = run(host, 120, 180)
    assert host.get("count.transformations")[0] > 0
    host.restore(state)
    run(host, 120, 150, part=0.5)
    host.restore(state)
    host.free(state)
    assert run(host, 120, 180) == first
    taken = host.deserialize(data)
    host.restore(taken)
    host.free(taken)
    assert run(host, 120, 180) == first


SWIVELS = {
    f"{side}.swivel.{key}": value for side in ("left", "right") for key, value in (("mode", 2), ("release_time", 0.3))
}


def elsewhere(path: str, folder: str, state: str, first: int, last: int) -> str:
    """What another process gets that goes on from the serialized state in a file, as exact text."""
    other = Host(Path(path), folder)
    taken = other.deserialize(Path(state).read_bytes())
    other.restore(taken)
    other.free(taken)
    return repr(run(other, first, last))


def test_serialized_state_goes_on_in_another_process_over_swivel_events_to_the_bit(
    host: Host, fmus: dict[int, Path], folders: dict[int, str], tmp_path: Path
) -> None:
    host.start(**{"inputs_at_step_end": True, "rope.installed_twist": 2.0, **SWIVELS})
    run(host, 0, 40)
    state = host.state()
    saved = tmp_path / "state"
    saved.write_bytes(host.serialize(state))
    host.free(state)
    before = host.get("count.swivel_events")[0]
    here = repr(run(host, 40, 160))
    assert host.get("count.swivel_events")[0] > before
    assert host.get("count.transformations")[0] > 0
    call = f"import test_native_rope_fmu as t; print(t.elsewhere({str(fmus[host.fmi])!r}, {str(folders[host.fmi])!r}, "
    call += f"{str(saved)!r}, 40, 160))"
    where = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path])}
    done = subprocess.run([sys.executable, "-c", call], capture_output=True, text=True, check=True, env=where)
    assert done.stdout.strip().splitlines()[-1] == here


def test_directional_derivatives_are_those_of_a_step(host: Host) -> None:
    host.start(inputs_at_step_end=True, solver__tolerance=1e6)
    run(host, 0, 30)
    for name in ("left.y", "right.vy", "left.ay", "right.ax"):
        state = host.state()
        move(host, 31 * H)
        start, size = host.get(name)[0], {"y": 1e-7, "vy": 1e-5, "ay": 1e-3, "ax": 1e-3}[name.split(".")[1]]
        forces = []
        for change in (-size, size):
            host.restore(state)
            move(host, 31 * H)
            host.set(**{name: start + change})
            assert host.step(30 * H) == ""
            forces.append(host.get(*LOADS))
        host.restore(state)
        move(host, 31 * H)
        assert host.step(30 * H) == ""
        difference = (np.array(forces[1]) - forces[0]) / (2 * size)
        analytic = [host.derivative(force, name) for force in LOADS]
        host.restore(state)
        host.free(state)
        # the step is one of Newton's method; the derivative is of one, linearised
        assert_allclose(analytic, difference, atol=0.05 * np.abs(difference).max(), err_msg=name)


def test_hostile_values_name_value_bound_and_cure(host: Host) -> None:
    for name, value, words in (
        ("rope.EI", -1.0, "EI = -1"),
        ("rope.length", 1e9, "length = "),
        ("mesh.elements", 1, "elements = 1"),
        ("layout.spacing", 500.0, "longer rope"),
        ("solver.rho_inf", 2.0, "rho_inf = 2"),
        ("rope.Qb", 1e9, "below sqrt(Qa Qd)"),
    ):
        more = {"mesh.kind": 1} if name == "mesh.elements" else {}
        with pytest.raises(FMICallException):
            host.start(**{name: value}, **more)
        assert words in host.error(), name
        host.fmu.reset()
    host.start(inputs_at_step_end=True)
    run(host, 0, 3)
    state = host.state()
    for values, words in (({"left.vy": 1e4}, "beyond +-60"), ({"left.y": 5.0}, "inputs.misfit_max")):
        move(host, 4 * H)
        host.set(**values)
        assert words in host.step(3 * H)
        host.restore(state)
    host.free(state)
    assert np.all(np.isfinite(run(host, 3, 5)))
    assert not math.isnan(host.get("left.added_mass")[0])


@pytest.mark.slow
@pytest.mark.parametrize("way", list(RUNNERS))
def test_whole_life_without_taking_memory_while_stepping(tmp_path: Path, way: str) -> None:
    platform = host_platform() if way == "valgrind" else way
    if platform not in available_platforms():
        pytest.skip("needs ziglang")
    assert live(export_native(tmp_path / "rope.fmu", platforms=(platform,)), tmp_path, way) == [0, 0]


def test_all_outputs_are_finite(host: Host) -> None:
    host.start(inputs_at_step_end=True)
    run(host, 0, 5)
    values: list[Any] = [host.get(v.name)[0] for v in host.variables.values() if v.type in ("Real", "Float64")]
    assert np.all(np.isfinite(np.hstack(values)))
