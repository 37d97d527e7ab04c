"""What every command does: its numbers have a status, and a folder that cannot be written to is named first."""

import csv
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from balance_rope import main
from hoist_demo.cases.table import NAMED, find_case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data, scene_parameters
from hoist_demo.files.run_values import Values
from hoist_demo.files.values import statuses as file_statuses
from hoist_demo.study.provenance import STATUSES, Known, of_host, of_rope, statuses
from hoist_demo.study.run import build

pytestmark = pytest.mark.usefixtures("plain_figures")

SHORT = "[fixed]\nwinding.travel = 1.0\nwinding.settle = 1.0\nmodel.fidelity = 2\n"


def known(name: str, given: dict[str, str]) -> list[Known]:
    rope = scene_parameters(rope_data(find_case(name).rope))
    return [*of_host(build(name, {}), given), *of_rope(find_case(name), rope, given)]


@pytest.mark.parametrize("name", NAMED)
def test_every_number_of_a_case_has_a_status(name: str) -> None:
    data = known(name, {})
    assert {one.status for one in data} <= {*STATUSES}
    found = statuses(data)
    assert len(found) == len(data)
    # what a hoist's source states are numbers of the hoist
    stated = {key for key, status in find_case(name).given.items() if status == "published"}
    assert {key for key, status in found.items() if status == "published"} == stated


def test_the_published_pair_is_published_and_what_is_ours_is_assumed() -> None:
    found = statuses(known("rope-120", {}))
    assert {found[name] for name in ("rope.Qb", "rope.Qc", "rope.length")} == {"published"}
    ours = ("rope.EI", "hoist.sheave_mass", "left.swivel.mu_static", "contact.friction", "gains.speed", "air.drag")
    assert {found[name] for name in ours} == {"assumed"}
    assert {found[name] for name in ("solver.step_max", "coupling.step", "lining.width")} == {"setting"}
    # of installed size the coupling is ours
    assert statuses(known("kiruna-355", {}))["rope.Qb"] == "assumed"
    assert statuses(known("kiruna-355", {}))["hoist.sheave_radius"] == "published"


def test_what_is_set_is_given_or_what_its_file_says(tmp_path: Path) -> None:
    file = tmp_path / "rope.toml"
    file.write_text('[known]\nbending_stiffness = { low = 1, high = 2, status = "calibrated" }\n[fixed]\nrope.EI = 1\n')
    table = {"from": str(file), "rope": {"Qd": 900.0}, "hoist": {"payload_left": {"value": 1e3, "status": "measured"}}}
    found = file_statuses(TypeAdapter(Values).validate_python(table))
    wanted = {"rope.EI": "calibrated", "rope.Qd": "given", "hoist.payload_left": "measured"}
    assert found == wanted
    data = statuses(known("rope-120", found))
    assert wanted.items() <= data.items()


_FILES = {
    "duty": f"[duty]\nlevel = 'draft'\n{SHORT}[[trip]]\nwinding.travel = 1.0\n[[trip]]\nwinding.travel = -1.0\n",
    "wind": "name = 'two'\nlike = 'rope-120'\nlevel = 'draft'\nwinding.travel = 1.0\nwinding.settle = 0.5\n"
    "[[rope]]\nz = 0.5\n[[rope]]\nz = -0.5\nEI = 80.0\n",
    "uncertain": "[uncertain]\nlevel = 'draft'\nsamples = 8\nmeasures = ['rope_force_ripple']\n"
    "[rope]\nconstruction = '34x7'\ndiameter = 0.044\n[known]\nmass_per_length = 7.7\n"
    f"axial_stiffness = 9e7\ntorsional_stiffness = 40.0\ntorque_factor = 0.0\n{SHORT}",
    "identify": "[rope]\nconstruction = '34x7'\ndiameter = 0.046\nlength = 120.0\n"
    "[[measured]]\nwhat = 'loop width'\nvalue = 3.05\nsigma = 0.05\n",
}
_SAID = {"duty": "winding.travel", "wind": "rope2.rope.EI", "uncertain": "rope.EI", "identify": "rope.EI"}


@pytest.mark.parametrize("command", _FILES)
def test_commands_say_whence_numbers_are(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = tmp_path / "file.toml", tmp_path / "out"
    file.write_text(_FILES[command])
    options = ["--workers", "1"] if command == "uncertain" else []
    assert main([command, str(file), "--out", str(out), *options]) == 0
    said = (out / "report.md").read_text(encoding="utf-8") if command == "wind" else capsys.readouterr().out
    assert "Data that this rests on, by status" in said
    with (out / "data.csv").open(encoding="utf-8", newline="") as table:
        rows = {row["name"]: row["status"] for row in csv.DictReader(table)}
    assert rows[_SAID[command]] == {"uncertain": "varied", "identify": "calibrated"}.get(command, "given")
    assert set(rows.values()) <= {*STATUSES}
    if command in ("uncertain", "identify"):
        assert "Data that this rests on, by status" in (out / "report.html").read_text(encoding="utf-8")


DOCS = Path(__file__).parents[1] / "docs"
COMMANDS = {
    "wind": ["wind", "--in-process"],
    "duty": ["duty", str(DOCS / "duties" / "day.toml")],
    "several": ["wind", str(DOCS / "hoists" / "four_ropes.toml")],
    "identify": ["identify", str(DOCS / "measurements" / "example.toml")],
    "uncertain": ["uncertain", str(DOCS / "uncertain" / "rope-120.toml")],
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_that_cannot_be_is_refused(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    (tmp_path / "link").symlink_to(tmp_path / "nowhere" / "results")
    for below, why in (("file", "Not a directory"), ("link", "No such file or directory")):
        out = tmp_path / below / "results"
        assert main([*COMMANDS[name], "--out", str(out)]) == 2
        last = capsys.readouterr().err.splitlines()[-1]
        assert last == f"balance-rope: {out} cannot be written to ({why}): choose another --out"


@pytest.mark.parametrize("name", [*COMMANDS, "study", "export"])
def test_no_name_is_not_the_folder_one_stands_in(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main([*COMMANDS.get(name, [name]), "--out", ""])
    assert "argument --out: '' names nothing" in capsys.readouterr().err
