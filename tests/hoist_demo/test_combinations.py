"""Pairs of what a hoist's file may hold, and of the commands that take it: each is right, or refused in a sentence."""

import os
from collections.abc import Mapping
from pathlib import Path

import pytest
from invariants.combinations import (
    REFUSALS,
    REFUSED,
    Bench,
    Choices,
    default_row,
    judge_row,
    rows,
    text_of,
)
from shared import Capture, Patch

SEED = os.environ.get("SEED")

pytestmark = pytest.mark.usefixtures("no_figures")


@pytest.fixture
def bench(tmp_path: Path, capsys: Capture, monkeypatch: Patch) -> Bench:
    monkeypatch.chdir(tmp_path)
    return Bench(tmp_path, capsys, monkeypatch)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Give all rows to the slow test; where it is left out they are not made, which takes a second."""
    if "row" in metafunc.fixturenames:
        found: list[dict[str, str]] = []
        if metafunc.config.option.markexpr != "not slow":
            found = rows(None if SEED is None else int(SEED))
        ids = [f"{k}-{row['command']}" for k, row in enumerate(found)]
        metafunc.parametrize("row", found, ids=ids)


@pytest.mark.slow
def test_every_pair_of_choices_is_right_or_refused(row: Mapping[str, str], bench: Bench) -> None:
    judge_row(bench, row)


@pytest.mark.slow
@pytest.mark.parametrize(("command", "stop"), [("resume", "torque"), ("duty", "none")])
def test_commands_agree_on_a_trip_of_two_ropes(command: str, stop: str, bench: Bench) -> None:
    # the row differs from the defaults in what most commands must pass on
    choices = {
        "ropes": "two",
        "stop": stop,
        "brake": "strong",
        "level": "draft",
        "swivels": "coulomb",
    }
    assert judge_row(bench, {**default_row(), **choices, "command": command}) == "right"


def test_a_rope_that_breaks_alone_presses_itself_and_no_neighbour(bench: Bench) -> None:
    choices = {
        "break": "breaks",
        "contact": "of the rope with itself",
        "fidelity": "torsional",
        "level": "draft",
    }
    assert judge_row(bench, {**default_row(), **choices}) == "right"


@pytest.mark.parametrize(
    "refusal", REFUSALS, ids=lambda refusal: " with ".join(name for name, _ in refusal)
)
def test_choices_that_exclude_each_other_are_refused_in_a_sentence(
    refusal: tuple[Choices, ...], bench: Bench
) -> None:
    row = {
        **default_row(),
        "level": "draft",
        **{factor: choices[-1] for factor, choices in refusal},
    }
    file = bench.folder / "hoist.toml"
    file.write_text(text_of(row), encoding="utf-8")
    assert bench.call(row, "wind", str(file), "--in-process", "--check").code == REFUSED
