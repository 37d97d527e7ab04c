"""Pages of evidence: what the recorded data make of the templates, and how numbers are printed."""

from __future__ import annotations

import shutil
from pathlib import Path

import jinja2
import pytest

from evidence.pages import BLOCKS, PAGES, fill, page_text
from evidence.rendering import DOCS, fill_block, render


@pytest.mark.parametrize("name", PAGES)
def test_every_page_is_the_one_that_the_recorded_data_make(name: str) -> None:
    assert (DOCS / PAGES[name].file).read_text(encoding="utf-8") == page_text(PAGES[name])


@pytest.mark.parametrize("name", BLOCKS)
def test_every_table_in_a_hand_written_page_is_the_one_that_the_recorded_data_make(name: str, tmp_path: Path) -> None:
    block = BLOCKS[name]
    written = (DOCS.parent / block.file).read_text(encoding="utf-8")
    shutil.copytree(DOCS / "data" / block.data, tmp_path / "docs" / "data" / block.data)
    (tmp_path / block.file).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / block.file).write_text(written, encoding="utf-8")
    assert fill(block, tmp_path / "docs").read_text(encoding="utf-8") == written


def test_a_number_that_the_data_do_not_have_is_an_error() -> None:
    with pytest.raises(jinja2.UndefinedError, match="levels"):
        render("chart/levels.md.j2", {"form": "compiled"})


def test_a_block_is_filled_in_between_its_marks_only() -> None:
    assert fill_block("x\n<!-- a -->\nold\n<!-- /a -->\ny\n", "a", "new\n") == "x\n<!-- a -->\nnew\n<!-- /a -->\ny\n"
    with pytest.raises(ValueError, match="must have one place for b"):
        fill_block("x\n<!-- a -->\n<!-- /a -->\n", "b", "new")
