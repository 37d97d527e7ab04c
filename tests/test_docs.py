"""Links in README and docs lead to files and headings that are there, as GitHub counts them."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
LINK = re.compile(r"\]\((?!https?:)([^)\s]*)\)")


def anchor(heading: str) -> str:
    """As GitHub makes it."""
    text = re.sub(r"\[(.*?)\]\(.*?\)", r"\1", heading).strip().lower().replace(" ", "-")
    return "".join(c for c in text if c.isalnum() or c in "-_")


@cache
def text_of(path: Path) -> str:
    """Without blocks of code."""
    return re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)


@cache
def anchors(path: Path) -> frozenset[str]:
    return frozenset(anchor(heading) for heading in re.findall(r"^#+ (.*)$", text_of(path), re.MULTILINE))


def broken_links(path: Path) -> list[str]:
    """Links of a page that lead nowhere."""
    found = []
    for link in LINK.findall(text_of(path)):
        name, _, place = link.partition("#")
        target = (path.parent / name) if name else path
        if not target.exists() or (place and place not in anchors(target)):
            found.append(link)
    return found


@pytest.mark.parametrize("path", PAGES, ids=[str(path.relative_to(ROOT)) for path in PAGES])
def test_links_lead_somewhere(path: Path) -> None:
    assert broken_links(path) == []


def test_a_broken_link_is_seen(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# Here\n[a](#here) [b](#there) [c](page.md#here) [d](none.md)\n", encoding="utf-8")
    assert broken_links(page) == ["#there", "none.md"]


def test_every_page_is_in_the_site_s_navigation() -> None:
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    trees = "\n".join(re.findall(r"```\{toctree\}\n(.*?)```", index, re.DOTALL))
    listed = {re.sub(r".* <(.*)>", r"\1", line) for line in trees.splitlines()}
    pages = {str(path.relative_to(ROOT / "docs").with_suffix("")) for path in PAGES[1:]}
    assert pages - listed == {"index"}
