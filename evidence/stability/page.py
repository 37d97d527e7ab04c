"""The page docs/stability.md and those in docs/stability, with their figures and data."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from evidence.claims import Measured

from .entry import Entry, Figure, Finding

DOCS = Path(__file__).parents[2] / "docs"

OPENING = """\
# Where plausible methods break

Scenes in which a plausible method fails, and what this project's method does there; the first claim of each:
"""
CLOSING = """\
These pages are written by `make stability`; do not edit them. `tests/test_stability.py` asserts every number on them.

Each scene is one in which a common choice, the obvious simplification, or the formula as printed fails. The failing
method is run here as a counterexample that differs from ours in this one thing, and its numbers are claims that it
breaks. The numbers under *ours* are claims that this project's method holds in the same scene or, where it does not,
that it stops with a message and keeps its last state. Bounds come from the theory; comments in `evidence/stability`
say how. The limits that no method here overcomes are in [the model](model.md#what-limits-it).
"""
SECTIONS = "stability"
COUNTEREXAMPLE = "counterexample"


def number(x: float) -> str:
    """Four digits."""
    return f"{x:.4g}"


def claim(m: Measured) -> str:
    """The value against its bound."""
    unit = "" if m.unit == "1" else f" {m.unit}"
    return f"{number(m.value)}{unit} {m.relation} {m.bound:g}{unit}"


def summary(heading: str, entry: Entry, finding: Finding) -> str:
    """Row of the table: the first claim of either side."""
    cells = [f"{m.what}: {number(m.value)}{'' if m.unit == '1' else ' ' + m.unit}" for m in first_claims(finding)]
    place = f"{SECTIONS}/{anchor(heading)}.md#{anchor(entry.title)}"
    return f"| [{entry.title}]({place}) | {' | '.join(cells)} | {'yes' if finding.holds else '**no**'} |"


def first_claims(finding: Finding) -> tuple[Measured, Measured]:
    return finding.counterexample[0], finding.ours[0]


def anchor(title: str) -> str:
    """As GitHub makes it."""
    return "".join(c for c in title.lower().replace(" ", "-") if c.isalnum() or c == "-")


def section(entry: Entry, finding: Finding) -> str:
    """Text, numbers and figure of an entry."""
    rows = [
        f"| {side} | {m.what} | {claim(m)} | {'yes' if m.holds else '**no**'} |"
        for side, claims in ((COUNTEREXAMPLE, finding.counterexample), ("ours", finding.ours))
        for m in claims
    ]
    parts = [
        f"## {entry.title}",
        entry.scene,
        f"*Why it fails.* {entry.fails}",
        f"*Ours.* {entry.holds}",
        "\n".join(("| | measured | value and bound | holds |", "|---|---|---|---|", *rows)),
    ]
    if finding.message:
        parts.append(f"The message: `{finding.message}`")
    if finding.figure is not None:
        parts += [
            f"![{finding.figure.title}](../images/stability/{entry.key}.png)",
            f"[Data of the figure](../data/stability/{entry.key}.csv)",
        ]
    return "\n\n".join(parts)


def front(chapters: Mapping[str, tuple[Entry, ...]], findings: Mapping[str, Finding]) -> str:
    """The first page: the table, then how to read it."""
    rows = [summary(heading, e, findings[e.key]) for heading, part in chapters.items() for e in part]
    table = "\n".join((f"| scene | {COUNTEREXAMPLE} | ours | as claimed |", "|---|---|---|---|", *rows))
    return "\n".join((OPENING, table, "", CLOSING))


def chapter(heading: str, entries: Sequence[Entry], findings: Mapping[str, Finding]) -> str:
    """The page of a chapter."""
    parts = [f"# {heading}", *(section(entry, findings[entry.key]) for entry in entries)]
    return "\n\n".join(x.strip() for x in parts) + "\n"


def write_pages(chapters: Mapping[str, tuple[Entry, ...]], findings: Mapping[str, Finding]) -> None:
    """docs/stability.md with the table, and a page per chapter in docs/stability."""
    (DOCS / "stability.md").write_text(front(chapters, findings), encoding="utf-8")
    (DOCS / SECTIONS).mkdir(exist_ok=True)
    for heading, entries in chapters.items():
        path = DOCS / SECTIONS / f"{anchor(heading)}.md"
        path.write_text(chapter(heading, entries, findings), encoding="utf-8")


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


def write_data(figure: Figure, path: Path) -> None:
    """The curves, one point per row, six digits."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("curve", figure.x_label, figure.y_label))
        for curve in figure.curves:
            for x, y in zip(np.asarray(curve.x).tolist(), np.asarray(curve.y).tolist(), strict=True):
                writer.writerow((curve.label, f"{x:.6g}", f"{y:.6g}"))


def illustrate(entry: Entry, finding: Finding) -> None:
    """Figure and data of an entry, if it has one."""
    if finding.figure is not None:
        draw(finding.figure, DOCS / "images" / "stability" / f"{entry.key}.png")
        write_data(finding.figure, DOCS / "data" / "stability" / f"{entry.key}.csv")
