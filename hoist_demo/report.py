"""The run on one page: Markdown, and an HTML file that carries its figures within itself."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from pathlib import Path

from hoist_demo.parameters import ASSUMED_DATA
from hoist_demo.summary import SummaryRow

CAPTIONS = {
    "tracking": "Motion of both conveyances against the reference of the left one.",
    "forces": "Pull of the balance rope, head rope tensions, motor torque and safety against slip on the sheave.",
    "loop": "Lowest point of the balance rope's loop, its yaw and the clearance of the legs.",
    "shapes": "Balance rope in three projections at several instants; the axes are scaled differently.",
    "swivels": "Swivels at both ends; tinted where they slip, above for the left one, below for the right one.",
    "energies": "Energies, work and losses, and what each balance leaves over.",
}

_STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1080px; padding: 1.5rem 1rem 3rem; color: #222; background: #fff;
       font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; }
.note { border-left: 4px solid #d9731a; background: #fdf4ec; padding: .6rem .9rem; margin: 1rem 0; }
.stopped { border-color: #b03a2e; background: #fbeeec; }
.tables { columns: 2 420px; column-gap: 2.5rem; }
section { break-inside: avoid; margin-bottom: 1.2rem; }
section h3 { font-size: .95rem; margin: 0 0 .2rem; color: #1f5fa8; }
table { border-collapse: collapse; width: 100%; font-size: .88rem; }
td { padding: .22rem .3rem; border-bottom: 1px solid #e6e6e6; vertical-align: top; }
td.value { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
td.unit { width: 3.2rem; color: #666; white-space: nowrap; }
figure { margin: 1.5rem 0; }
img { width: 100%; height: auto; display: block; }
figcaption { font-size: .9rem; color: #555; }
"""


def write_report(directory: Path, title: str, rows: Sequence[SummaryRow], figures: Sequence[Path]) -> list[Path]:
    """Write report.md and report.html next to the figures and return their paths."""
    markdown, page = directory / "report.md", directory / "report.html"
    markdown.write_text(render_markdown(title, rows, figures), encoding="utf-8")
    page.write_text(render_html(title, rows, figures), encoding="utf-8")
    return [markdown, page]


def render_markdown(title: str, rows: Sequence[SummaryRow], figures: Sequence[Path]) -> str:
    """The report as Markdown, figures by file name."""
    parts = [f"# {title}", ASSUMED_DATA]
    for group, members in _groups(rows):
        table = [f"## {group}", "", "| quantity | value | unit |", "|---|---:|---|"]
        table += [f"| {_cell(row.quantity)} | {_cell(row.text)} | {row.unit} |" for row in members]
        parts.append("\n".join(table))
    parts.append("## Figures")
    parts += [f"![{_caption(path)}]({path.name})\n\n{_caption(path)}" for path in figures]
    return "\n\n".join(parts) + "\n"


def render_html(title: str, rows: Sequence[SummaryRow], figures: Sequence[Path]) -> str:
    """The report as one HTML page without any outside reference."""
    tables = "\n".join(_html_table(group, members) for group, members in _groups(rows))
    pictures = "\n".join(_html_figure(path) for path in figures)
    cause = next((row.text for row in rows if row.quantity == "cause"), "")
    stopped = f'<p class="note stopped"><strong>Stopped.</strong> {html.escape(cause)}</p>' if cause else ""
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)}</title>
<style>{_STYLE}</style>
</head>
<body>
<h1>{html.escape(title)}</h1>
<p class="note"><strong>Assumed data.</strong> {html.escape(ASSUMED_DATA)}</p>
{stopped}
<h2>Summary</h2>
<div class="tables">
{tables}
</div>
<h2>Figures</h2>
{pictures}
</body>
</html>
"""


def _groups(rows: Sequence[SummaryRow]) -> list[tuple[str, list[SummaryRow]]]:
    """Rows by group, in order."""
    groups: dict[str, list[SummaryRow]] = {}
    for row in rows:
        groups.setdefault(row.group, []).append(row)
    return list(groups.items())


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def _caption(path: Path) -> str:
    return CAPTIONS.get(path.stem, path.stem)


def _html_table(group: str, rows: Sequence[SummaryRow]) -> str:
    lines = [
        f'<tr><td>{html.escape(row.quantity)}</td><td class="value">{html.escape(row.text)}</td>'
        f'<td class="unit">{html.escape(row.unit)}</td></tr>'
        for row in rows
    ]
    return f"<section><h3>{html.escape(group)}</h3><table>\n" + "\n".join(lines) + "\n</table></section>"


def _html_figure(path: Path) -> str:
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    caption = html.escape(_caption(path))
    return (
        f'<figure><img alt="{caption}" src="data:image/png;base64,{data}"><figcaption>{caption}</figcaption></figure>'
    )
