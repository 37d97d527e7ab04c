"""Every claim of the stability suite: that the counterexample breaks, and that ours holds."""

from __future__ import annotations

import pytest

from evidence.claims import Measured
from evidence.stability.entry import Entry
from evidence.stability.page import CLOSING, DOCS, OPENING, SECTIONS, anchor, claim
from evidence.stability.suite import chapters, entries


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
        assert not Measured("", float("nan"), "1", relation, 0.0).holds  # type: ignore[arg-type]


def test_the_pages_have_every_scene_in_the_generator_s_words() -> None:
    table = (DOCS / "stability.md").read_text(encoding="utf-8")
    assert table.startswith(OPENING)
    assert table.endswith(CLOSING)
    for heading, part in chapters().items():
        name = f"{SECTIONS}/{anchor(heading)}.md"
        text = (DOCS / name).read_text(encoding="utf-8")
        for entry in part:
            assert f"| [{entry.title}]({name}#{anchor(entry.title)}) |" in table
            for words in (f"## {entry.title}\n", entry.scene, entry.fails, entry.holds):
                assert words in text, entry.key
