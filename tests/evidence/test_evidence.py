"""Pages of evidence: what the recorded data make of the templates; claims of stability and coupling."""

import shutil
from itertools import chain
from pathlib import Path

import jinja2
import pytest
from shared import slow_if

from evidence.claims import Measurement, missed
from evidence.coupling.page import order, theory
from evidence.pages import BLOCKS, PAGES, fill, page_text
from evidence.rendering import DOCS, fill_block, render
from evidence.stability.entry import Entry
from evidence.stability.measure import CHAPTERS
from evidence.tables import read
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.cosimulation.schemes.stability import MARGIN


@pytest.mark.parametrize("name", PAGES)
def test_every_page_is_the_one_that_the_recorded_data_make(name: str) -> None:
    assert (DOCS / PAGES[name].file).read_text(encoding="utf-8") == page_text(PAGES[name])


@pytest.mark.parametrize("name", BLOCKS)
def test_every_table_in_a_hand_written_page_is_the_one_that_the_recorded_data_make(
    name: str, tmp_path: Path
) -> None:
    block = BLOCKS[name]
    written = (DOCS.parent / block.file).read_text(encoding="utf-8")
    for data in (block.data, *block.further):
        shutil.copytree(DOCS / "data" / data, tmp_path / "docs" / "data" / data)
    (tmp_path / block.file).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / block.file).write_text(written, encoding="utf-8")
    assert fill(block, tmp_path / "docs").read_text(encoding="utf-8") == written


def test_a_number_that_the_data_do_not_have_is_an_error() -> None:
    with pytest.raises(jinja2.UndefinedError, match="promise"):
        render("accuracy/readme.md.j2", {"form": "compiled"})


def test_a_block_is_filled_in_between_its_marks_only() -> None:
    assert (
        fill_block("x\n<!-- a -->\nold\n<!-- /a -->\ny\n", "a", "new\n")
        == "x\n<!-- a -->\nnew\n<!-- /a -->\ny\n"
    )
    with pytest.raises(ValueError, match="must have one place for b"):
        fill_block("x\n<!-- a -->\n<!-- /a -->\n", "b", "new")


TABLES = read(DOCS / "data" / "coupling")


@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_scheme_has_its_order_on_the_hoist_to_half_an_order_or_a_higher_one(
    scheme: str,
) -> None:
    assert order(TABLES["schemes"], scheme) > theory(scheme) - 0.5


def test_the_default_errs_by_less_than_half_a_percent_on_every_case_and_is_stable() -> None:
    t = TABLES["cases"]
    assert t["force error"].max() < 0.005
    assert t["predicted growth"].max() < MARGIN
    assert not any(str(cause) not in ("", "nan") for cause in t["cause"])


ENTRIES = [*chain.from_iterable(CHAPTERS.values())]


@pytest.mark.parametrize(
    "entry",
    [pytest.param(e, id=e.key, marks=slow_if(e.slow)) for e in ENTRIES],
)
def test_the_counterexample_breaks_and_ours_holds(entry: Entry) -> None:
    finding = entry.measure()
    assert finding.counterexample
    assert finding.ours
    assert not [m for m in (*finding.counterexample, *finding.ours) if not m.holds]


def test_not_a_number_holds_no_claim() -> None:
    for relation in ("<", ">"):
        assert not Measurement("", float("nan"), "1", relation, 0.0).holds  # type: ignore[arg-type]


def test_no_recorded_claim_is_missed_and_a_wrong_one_would_be() -> None:
    recorded = read(DOCS / "data" / "stability")
    assert list(missed(recorded)) == []
    wrong = {**recorded["claims"], "value": -recorded["claims"]["value"]}
    assert any("locking" in claim for claim in missed({**recorded, "claims": wrong}))
