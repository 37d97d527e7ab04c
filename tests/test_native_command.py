"""The command line that exports native FMUs."""

from pathlib import Path

import fmpy
import pytest
from stand_in import stand_in

from balance_rope import main


def test_start_values_are_set_on_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("fmu_src.native.export.rope_sources", stand_in)
    path = tmp_path / "rope.fmu"
    options = ["export", "--native", "--platform", "host", "--out", str(path)]
    assert main([*options, "--set", "air.density=1.2", "--set", "model.fidelity=torsional"]) == 0
    starts = {v.name: v.start for v in fmpy.read_model_description(str(path)).modelVariables}
    assert [float(starts[name]) for name in ("air.density", "model.fidelity", "rope.length")] == [1.2, 1.0, 120.0]
    for wrong, told in (
        ("air.density=-1", "air.density = -1.0 must be within 0 and 100: give it in kg/m3"),
        ("rope.length=-1", "rope.length = -1.0 must be within 1e-15 and 10000: give it in m"),
        ("hoist.payload_left=1", "--set hoist.payload_left: the FMU has the rope alone: give it to demo"),
    ):
        assert main([*options, "--set", wrong]) == 2
        assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--native", "--fmi", "2", "3", "--out", "x.fmu"], "give a folder"),
        (["--out", "file/x.fmu"], "file cannot be written to"),
        (["--out", "x.txt"], "--out x.txt must end in .fmu or be a folder that is there: give x.fmu"),
        (["--native", "--scalar"], "add --native --fmi 3"),
    ],
)
def test_an_export_that_cannot_be_meant_is_refused_before_anything_is_built(
    options: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    assert main(["export", *options]) == 2
    assert words in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
