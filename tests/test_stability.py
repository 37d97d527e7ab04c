"""Every claim of the stability suite: that the twin breaks, and that ours holds."""

from __future__ import annotations

import pytest

from benchmarks.stability.entry import Entry, Measured
from benchmarks.stability.page import anchor, claim
from benchmarks.stability.suite import entries


@pytest.mark.parametrize(
    "entry", [pytest.param(e, id=e.key, marks=[pytest.mark.slow] if e.slow else []) for e in entries()]
)
def test_the_twin_breaks_and_ours_holds(entry: Entry) -> None:
    finding = entry.measure()
    assert finding.twin
    assert finding.ours
    failed = [f"{m.what}: {claim(m)}" for m in (*finding.twin, *finding.ours) if not m.holds]
    assert finding.holds, f"{entry.key}: {'; '.join(failed)}"


def test_keys_and_titles_name_one_entry_each() -> None:
    for names in ([e.key for e in entries()], [anchor(e.title) for e in entries()]):
        assert len(set(names)) == len(names)


def test_not_a_number_holds_no_claim() -> None:
    for relation in ("<", ">"):
        assert not Measured("", float("nan"), "1", relation, 0.0).holds  # type: ignore[arg-type]
