"""A folder that cannot be written to is named before anything is computed, by every command alike."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from balance_rope import main
from evidence.guards.__main__ import main as guards

DOCS = Path(__file__).parents[1] / "docs"
COMMANDS = {
    "demo": ["demo", "--in-process"],
    "duty": ["duty", str(DOCS / "duties" / "day.toml")],
    "ropes": ["ropes", str(DOCS / "duties" / "four_ropes.toml")],
    "identify": ["identify", str(DOCS / "measurements" / "example.toml")],
    "uncertain": ["uncertain", str(DOCS / "uncertain" / "rope-120.toml")],
}


def refused(arguments: list[str], folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """``arguments`` with a folder below a file: one line that names folder and cure."""
    (folder / "file").write_text("", encoding="utf-8")
    out = folder / "file" / "results"
    assert main([*arguments, "--out", str(out)]) == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert last == f"balance-rope: {out} cannot be written to (Not a directory): choose another --out"


@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_that_cannot_be_is_refused(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    refused(COMMANDS[name], tmp_path, capsys)


def test_a_link_to_nowhere_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "nowhere" / "results")
    for out in (link, link / "below"):
        assert main([*COMMANDS["identify"], "--out", str(out)]) == 2
        last = capsys.readouterr().err.splitlines()[-1]
        assert last == f"balance-rope: {out} cannot be written to (No such file or directory): choose another --out"
        with pytest.raises(SystemExit, match="2"):
            guards(["--out", str(out)])
        assert f"argument --out: {out} cannot be written to" in capsys.readouterr().err


def test_a_study_refuses_it_too(tmp_path: Path, fmu_of: Any, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "STUDY.toml"
    rope = fmu_of("native-2")
    path.write_text(f'study.fmu = "{rope}"\n[vary]\n"winding.speed" = [2.0, 3.0]\n', encoding="utf-8")
    refused(["study", str(path)], tmp_path, capsys)


@pytest.mark.parametrize("name", [*COMMANDS, "study", "export"])
def test_no_name_is_not_the_folder_one_stands_in(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main([*COMMANDS.get(name, [name]), "--out", ""])
    assert "argument --out: '' names nothing" in capsys.readouterr().err


@pytest.mark.parametrize("out", ["", "file/results"])
def test_a_measurement_refuses_them_too(
    out: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(SystemExit, match="2"):
        guards(["--out", out])
    assert f"argument --out: {out or repr(out)} " in capsys.readouterr().err


def test_a_measurement_makes_no_folder_before_it_has_something_to_write(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="2"):
        guards(["--out", str(tmp_path / "a" / "b"), "--scenes", "many"])
    assert not any(tmp_path.iterdir())
