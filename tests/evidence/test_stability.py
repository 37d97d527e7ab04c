"""Every claim of the stability suite: that the counterexample breaks, and that ours holds."""

from __future__ import annotations

import re

import pytest

from evidence.claims import Measurement, text
from evidence.rendering import DOCS
from evidence.stability.entry import Entry
from evidence.stability.measure import CHAPTERS, missed
from evidence.stability.page import anchor
from evidence.tables import read

ENTRIES = [entry for part in CHAPTERS.values() for entry in part]
PAGE = (DOCS / "stability.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "entry", [pytest.param(e, id=e.key, marks=[pytest.mark.slow] if e.slow else []) for e in ENTRIES]
)
def test_the_counterexample_breaks_and_ours_holds(entry: Entry) -> None:
    finding = entry.measure()
    assert finding.counterexample
    assert finding.ours
    failed = [f"{m.what}: {text(m)}" for m in (*finding.counterexample, *finding.ours) if not m.holds]
    assert finding.holds, f"{entry.key}: {'; '.join(failed)}"


def test_keys_and_titles_name_one_entry_each() -> None:
    for names in ([e.key for e in ENTRIES], [anchor(e.title) for e in ENTRIES]):
        assert len(set(names)) == len(names)


def test_not_a_number_holds_no_claim() -> None:
    for relation in ("<", ">"):
        assert not Measurement("", float("nan"), "1", relation, 0.0).holds  # type: ignore[arg-type]


def test_every_scene_has_its_place_in_its_chapter_in_the_suites_order() -> None:
    for heading, part in CHAPTERS.items():
        chapter = re.split(r"^## ", PAGE.partition(f"\n## {heading}\n")[2], flags=re.MULTILINE)[0]
        titles = re.findall(r"^### (.*)$", chapter, flags=re.MULTILINE)
        assert titles[: len(part)] == [entry.title for entry in part]


def test_no_recorded_claim_is_missed_and_a_wrong_one_would_be() -> None:
    recorded = read(DOCS / "data" / "stability")
    assert list(missed(recorded)) == []
    wrong = {**recorded["claims"], "value": -recorded["claims"]["value"]}
    assert any("locking" in claim for claim in missed({**recorded, "claims": wrong}))
