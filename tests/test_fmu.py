"""The exported FMU, each scenario in a process of its own (see fmu_driver)."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from freed_blocks import freed_blocks
from numpy.testing import assert_allclose

from fmu_src.documentation import interface_page
from fmu_src.export import export_fmu
from fmu_src.native.build import host_platform
from rope_model.simulation.signal_table import SIGNALS

DRIVER = Path(__file__).with_name("fmu_driver.py")
HERE = (host_platform(),)


@pytest.fixture(scope="module")
def fmu(fmu_of: Callable[[str], Path]) -> Path:
    return fmu_of("python")


@pytest.fixture(scope="module")
def description(fmu: Path) -> ElementTree.Element:
    with zipfile.ZipFile(fmu) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


def drive(scenario: str, *arguments: Any) -> Any:
    command = [sys.executable, str(DRIVER), scenario, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    line = next(line for line in done.stdout.splitlines() if line.startswith("RESULT "))
    return json.loads(line.removeprefix("RESULT "))


def test_every_real_variable_with_a_dimension_has_a_declared_unit(description: ElementTree.Element) -> None:
    declared = {unit.get("name") for unit in description.iter("Unit")}
    for variable in description.iter("ScalarVariable"):
        real = variable.find("Real")
        if real is not None:
            assert real.get("unit") in declared, variable.get("name")
        assert variable.get("description"), variable.get("name")


def test_all_outputs_are_initial_unknowns_and_the_date_is_utc(description: ElementTree.Element) -> None:
    variables = list(description.iter("ScalarVariable"))
    outputs = [str(i) for i, v in enumerate(variables, start=1) if v.get("causality") == "output"]
    for section in ("Outputs", "InitialUnknowns"):
        listed = description.find(f"ModelStructure/{section}")
        assert listed is not None
        assert [unknown.get("index") for unknown in listed] == outputs
    assert len(outputs) == len(SIGNALS) + 5
    assert description.get("generationDateAndTime", "").endswith("Z")


def test_only_y_of_the_inputs_needs_to_move(description: ElementTree.Element) -> None:
    inputs = {v.get("name"): v for v in description.iter("ScalarVariable") if v.get("causality") == "input"}
    names = ["x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az", "yaw", "yaw_rate"]
    assert set(inputs) == {f"{side}.{name}" for side in ("left", "right") for name in names}
    # the scenarios of fmu_driver set y, vy and ay alone; the others start at rest in the nominal place
    starts = {name: float(v.find("Real").get("start")) for name, v in inputs.items()}
    assert {name for name, start in starts.items() if start != 0.0} == {"right.y"}


def test_same_sources_give_the_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1767225600")
    first, second = (export_fmu(tmp_path / name / "a.fmu", platforms=HERE).read_bytes() for name in ("one", "two"))
    assert first == second


def test_unknown_case_is_refused_with_the_choices(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="rope-120, rope-240"):
        export_fmu(tmp_path / "a.fmu", "rope-60")


def test_outputs_have_their_values_in_initialization_mode_and_follow_the_inputs(fmu: Path) -> None:
    first, lower, after = drive("initialization", fmu)
    assert_allclose(sum(first), -8.0 * 9.81 * 120.0, rtol=1e-9)
    assert_allclose(lower[0] - first[0], -0.5 * 10.0 * 8.0 * 9.81, rtol=1e-3)
    assert after == lower


def test_state_of_an_instance_with_other_parameters_is_taken_over_whole_or_not_at_all(fmu: Path) -> None:
    result = drive("foreign_state", fmu)
    assert result["weight"] == pytest.approx(-16.0 * 9.81 * 120.0, rel=0.01)  # it has begun to move
    assert "not a state" in result["message"]
    assert result["kept"] == 16.0
    assert result["next"] == ""


def test_fmu_equals_the_rope_in_process(fmu: Path) -> None:
    result = drive("same_as_in_process", fmu)
    assert result["transformations"] > 0
    assert result["worst"] < 1e-12


def test_restored_state_continues_to_the_bit_also_in_another_process(fmu: Path) -> None:
    result = drive("rollback", fmu)
    assert result["transformations"] > 0
    assert result["same"]
    assert drive("continue_from", fmu, result["data"]) == result["last"]


def test_instances_are_independent(fmu: Path) -> None:
    assert drive("two_instances", fmu, fmu)["same"]


@pytest.mark.slow
def test_two_fmus_are_independent(fmu: Path, tmp_path: Path) -> None:
    result = drive("two_instances", fmu, export_fmu(tmp_path / "long.fmu", "rope-240", "draft", platforms=HERE))
    assert result["same"]
    assert result["lengths"] == [120.0, 240.0]
    assert_allclose(result["weights"][1], -8.0 * 9.81 * 240.0, rtol=1e-9)


@pytest.mark.slow
def test_communication_step_and_reading_of_the_inputs_change_little(fmu: Path) -> None:
    forces = drive("communication_steps", fmu)
    reference = forces["5 True"]
    for name, force in forces.items():
        # extrapolated inputs lag by the jerk of a step, h a_t = 0.02 s x 2.4 m/s3 x 120 kg; the rest is below
        assert_allclose(force, reference, rtol=0.005 if name.endswith("False") else 0.0005, err_msg=name)


def test_bad_values_and_calls_get_a_message_and_the_instance_stays_usable(fmu: Path) -> None:
    result = drive("bad_calls", fmu)
    for name, words in {
        "before initialisation": "fmi2DoStep is not allowed before a successful initialisation",
        "nan": "left.vy = nan is not finite",
        "inf": "left.y = inf is not finite",
        "range": "left.vy = 10000 is beyond",
        "jump": "left.y and its derivatives do not fit together",
        "wrong time": "the host steps from t = 0.5 s",
        "zero step": "not positive",
        "negative step": "not positive",
        "nan step": "not positive",
        "fixed parameter": "rope.EI is fixed",
        "output set": "left.fy is an output",
        "unknown reference": "value reference 99999",
        "bytes": "not a state of this FMU",
        "rope__EI": "EI = -1.0",
        "rope__EI step": "EI = -1.0",
        "left__swivel__mode": "none of the choices: 0 locked, 1 free, 2 coulomb",
        "layout__spacing": "longer rope",
    }.items():
        assert words in result[name], (name, result[name])
    assert result["after reset"] == ""


def test_tunable_parameter_takes_effect_in_the_run(fmu: Path) -> None:
    before, after = drive("tunable", fmu)
    assert after - before >= 4 * 10


def test_directional_derivatives_are_those_of_a_step(fmu: Path) -> None:
    for name, (analytic, differences) in drive("derivatives", fmu).items():
        # the step is one of Newton's method; the derivative is of one, linearised
        assert_allclose(analytic, differences, atol=0.05 * np.abs(differences).max(), err_msg=name)


def test_portable_kernels_travel_inside(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        assert any(name.endswith(".casadi") for name in archive.namelist())
    assert np.all(np.isfinite(drive("portable", fmu)))


def exits(fmu: Path, runs: int, **variables: str) -> list[int]:
    command, where = [sys.executable, str(DRIVER), "brief", str(fmu)], {**os.environ, **variables}
    return [
        subprocess.run(command, capture_output=True, timeout=120, check=False, env=where).returncode
        for _ in range(runs)
    ]


def test_no_freed_memory_is_used_up_to_the_end_of_the_process(fmu: Path, tmp_path: Path) -> None:
    assert exits(fmu, 1, LD_PRELOAD=str(freed_blocks(tmp_path))) == [0]


@pytest.mark.slow
def test_fifty_processes_exit_cleanly(fmu: Path) -> None:
    assert exits(fmu, 50) == [0] * 50


def test_interface_page_is_up_to_date() -> None:
    page = Path(__file__).parents[1] / "docs" / "reference" / "variables.md"
    assert page.read_text(encoding="utf-8") == interface_page(), (
        "run python -m fmu_src.documentation > docs/reference/variables.md"
    )
