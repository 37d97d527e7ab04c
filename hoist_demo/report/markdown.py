"""The run as Markdown with PNG figures, to quote and to compare line by line.

Html has the page to look at.
"""

from collections.abc import Sequence
from pathlib import Path

from hoist_demo.parameters import ASSUMED_DATA
from hoist_demo.report.rows import CHANGED, Report, rows_by_group
from hoist_demo.report.verdict_row import COLUMNS

CAPTIONS = {
    "tracking": "Motion of both conveyances against the reference of the left one.",
    "forces": "Motor torque and power, brake torque, head rope tensions and their ratio on the "
    "sheave.",
    "loop": "Pull of the balance rope, its loop, clearances and largest stresses.",
    "shapes": "Balance rope from the front and the side at several instants; the axes are scaled "
    "differently.",
    "swivels": "Swivels at both ends; tinted where they slip, above for the left one, below for "
    "the right one.",
    "energies": "Energies, work and losses, and what each balance leaves over.",
}


def render_markdown(report: Report, figures: Sequence[Path]) -> str:
    """Return the report as Markdown: verdict, figures by file name, and the rest."""
    verdict = report.verdict
    parts = [f"# {_inline(report.title)}", f"**{_inline(verdict.summary)}**"]
    parts += _table(COLUMNS, [row.cells for row in verdict.rows])
    parts += [f"**Warning.** {_inline(text)}" for text in verdict.remarks]
    changed_title, changed_rows = report.changed
    parts += _table(CHANGED, changed_rows, changed_title)
    parts.append(ASSUMED_DATA)
    parts += [f"![{_caption(path)}]({path.name})\n\n{_caption(path)}" for path in figures]
    for group, rows in rows_by_group(report.rows).items():
        cells = [(row.quantity, row.text, row.unit) for row in rows]
        parts += _table(("quantity", "value", "unit"), cells, group)
    for name, lines in report.data_tables:
        parts += _table(("parameter", "value", "unit", "status"), lines, f"Data: {name}")
    return "\n\n".join(parts) + "\n"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], title: str = "") -> list[str]:
    """Return a heading and a table, nothing without rows; a row that is short has empty cells."""
    if not rows:
        return []
    rule = "|---|---:" + "|---" * (len(head) - 2) + "|"
    lines = [_line(head), rule]
    lines += [_line((*row, "")[: len(head)]) for row in rows]
    table = "\n".join(lines)
    return [f"## {_inline(title)}", table] if title else [table]


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(map(_cell, cells))} |"


def _cell(text: str) -> str:
    return _inline(text).replace("|", "\\|").replace("\n", " ")


def _inline(text: str) -> str:
    """Escape ``<``, so that no browser makes an element of the text."""
    return text.replace("<", "&lt;")


def _caption(path: Path) -> str:
    return CAPTIONS.get(path.stem, path.stem)
