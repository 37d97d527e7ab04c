"""Every claim of the stability suite: that the counterexample breaks, and that ours holds."""

from __future__ import annotations

import pytest

from evidence.claims import Measurement
from evidence.rendering import DOCS
from evidence.stability.entry import Entry
from evidence.stability.measure import CHAPTERS, missed
from evidence.tables import read

ENTRIES = [entry for part in CHAPTERS.values() for entry in part]


@pytest.mark.parametrize(
    "entry", [pytest.param(e, id=e.key, marks=[pytest.mark.slow] if e.slow else []) for e in ENTRIES]
)
def test_the_counterexample_breaks_and_ours_holds(entry: Entry) -> None:
    finding = entry.measure()
    assert finding.counterexample
    assert finding.ours
    failed = [m for m in (*finding.counterexample, *finding.ours) if not m.holds]
    assert finding.holds, f"{entry.key}: {failed}"


def test_not_a_number_holds_no_claim() -> None:
    for relation in ("<", ">"):
        assert not Measurement("", float("nan"), "1", relation, 0.0).holds  # type: ignore[arg-type]


def test_no_recorded_claim_is_missed_and_a_wrong_one_would_be() -> None:
    recorded = read(DOCS / "data" / "stability")
    assert list(missed(recorded)) == []
    wrong = {**recorded["claims"], "value": -recorded["claims"]["value"]}
    assert any("locking" in claim for claim in missed({**recorded, "claims": wrong}))
