"""Every page of evidence, and every table of it in a hand-written page: data in docs/data, text and figures.

Text and figures follow from the recorded data alone, so ``publish`` and ``fill`` write them anew without a run.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from matplotlib.figure import Figure

from evidence.accuracy.figures import FIGURES as CHART
from evidence.accuracy.page import page as accuracy_page
from evidence.accuracy.page import readme
from evidence.assumed_data.catalogue import catalogue
from evidence.assumed_data.page import page as data_page
from evidence.contact.page import page as contact_page
from evidence.drawing import draw_to
from evidence.promise.figures import FIGURES as PROMISE
from evidence.promise.page import page as promise_page
from evidence.rendering import DOCS, fill_block, markdown
from evidence.reproduction.page import FIGURES as REPRODUCTION
from evidence.reproduction.page import page as reproduction_page
from evidence.signals.block import block as signals
from evidence.stability.page import FIGURES as STABILITY
from evidence.stability.page import page as stability_page
from evidence.tables import Tables, read
from evidence.validation.page import page as validation_page
from hoist_demo.cases.rules import LENGTH, RULES
from hoist_demo.files.registry import host_parameters
from hoist_demo.parameters.quantity import UNBOUNDED, FileParameter
from hoist_demo.run.metrics import METRICS

#: front matter of a page outside the navigation
ORPHAN = "---\norphan: true\n---\n\n"


@dataclass(frozen=True)
class Page:
    """``data`` is the folder in docs/data that it is made from, and that in docs/images of the figures.

    Tables of ``further`` folders are named folder/table.  An ``orphan`` is reached by links, not by the navigation.
    """

    file: str  # in docs
    data: str
    text: Callable[[Tables], str]
    figures: Mapping[str, Callable[[Tables], Figure]] = field(default_factory=dict)
    further: tuple[str, ...] = ()
    orphan: bool = False


PAGES: dict[str, Page] = {
    "reproduction": Page("reproduction.md", "reproduction", reproduction_page, REPRODUCTION),
    "accuracy": Page(
        "accuracy.md", "accuracy", accuracy_page, CHART, ("latency", "exudyn", "promise")
    ),
    "promise": Page("promise.md", "promise", promise_page, PROMISE, orphan=True),
    "stability": Page("stability.md", "stability", stability_page, STABILITY, ("coupling",)),
    "validation": Page(
        "validation.md", "validation", validation_page, {}, ("contact", "discrete_rod", "exudyn")
    ),
    "contact": Page("contact.md", "contact", contact_page, orphan=True),
    "assumed_data": Page("assumed_data.md", "assumed_data", data_page),
}


@dataclass(frozen=True)
class Block:
    """The text between the marks ``mark`` of a hand-written page."""

    file: str  # beside docs
    mark: str
    data: str  # folder in docs/data
    text: Callable[[Tables], str]
    further: tuple[str, ...] = ()  # folders, as of a page


def _both(rows: Iterable[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Join the rows whose names differ in left and right alone."""
    alike: dict[tuple[str, ...], list[str]] = {}
    for name, *cells in rows:
        alike.setdefault((re.sub("left|right", "", name), *cells), []).append(name)
    return [(", ".join(names), *cells) for (_, *cells), names in alike.items()]


def metrics(tables: Tables) -> str:
    """Return the table of metrics; no data are needed."""
    return markdown(
        _both((f"`{name}`", unit, text) for name, (unit, text) in METRICS.items()),
        "name",
        "unit",
        "",
    )


RULED = {rule.key: rule.expression for rule in (LENGTH, *RULES)}


def rules(tables: Tables) -> str:
    """Return the table of what follows by rules."""
    return markdown(
        [(f"`{key}`", words) for key, words in RULED.items()],
        "key",
        "what it is where nobody gives it",
    )


def host(tables: Tables) -> str:
    """Return the table of the host's keys, with "none" of a part that a hoist need not have."""
    rows = []
    for p in host_parameters().values():
        meaning = ", ".join(filter(None, (p.meaning, " or ".join(p.choices))))
        bounds = "" if p.bounds == UNBOUNDED else p.bounds.description
        unit = "" if p.unit == "1" else p.unit
        rows.append((f"`{p.name}`", unit, _default(p), bounds, meaning))
    return markdown(_both(rows), "key", "unit", "default", "bounds", "meaning")


def _default(p: FileParameter) -> str:
    """Return the value of a key that the file leaves out, in words."""
    if p.name in RULED:
        return "by rule"
    value = str(p.start)
    if p.start is None:
        value = "none"
    elif isinstance(p.start, float):
        value = f"{p.start:.6g}"
    is_of_part = p.name.count(".") > 1
    if is_of_part:
        return f"none; {value}"
    return value


BLOCKS = {
    "levels": Block("README.md", "levels", "accuracy", readme, ("exudyn", "promise")),
    "metrics": Block("docs/reference/files.md", "metrics", "assumed_data", metrics),
    "rules": Block("docs/reference/files.md", "rules", "assumed_data", rules),
    "host": Block("docs/reference/files.md", "host", "assumed_data", host),
    "signals": Block("docs/howto/motion.md", "signals", "signals", signals),
    "catalogue": Block(
        "docs/howto/rope_data.md", "catalogue", "assumed_data", lambda tables: catalogue()
    ),
}


def tables(written: Page | Block, docs: Path = DOCS) -> Tables:
    """Read the data of a page or a block in ``docs``."""
    others = {
        f"{x}/{name}": t for x in written.further for name, t in read(docs / "data" / x).items()
    }
    return {**read(docs / "data" / written.data), **others}


def page_text(page: Page, docs: Path = DOCS) -> str:
    """Return the text, from the data in ``docs``."""
    return f"{ORPHAN if page.orphan else ''}{page.text(tables(page, docs))}"


def fill(block: Block, docs: Path = DOCS) -> Path:
    """Write the block into its page, from the data in ``docs``; return the page."""
    path = docs.resolve().parent / block.file
    text = fill_block(path.read_text(encoding="utf-8"), block.mark, block.text(tables(block, docs)))
    path.write_text(text, encoding="utf-8")
    return path


def publish(page: Page, docs: Path = DOCS) -> list[Path]:
    """Write text and figures from the data in ``docs``; return the files written."""
    data = tables(page, docs)
    written = [docs / page.file]
    written[0].write_text(page_text(page, docs), encoding="utf-8")
    for name, draw in page.figures.items():
        written.append(docs / "images" / page.data / f"{name}.png")
        draw_to(written[-1], draw, data)
    return written
