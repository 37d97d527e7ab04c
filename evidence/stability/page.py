"""docs/stability.md and the pages in docs/stability from the tables ``claims`` and ``scenes``; and their figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from evidence.claims import Measurement
from evidence.rendering import number, render
from evidence.tables import Table, Tables, table, write

from .entry import Entry, Figure, Finding
from .suite import CHAPTERS, chapters

SECTIONS = "stability"
COUNTEREXAMPLE, OURS = "counterexample", "ours"
CLAIMS = ("scene", "side", "what", "value", "unit", "relation", "bound")
SCENES = ("scene", "message", "figure")


# tables


def sides(finding: Finding) -> dict[str, Sequence[Measurement]]:
    """The claims of a finding by whom they are about."""
    return {COUNTEREXAMPLE: finding.counterexample, OURS: finding.ours}


def tables_of(findings: Mapping[str, Finding], before: Tables | None = None) -> Tables:
    """The findings by the entries' keys as tables, in the suite's order; of other entries what was there ``before``."""
    claims = [
        (key, side, m.what, m.value, m.unit, m.relation, m.bound)
        for key, finding in findings.items()
        for side, group in sides(finding).items()
        for m in group
    ]
    scenes = [(key, f.message, f.figure.title if f.figure else "") for key, f in findings.items()]
    return {
        "claims": _in_order(CLAIMS, claims, before["claims"] if before else None),
        "scenes": _in_order(SCENES, scenes, before["scenes"] if before else None),
    }


def _in_order(columns: Sequence[str], new: Sequence[tuple[Any, ...]], before: Table | None) -> Table:
    """New rows, and the old ones of entries without a new one, in the suite's order of entries."""
    order = [entry.key for part in chapters().values() for entry in part]
    rows = list(new)
    if before is not None:
        rows += [row for row in _rows(before, columns) if row[0] not in {key for key, *_ in new}]
    return table(columns, sorted(rows, key=lambda row: order.index(row[0])))


def _rows(t: Table, columns: Sequence[str]) -> Iterator[tuple[Any, ...]]:
    return zip(*(t[name].tolist() for name in columns), strict=True)


def claims_of(t: Table, key: str) -> list[tuple[str, Measurement]]:
    """The claims of an entry, each with the side that it is about."""
    return [(side, Measurement(*claim)) for scene, side, *claim in _rows(t, CLAIMS) if scene == key]


# pages


def claim(m: Measurement) -> str:
    """The value against its bound."""
    unit = "" if m.unit == "1" else f" {m.unit}"
    return f"{number(m.value, '.4g')}{unit} {m.relation} {number(m.bound, 'g')}{unit}"


def anchor(title: str) -> str:
    """As GitHub makes it."""
    return "".join(c for c in title.lower().replace(" ", "-") if c.isalnum() or c == "-")


def front(tables: Tables) -> str:
    """The first page: the table, then how to read it."""
    rows = [_summary(tables["claims"], heading, e) for heading, part in chapters().items() for e in part]
    return render("stability/stability.md.j2", {"summary": rows, "counterexample": COUNTEREXAMPLE})


def _summary(t: Table, heading: str, entry: Entry) -> tuple[str, ...]:
    """The first claim of either side."""
    claims = claims_of(t, entry.key)
    first = [next(m for side, m in claims if side == wanted) for wanted in (COUNTEREXAMPLE, OURS)]
    cells = [f"{m.what}: {number(m.value, '.4g')}{'' if m.unit == '1' else ' ' + m.unit}" for m in first]
    place = f"{SECTIONS}/{anchor(heading)}.md#{anchor(entry.title)}"
    return f"[{entry.title}]({place})", *cells, "yes" if all(m.holds for _, m in claims) else "**no**"


def chapter(tables: Tables, module: str) -> str:
    """The page of a chapter, by the module of its entries."""
    messages = {key: (message, figure) for key, message, figure in _rows(tables["scenes"], SCENES)}
    scenes = {}
    for entry in chapters()[CHAPTERS[module]]:
        message, figure = messages[entry.key]
        claims = [
            (side, m.what, claim(m), "yes" if m.holds else "**no**")
            for side, m in claims_of(tables["claims"], entry.key)
        ]
        scenes[entry.key] = {"title": entry.title, "claims": claims, "message": message, "figure": figure}
    return render(f"stability/{module}.md.j2", {"scenes": scenes})


# figures


def illustrate(entry: Entry, finding: Finding, docs: Path) -> None:
    """Figure and data of an entry, if it has one."""
    if finding.figure is not None:
        draw(finding.figure, docs / "images" / SECTIONS / f"{entry.key}.png")
        write({entry.key: points(finding.figure)}, docs / "data" / SECTIONS)


def points(figure: Figure) -> Table:
    """The curves, one point per row."""
    rows = [
        (curve.label, float(x), float(y))
        for curve in figure.curves
        for x, y in zip(np.asarray(curve.x), np.asarray(curve.y), strict=True)
    ]
    return table(("curve", figure.x_label, figure.y_label), rows)


def draw(figure: Figure, path: Path) -> None:
    """The figure as a PNG."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with plt.rc_context({"font.size": 10, "axes.titlesize": 10.5}):
        fig, ax = plt.subplots(figsize=(8.0, 4.2), layout="constrained")
        for curve in figure.curves:
            ax.plot(curve.x, curve.y, curve.style, label=curve.label, markersize=10 if curve.style == "*" else 5)
        ax.set(title=figure.title, xlabel=figure.x_label, ylabel=figure.y_label)
        if figure.log_x:
            ax.set_xscale("log")
        if figure.log_y:
            ax.set_yscale("log")
        ax.grid(alpha=0.3)
        ax.legend()
        fig.savefig(path, dpi=110)
        plt.close(fig)
