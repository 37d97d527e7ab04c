"""A folder that cannot be written to is named before anything is computed, by every command alike."""

from pathlib import Path

import pytest

from balance_rope import main

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


@pytest.mark.parametrize("name", [*COMMANDS, "study", "export"])
def test_no_name_is_not_the_folder_one_stands_in(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main([*COMMANDS.get(name, [name]), "--out", ""])
    assert "argument --out: '' names nothing" in capsys.readouterr().err
