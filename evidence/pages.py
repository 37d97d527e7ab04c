"""Every page of evidence, and every table of it in a hand-written page: data in docs/data, text and figures.

Text and figures follow from the recorded data alone, so ``publish`` and ``fill`` write them anew without a run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from evidence.chart.figures import FIGURES as CHART
from evidence.chart.levels import block as levels
from evidence.chart.page import page as chart_page
from evidence.choice.page import page as choice_page
from evidence.contact.page import page as contact_page
from evidence.coupling.figures import FIGURES as COUPLING
from evidence.coupling.page import page as coupling_page
from evidence.discrete_rod.page import page as reference_solver_page
from evidence.drawing import draw_to
from evidence.guards.page import FIGURES as GUARDS
from evidence.guards.page import page as guards_page
from evidence.hoist.page import cases
from evidence.integrators.page import FIGURES as INTEGRATORS
from evidence.integrators.page import page as integrators_page
from evidence.knowledge.catalogue import catalogue
from evidence.latency.figures import FIGURES as LATENCY
from evidence.latency.page import page as latency_page
from evidence.mesh_rule.page import FIGURES as MESH_RULE
from evidence.mesh_rule.page import page as mesh_rule_page
from evidence.peer.figures import FIGURES as PEER
from evidence.peer.page import page as peer_page
from evidence.promise.page import FIGURES as PROMISE
from evidence.promise.page import page as promise_page
from evidence.rendering import DOCS, fill_block, write_page
from evidence.reproduction.page import FIGURES as REPRODUCTION
from evidence.reproduction.page import page as reproduction_page
from evidence.stability.page import anchor, chapter, front
from evidence.stability.suite import CHAPTERS
from evidence.studies.page import controllers_page, metrics, swivel_page
from evidence.tables import Tables, read
from evidence.tangle.page import FIGURES as TANGLE
from evidence.tangle.page import page as tangle_page
from evidence.validation.page import page as validation_page


@dataclass(frozen=True)
class Page:
    """``data`` is the folder in docs/data that it is made from, and that in docs/images of the figures."""

    file: str  # in docs
    data: str
    text: Callable[[Tables], str]
    figures: Mapping[str, Callable[[Tables], Figure]] = field(default_factory=dict)


def _stability() -> dict[str, Page]:
    """The front page, and one per chapter."""
    names = {f"stability/{anchor(heading)}": module for module, heading in CHAPTERS.items()}
    parts = {name: Page(f"{name}.md", "stability", partial(chapter, module=module)) for name, module in names.items()}
    return {"stability": Page("stability.md", "stability", front), **parts}


PAGES: dict[str, Page] = {
    "chart": Page("chart.md", "chart", chart_page, CHART),
    "choice": Page("choice.md", "choice", choice_page),
    "contact": Page("contact.md", "contact", contact_page),
    "coupling": Page("coupling.md", "coupling", coupling_page, COUPLING),
    "guards": Page("guards.md", "guards", guards_page, GUARDS),
    "integrators": Page("integrators.md", "integrators", integrators_page, INTEGRATORS),
    "mesh_rule": Page("mesh_rule.md", "mesh_rule", mesh_rule_page, MESH_RULE),
    "promise": Page("promise.md", "promise", promise_page, PROMISE),
    "latency": Page("latency.md", "latency", latency_page, LATENCY),
    "peer": Page("peer.md", "peer", peer_page, PEER),
    "reference_solver": Page("reference_solver.md", "reference_solver", reference_solver_page),
    "reproduction": Page("reproduction.md", "reproduction", reproduction_page, REPRODUCTION),
    **_stability(),
    "tangle": Page("tangle.md", "tangle", tangle_page, TANGLE),
    "study_controllers": Page("study_controllers.md", "study", controllers_page),
    "study_swivel": Page("study_swivel.md", "study", swivel_page),
    "validation": Page("validation.md", "validation", validation_page),
}


@dataclass(frozen=True)
class Block:
    """What stands between the marks ``mark`` of a hand-written page."""

    file: str  # beside docs
    mark: str
    data: str  # folder in docs/data
    text: Callable[[Tables], str]


BLOCKS = {
    "levels": Block("README.md", "levels", "chart", levels),
    "cases": Block("docs/howto/hoist.md", "cases", "hoist", cases),
    "metrics": Block("docs/reference/files.md", "metrics", "study", metrics),
    "catalogue": Block("docs/howto/rope_data.md", "catalogue", "knowledge", catalogue),
}


def page_text(page: Page, docs: Path = DOCS) -> str:
    """The text, from the data in ``docs``."""
    return page.text(read(docs / "data" / page.data))


def fill(block: Block, docs: Path = DOCS) -> Path:
    """Write the block into its page, from the data in ``docs``; the page."""
    path = docs.resolve().parent / block.file
    text = fill_block(path.read_text(encoding="utf-8"), block.mark, block.text(read(docs / "data" / block.data)))
    path.write_text(text, encoding="utf-8")
    return path


def publish(page: Page, docs: Path = DOCS) -> list[Path]:
    """Write text and figures from the data in ``docs``; the files written."""
    tables = read(docs / "data" / page.data)
    written = [write_page(page.file, page.text(tables), docs)]
    for name, draw in page.figures.items():
        written.append(docs / "images" / page.data / f"{name}.png")
        draw_to(written[-1], draw, tables)
    return written
