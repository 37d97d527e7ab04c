"""The complete file of a hoist: every value with its status, read again to the same bits."""

import tomllib
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from balance_rope import main
from hoist_demo.cases.table import NAMED, find_case
from hoist_demo.report.hoist import as_file, hung
from hoist_demo.study.run import build_trip
from rope_model.scene_names import named_parameters

FILES = [*NAMED, *map(str, sorted((Path(__file__).parents[1] / "docs" / "hoists").glob("*.toml")))]


@pytest.mark.parametrize("name", FILES, ids=lambda name: Path(name).stem)
def test_the_file_has_every_value_of_the_hoist_and_leads_back_to_it(name: str, tmp_path: Path) -> None:
    text = as_file(find_case(name), name)
    (path := tmp_path / "hoist.toml").write_text(text, encoding="utf-8")
    one, again = build_trip(name, {}), build_trip(str(path), {})
    cases = [find_case(name), find_case(str(path))]
    ropes = [hung(case, run) for case, run in zip(cases, (one, again), strict=True)]
    assert [(a.name, a.scene, a.place, a.breaks) for a in ropes[0]] == [
        (b.name, b.scene, b.place, b.breaks) for b in ropes[1]
    ]
    # the drive of several ropes takes their sum from these
    same = {"case": "", "fmu": {}} | ({"hoist": None} if cases[0].ropes else {})
    assert replace(one, **same) == replace(again, **same)
    written = tomllib.loads(text)
    for parameter in named_parameters(ropes[0][0].scene):
        own = parameter.name.startswith(("rope.", "left.", "right."))
        table = written["rope"][0] if own else written
        for part in parameter.name.removeprefix("rope.").split("."):
            table = table[part] if part in table else written["rope"][0][parameter.name.partition(".")[0]][part]
        assert isinstance(table, str | bool) or table["status"], parameter.name


def test_the_file_beside_the_results_winds_them_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--in-process", "--level", "draft", "--signals", "left.fy", "loop.y", "drive.torque"]
    changed = ["--travel", "3", "--set", "rope.EI=200.1", "--set", "hoist.payload_left=1234.5"]
    assert main(["wind", "rope-120", *options, *changed, "--out", str(tmp_path / "one")]) == 0
    file = tmp_path / "one" / "hoist.toml"
    assert main(["wind", str(file), *options[:1], *options[3:], "--out", str(tmp_path / "two")]) == 0
    one, two = (pd.read_csv(tmp_path / name / "signals.csv") for name in ("one", "two"))
    pd.testing.assert_frame_equal(one, two, check_exact=True)
    text = file.read_text(encoding="utf-8")
    assert 'payload_left = { value = 1234.5, unit = "kg", status = "given" }' in text
    capsys.readouterr()
    assert main(["show", str(file)]) == 0
    said = capsys.readouterr().out
    assert tomllib.loads(said) == tomllib.loads(text)


def test_a_hoist_of_a_file_takes_no_fmu_that_happens_to_be_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "build").mkdir()
    # with what a study exported there, the report would lack what that does not show
    (tmp_path / "build" / "balance_rope.fmu").write_text("of another rope")
    (tmp_path / "mine.toml").write_text('name = "mine"\nlike = "rope-120"\n[[rope]]\n')
    assert main(["wind", "mine.toml", "--check"]) == 0
    assert main(["wind", "rope-120", "--check"]) == 2
