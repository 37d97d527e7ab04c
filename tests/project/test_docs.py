"""README and docs: links lead to files and headings that are there, as GitHub counts them; commands can be found."""

import ast
import re
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from checkout import ROOT

from docs.drawings.figures import FIGURES
from rope_model.codegen.build import sources as engine_sources

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
DOCS = ROOT / "docs"
COMMANDS = [
    ROOT / "README.md",
    DOCS / "reference" / "python.md",
    *sorted((DOCS / "tutorial").glob("*.md")),
]
#: what ``make demo`` puts into .venv/bin, and what a shell has built in
INSTALLED = ("balance-rope", "python")
BUILTIN = ("source", "cd")
LINK = re.compile(r"\]\((?!https?:)([^)\s]*)\)")


@cache
def text_of(path: Path) -> str:
    """Without blocks of code."""
    return re.sub(
        r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL
    )


@cache
def anchors(path: Path) -> frozenset[str]:
    """Of a page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", text_of(path), re.MULTILINE)
    return frozenset(map(anchor, headings))


def anchor(heading: str) -> str:
    text = re.sub(r"\[(.*?)\]\(.*?\)", r"\1", heading).strip().lower().replace(" ", "-")
    return "".join(c for c in text if c.isalnum() or c in "-_")


#: scripts of another project, whose names begin with this
ELSEWHERE = "scripts/"


def test_the_readme_of_the_tests_lists_each_helper_once() -> None:
    text = (ROOT / "tests" / "README.md").read_text(encoding="utf-8")
    _, section = text.split("## Helpers\n")
    section, *_ = section.split("\n## ")
    listed = [name for row in section.splitlines()[3:] for name in row.split("|")[1:2]]
    names = re.findall(r"`(\w+)`", "".join(listed))
    helpers = [path for path in (ROOT / "tests" / "helpers").iterdir() if path.name[0] not in "_."]
    assert sorted(names) == sorted(path.stem for path in helpers)


@cache
def source_paths() -> tuple[str, ...]:
    """Paths of the sources, each from the top of the checkout."""
    folders = ("rope_model", "fmu_src", "hoist_demo", "evidence", "benchmarks", "release")
    found = []
    for folder in (*folders, "examples", "docs", "tests"):
        found += [path.relative_to(ROOT).as_posix() for path in (ROOT / folder).rglob("*.*")]
    return tuple(found)


@pytest.mark.parametrize("path", PAGES, ids=[str(path.relative_to(ROOT)) for path in PAGES])
def test_a_source_that_a_page_names_is_there(path: Path) -> None:
    named = re.findall(
        r"`([\w./-]*\w\.(?:py|c|inc)|[\w./-]+/\w+\.h)`", path.read_text(encoding="utf-8")
    )
    lost = [
        name
        for name in named
        if not name.startswith(ELSEWHERE)
        and not any(source == name or source.endswith("/" + name) for source in source_paths())
    ]
    assert lost == []


#: names of a source, as in "``a``, ``b`` and ``FN(c)`` of ``folder/file.c``"
_NAMES_OF_A_SOURCE = re.compile(
    r"((?:`[\w.()]+`(?:, | and |, and )?)+) (?:of|in) `([\w./]+\.(?:py|c|h|inc))`"
)


@pytest.mark.parametrize("path", PAGES, ids=[str(path.relative_to(ROOT)) for path in PAGES])
def test_a_name_that_a_page_finds_in_a_source_is_there(path: Path) -> None:
    text = " ".join(path.read_text(encoding="utf-8").split())
    lost = []
    for names, source in _NAMES_OF_A_SOURCE.findall(text):
        found = [one for one in source_paths() if one == source or one.endswith("/" + source)]
        code = "".join((ROOT / one).read_text(encoding="utf-8") for one in found)
        for name in re.findall(r"`([\w.()]+)`", names):
            if name.endswith(SUFFIXES):
                continue  # a file that the sentence names before
            word = name.rpartition(".")[2]
            either = "|".join(map(re.escape, (word, re.sub(r"\(.*\)", "", word))))
            if not re.search(rf"(?<!\w)(?:{either})(?!\w)", code):
                lost.append((name, source))
    assert lost == []


#: generated files that comments of C name, beside those of the engine
GENERATED = ("access.h", "drive_table.h", "numbers.h", "start.c", "structures.h", "variables.c")
#: headers of the standard, whose comments name files of its earlier versions
OFFICIAL = "fmu_src/shell/headers/"


def test_a_source_that_a_comment_of_c_names_is_there() -> None:
    written = (path.rpartition("/")[2] for path in source_paths())
    names = {*written, *engine_sources(), *GENERATED}
    lost = [
        (source, name)
        for source in source_paths()
        if source.endswith((".c", ".h", ".inc")) and not source.startswith(OFFICIAL)
        for comment in re.findall(
            r"/\*.*?\*/", (ROOT / source).read_text(encoding="utf-8"), re.DOTALL
        )
        for name in re.findall(r"\b(\w+\.(?:c|h|inc|py))\b", comment)
        if name not in names
    ]
    assert lost == []


@pytest.mark.parametrize("path", PAGES, ids=[str(path.relative_to(ROOT)) for path in PAGES])
def test_links_lead_somewhere_code_is_python_and_merges_are_complete(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert not re.search(r"^([<>]{7} |=======$)", text, re.MULTILINE)
    for block in re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        ast.parse(block)
    for link in LINK.findall(text_of(path)):
        name, _, place = link.partition("#")
        target = path
        if name:
            target = path.parent / name
        assert target.exists(), link
        assert not place or place in anchors(target), link


@pytest.mark.parametrize("path", COMMANDS, ids=[path.name for path in COMMANDS])
def test_commands_are_found_where_they_stand(path: Path) -> None:
    """Those in blocks without a language, by a shell in a checkout."""
    active = False
    for language, block in re.findall(
        r"^```([^\n]*)\n(.*?)^```$", path.read_text("utf-8"), re.MULTILINE | re.DOTALL
    ):
        if language:
            continue
        for line in block.splitlines():
            word = line.partition(" ")[0]
            active |= line.startswith("source .venv/bin/activate")
            if word.removeprefix(".venv/bin/") in INSTALLED:
                assert active or word.startswith(".venv/bin/"), line
            else:
                assert word in BUILTIN or shutil.which(word), line


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_the_one_that_its_script_draws(name: str) -> None:
    assert (DOCS / "images" / name).read_text(encoding="utf-8") == FIGURES[name]().svg()


ENTRIES = re.findall(
    r"^### `+ ?(.*?) ?`+$", (DOCS / "reference" / "messages.md").read_text(encoding="utf-8"), re.M
)
SUFFIXES = (".py", ".c", ".h", ".inc")


def sources() -> Iterator[str]:
    for folder in ("rope_model", "fmu_src", "hoist_demo"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in SUFFIXES:
                yield path.read_text(encoding="utf-8")


#: all sources as one text, with literals that are joined and gaps for numbers and names alike
SOURCES = "\n".join(sources())
TEXTS = re.sub(r"\"\s*\n\s*r?f?\"", "", SOURCES)


@pytest.mark.parametrize("entry", ENTRIES)
def test_an_entry_speaks_of_a_message_that_there_is(entry: str) -> None:
    parts = [part.strip() for part in entry.split("…") if len(part.strip()) > 3]
    assert len(re.findall(r"[A-Za-z]+", entry)) >= 3
    assert [part for part in parts if part not in TEXTS] == []
