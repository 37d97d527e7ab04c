"""Every number that a run rests on has a status, and every command shows it."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from balance_rope import main
from hoist_demo.cases.table import NAMED, find_case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data, rope_parameters, scene_parameters
from hoist_demo.report.provenance import told
from hoist_demo.study.catalogue import Catalogue
from hoist_demo.study.provenance import STATUSES, Known, of_host, of_rope, statuses
from hoist_demo.study.reading import read_statuses, read_values
from hoist_demo.study.run import build
from hoist_demo.uncertainty.definition import read_uncertain

SHORT = "[fixed]\nwinding.travel = 1.0\nwinding.settle = 1.0\nmodel.fidelity = 2\n"


def known(name: str, given: dict[str, str]) -> list[Known]:
    """What a run of the case rests on."""
    rope = scene_parameters(rope_data(find_case(name).rope))
    return [*of_host(build(name, {}), given), *of_rope(find_case(name), rope, given)]


@pytest.mark.parametrize("name", NAMED)
def test_every_number_of_a_case_has_a_status(name: str) -> None:
    data = known(name, {})
    assert {one.status for one in data} <= {*STATUSES}
    found = statuses(data)
    assert len(found) == len(data)
    # what a case's source states are numbers of the case
    assert {key for key, status in found.items() if status == "published"} == {*find_case(name).stated}


def test_the_published_pair_is_published_and_what_is_ours_is_assumed() -> None:
    found = statuses(known("rope-120", {}))
    assert {found[name] for name in ("rope.Qb", "rope.Qc", "rope.length")} == {"published"}
    ours = ("rope.EI", "hoist.sheave_mass", "left.swivel.mu_static", "contact.friction", "gains.speed", "air.drag")
    assert {found[name] for name in ours} == {"assumed"}
    assert {found[name] for name in ("solver.step_max", "coupling.step", "lining.width")} == {"setting"}
    # of installed size the coupling is ours
    assert statuses(known("kiruna-355", {}))["rope.Qb"] == "assumed"
    assert statuses(known("kiruna-355", {}))["hoist.sheave_radius"] == "published"


def test_a_value_of_the_fmu_that_is_not_the_case_s_is_exported_with_it() -> None:
    rope = scene_parameters(rope_data({"rope.EI": 123.0}))
    assert statuses(of_rope(find_case("rope-120"), rope, {}))["rope.EI"] == "exported"


def test_what_is_set_is_given_or_what_its_file_says(tmp_path: Path) -> None:
    file = tmp_path / "rope.toml"
    file.write_text(
        '[known]\nbending_stiffness = { low = 1, high = 2, status = "calibrated" }\n[fixed]\nrope.EI = 1.5\n'
    )
    table = {"from": str(file), "rope": {"Qd": 900.0}, "hoist": {"payload_left": {"value": 1e3, "status": "measured"}}}
    found = read_statuses(table)
    wanted = {"rope.EI": "calibrated", "rope.Qd": "given", "hoist.payload_left": "measured"}
    assert found == wanted
    data = statuses(known("rope-120", found))
    assert wanted.items() <= data.items()


def test_a_status_that_is_none_is_refused() -> None:
    problems: list[str] = []
    read_values(Catalogue(rope_parameters()), "[fixed]", {"rope.EI": {"value": 3.0, "status": "sure"}}, problems)
    assert problems == [
        "[fixed]: rope.EI has status = 'sure', which must be one of measured, published, derived, calibrated, "
        "contradicted, assumed: choose one"
    ]


def test_few_are_told_by_name_and_many_by_their_number() -> None:
    data = [Known("rope.EI", 1.0, "N.m2", "calibrated")]
    data += [Known(f"hoist.x{k}", 1.0, "m", "assumed") for k in range(20)]
    data += [Known("solver.step_max", 0.02, "s", "setting")]
    assert [(row.quantity, row.value) for row in told(data)] == [("calibrated", "rope.EI"), ("assumed", "20 of hoist")]


_FILES = {
    "duty": f"[duty]\nlevel = 'draft'\n{SHORT}[[trip]]\nwinding.travel = 1.0\n[[trip]]\nwinding.travel = -1.0\n",
    "ropes": f"[ropes]\nlevel = 'draft'\n{SHORT}[[rope]]\nz = 0.5\n[[rope]]\nz = -0.5\nrope.EI = 80.0\n",
    "uncertain": "[uncertain]\nlevel = 'draft'\nsamples = 8\nmeasures = ['rope_force_ripple']\n"
    "[rope]\nconstruction = '34x7'\ndiameter = 0.044\n[known]\nmass_per_length = 7.7\n"
    f"axial_stiffness = 9e7\ntorsional_stiffness = 40.0\ntorque_factor = 0.0\n{SHORT}",
    "identify": "[rope]\nconstruction = '34x7'\ndiameter = 0.046\nlength = 120.0\n"
    "[[measured]]\nwhat = 'loop width'\nvalue = 3.05\nsigma = 0.05\n",
}
_SAID = {
    "duty": ("winding.travel", "given"),
    "ropes": ("rope2.rope.EI", "given"),
    "uncertain": ("rope.EI", "varied"),
    "identify": ("rope.EI", "calibrated"),
}


@pytest.mark.parametrize("command", _FILES)
def test_every_command_says_where_its_numbers_come_from(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, out = tmp_path / "file.toml", tmp_path / "out"
    file.write_text(_FILES[command])
    options = ["--workers", "1"] if command == "uncertain" else []
    assert main([command, str(file), "--out", str(out), *options]) == 0
    assert "Data that this rests on, by status" in capsys.readouterr().out
    with (out / "data.csv").open(encoding="utf-8", newline="") as table:
        rows = {row["name"]: row["status"] for row in csv.DictReader(table)}
    name, status = _SAID[command]
    assert rows[name] == status
    assert set(rows.values()) <= {*STATUSES}
    if command in ("uncertain", "identify"):
        assert "Data that this rests on, by status" in (out / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(("own", "status"), [("", "published"), ("length = 120.5\n", "given")])
def test_a_length_that_is_the_case_s_is_not_said_to_be_given(tmp_path: Path, own: str, status: str) -> None:
    file = tmp_path / "uncertain.toml"
    file.write_text(_FILES["uncertain"].replace("[known]", f"{own}[known]"))
    found = statuses(read_uncertain(file, rope_parameters()).provenance())
    assert (found["rope.length"], found["hoist.tail_rope_length"]) == (status, status)


@pytest.mark.slow
def test_a_report_says_which_datum_yaws_a_rope_at_rest(tmp_path: Path) -> None:
    turned = [
        "--set",
        "rope.installed_twist=3",
        "--set",
        "model.fidelity=1",
        "--set",
        "winding.settle=0.1",
        "--level",
        "draft",
    ]
    assert main(["demo", "--in-process", "--quick", "--travel", "0.5", "--out", str(tmp_path), *turned]) == 0
    report = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert "turned mostly by installed_twist = 3 rad" in report
    assert "| rope.installed_twist | 3 | rad | given |" in report
    assert "| rope.EI | 300 | N m² | assumed |" in report
