"""Every claim of the stability suite: that the counterexample breaks, and that ours holds."""

from __future__ import annotations

import re

import pytest

from evidence.claims import Measurement
from evidence.rendering import DOCS
from evidence.stability.entry import Entry, Finding
from evidence.stability.page import COUNTEREXAMPLE, OURS, SECTIONS, anchor, chapter, claim, claims_of, tables_of
from evidence.stability.suite import CHAPTERS, chapters, entries
from evidence.tables import read

TABLES = read(DOCS / "data" / SECTIONS)


@pytest.mark.parametrize(
    "entry", [pytest.param(e, id=e.key, marks=[pytest.mark.slow] if e.slow else []) for e in entries()]
)
def test_the_counterexample_breaks_and_ours_holds(entry: Entry) -> None:
    finding = entry.measure()
    assert finding.counterexample
    assert finding.ours
    failed = [f"{m.what}: {claim(m)}" for m in (*finding.counterexample, *finding.ours) if not m.holds]
    assert finding.holds, f"{entry.key}: {'; '.join(failed)}"


def test_keys_and_titles_name_one_entry_each() -> None:
    for names in ([e.key for e in entries()], [anchor(e.title) for e in entries()]):
        assert len(set(names)) == len(names)


def test_not_a_number_holds_no_claim() -> None:
    for relation in ("<", ">"):
        assert not Measurement("", float("nan"), "1", relation, 0.0).holds  # type: ignore[arg-type]


def test_every_scene_has_its_place_on_its_chapters_page_in_the_suites_order() -> None:
    for module, heading in CHAPTERS.items():
        titles = re.findall(r"^## (.*)$", chapter(TABLES, module), flags=re.MULTILINE)
        assert titles == [entry.title for entry in chapters()[heading]]


def test_a_scene_measured_anew_replaces_its_rows_only() -> None:
    claim_of = Measurement("what", 1.0, "m", "<", 2.0)
    tables = tables_of({"locking": Finding((claim_of,), (claim_of,), message="told")}, TABLES)
    assert claims_of(tables["claims"], "locking") == [(COUNTEREXAMPLE, claim_of), (OURS, claim_of)]
    assert claims_of(tables["claims"], "hourglass") == claims_of(TABLES["claims"], "hourglass")
    assert list(tables["scenes"]["scene"]) == [entry.key for entry in entries()]
