"""Pairs of what a hoist's file may hold, and of the commands that take it: each is right, or refused in a sentence."""

import os
from collections.abc import Mapping
from pathlib import Path

import pytest
from conftest import Capture, Patch

from combinations import Bench, judge_row, rows

SEED = os.environ.get("SEED")
ROWS = rows(None if SEED is None else int(SEED))


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize("row", ROWS, ids=[f"{k}-{row['command']}" for k, row in enumerate(ROWS)])
def test_a_pair_of_choices_is_right_or_refused(
    row: Mapping[str, str], tmp_path: Path, capsys: Capture, monkeypatch: Patch
) -> None:
    monkeypatch.chdir(tmp_path)
    judge_row(Bench(tmp_path, capsys, monkeypatch), row)
