"""The run as Markdown with PNG figures, to quote and to compare line by line; html has the page to look at."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hoist_demo.parameters import ASSUMED_DATA
from hoist_demo.report.html.parameter_tables import Table
from hoist_demo.report.rows import CAUSE, WARNING, SummaryRow

SAID_FIRST = {CAUSE: "Stopped.", WARNING: "Warning."}  #: Rows that stand above everything, and the word before them.

CAPTIONS = {
    "tracking": "Motion of both conveyances against the reference of the left one.",
    "forces": "Motor torque and power, brake torque, head rope tensions and their ratio on the sheave.",
    "loop": "Pull of the balance rope, its loop, clearances and largest stresses.",
    "shapes": "Balance rope in three projections at several instants; the axes are scaled differently.",
    "swivels": "Swivels at both ends; tinted where they slip, above for the left one, below for the right one.",
    "energies": "Energies, work and losses, and what each balance leaves over.",
    "exposure": "What each place in the rope went through; cycles are counted by the rainflow method.",
    "spectra": "Amplitudes of tension and torque at each place in the rope, over frequency.",
}


def write_report(
    path: Path, title: str, rows: Sequence[SummaryRow], figures: Sequence[Path], tables: Sequence[Table] = ()
) -> Path:
    """Write the report; the figures lie next to it, `tables` are the data the run was given."""
    path.write_text(render_markdown(title, rows, figures, tables), encoding="utf-8")
    return path


def render_markdown(
    title: str, rows: Sequence[SummaryRow], figures: Sequence[Path], tables: Sequence[Table] = ()
) -> str:
    """The report as Markdown, figures by file name; on top why a run stopped and what to be warned of."""
    parts = [f"# {_inline(title)}"]
    parts += [f"**{SAID_FIRST[row.quantity]}** {_inline(row.text)}" for row in rows if row.quantity in SAID_FIRST]
    parts.append(ASSUMED_DATA)
    shown = [row for row in rows if row.quantity not in SAID_FIRST]
    for group in dict.fromkeys(row.group for row in shown):
        table = [f"## {_inline(group)}", "", "| quantity | value | unit |", "|---|---:|---|"]
        table += [
            f"| {_cell(row.quantity)} | {_cell(row.text)} | {_cell(row.unit)} |" for row in shown if row.group == group
        ]
        parts.append("\n".join(table))
    parts.append("## Figures")
    parts += [f"![{_caption(path)}]({path.name})\n\n{_caption(path)}" for path in figures]
    for name, lines in tables:
        table = [f"## Data: {_inline(name)}", "", "| parameter | value | unit | status |", "|---|---:|---|---|"]
        table += [f"| {' | '.join(map(_cell, (*line, '')[:4]))} |" for line in lines]
        parts.append("\n".join(table))
    return "\n\n".join(parts) + "\n"


def _cell(text: str) -> str:
    return _inline(text).replace("|", "\\|").replace("\n", " ")


def _inline(text: str) -> str:
    """Text of which no browser makes an element."""
    return text.replace("<", "&lt;")


def _caption(path: Path) -> str:
    return CAPTIONS.get(path.stem, path.stem)
