"""Entries of docs/reference/messages.md speak of messages that the product has."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "reference" / "messages.md").read_text(encoding="utf-8")
ENTRIES = re.findall(r"^### `+ ?(.*?) ?`+$", PAGE, re.M)
#: all sources as one text, with literals that are joined and gaps for numbers and names alike
SOURCES = "\n".join(
    path.read_text(encoding="utf-8")
    for folder in ("rope_model", "fmu_src", "hoist_demo")
    for path in sorted((ROOT / folder).rglob("*"))
    if path.suffix in (".py", ".c", ".h")
)
TEXTS = re.sub(r"\"\s*\n\s*r?f?\"", "", SOURCES)


@pytest.mark.parametrize("entry", ENTRIES)
def test_an_entry_speaks_of_a_message_that_there_is(entry: str) -> None:
    parts = [part.strip() for part in entry.split("…") if len(part.strip()) > 3]
    assert len(re.findall(r"[A-Za-z]+", entry)) >= 3
    assert [part for part in parts if part not in TEXTS] == []
