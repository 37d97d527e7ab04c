"""Pages from templates of assets/, with text, data, style and scripts in one file.

A page refers to nothing outside of it.

Every page forbids its browser the network (Content-Security-Policy), so a stray reference would be
an error in the console and not a hidden dependence.
"""

import json
import math
import string
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from hoist_demo.parameters import ASSUMED_DATA
from hoist_demo.report.formatting import Row
from rope_model.files import write_text
from rope_model.texts import html_text

LONG = 24  #: Characters from which a value may break anywhere, such as a hash.


def asset(name: str) -> str:
    """Read a file of assets/."""
    return (files("hoist_demo.report.html") / "assets" / name).read_text(encoding="utf-8")


def fill(template: str, **texts: str) -> str:
    """Fill a template of assets/ with HTML."""
    return string.Template(asset(template)).substitute(texts)


def render_page(kind: str, title: str, body: str, note: str = "", scripts: str = "") -> str:
    """Return a page with its head; ``kind`` is its CSS class, ``scripts`` what ``running`` gives."""
    return fill(
        "page.html",
        kind=kind,
        title=html_text(title),
        note=note,
        assumed=html_text(ASSUMED_DATA),
        body=body,
        style=asset("report.css"),
        policy="; script-src 'unsafe-inline'" if scripts else "",
        scripts=scripts,
    )


def running(scripts: Sequence[str], data: Mapping[str, object]) -> str:
    """Return the script elements of a page: the data as JSON, and the code that reads them."""
    code = "\n".join(asset(name) for name in ("common.js", *scripts))
    text = json.dumps(_finite(data), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    inside = text.replace("<", "\\u003c")  # it may stand in a script element
    data_element = f'<script type="application/json" id="data">{inside}</script>'
    return f'{data_element}\n<script>\n"use strict";\n{code}\n</script>'


def write_html(path: Path, text: str) -> Path:
    """Write a page; the same text gives the same bytes on every system."""
    return write_text(path, text, errors="replace")


def titled_table(title: str, rows: Sequence[Row]) -> str:
    """Return a titled table of quantity, value, unit and more columns; "" without rows."""
    if not rows:
        return ""
    lines = ""
    for quantity, value, *more in rows:
        cells = f"<td>{html_text(quantity)}</td>"
        cells += f'<td class="{_value(value)}">{html_text(value)}</td>'
        for text in more:
            cells += f'<td class="unit">{html_text(text)}</td>'
        lines += f"<tr>{cells}</tr>"
    return f"<section><h3>{html_text(title)}</h3><table>{lines}</table></section>"


def _value(text: str) -> str:
    if len(text) > LONG:
        return "value long"
    return "value"


def _finite(data: object) -> object:
    """Replace NaN and infinities by None, which JSON writes as null."""
    if isinstance(data, float):
        if math.isfinite(data):
            return data
        return None
    if isinstance(data, Mapping):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(value) for value in data]
    return data


WIDTH = 760  #: Width of a picture of bars in pixels.
ROW = 26  #: Height of a row in pixels.
LABEL = 290  #: Width of the labels left of the axis in pixels.
AXIS = 440  #: Length of the axis in pixels.


@dataclass(frozen=True)
class Bar:
    """Row of ``bars``: a line from ``low`` to ``high`` with a dot ``at``, as parts of the axis."""

    label: str
    low: float
    high: float
    at: float
    solid: bool = True  # else faint


def bars(rows: Sequence[Bar], ticks: Sequence[tuple[float, str]], title: str) -> str:
    """Draw rows over a common axis from 0 to 1, as SVG.

    ``ticks`` are places on it with their texts.
    """
    height = ROW * (len(rows) + 1)
    parts = []
    for position, text in ticks:
        x = f"{_x(position):.1f}"
        parts.append(
            f'<line class="grid" x1="{x}" x2="{x}" y1="0" y2="{height - ROW}"/>'
            f'<text class="tick" text-anchor="middle" x="{x}" y="{height - 8}">'
            f"{html_text(text)}</text>"
        )
    for k, row in enumerate(rows):
        parts.append(_bar(row, y=ROW * (k + 0.5)))
    return (
        f'<svg role="img" aria-label="{html_text(title)}" viewBox="0 0 {WIDTH} {height}" '
        f'width="{WIDTH}" height="{height}">{"".join(parts)}</svg>'
    )


def _bar(row: Bar, y: float) -> str:
    """Return label, line and dot of a row at the height ``y`` in pixels, as SVG."""
    if row.solid:
        colour = "var(--left)"
        opacity = 0.55
    else:
        colour = "var(--soft)"
        opacity = 0.25
    low, high, at = (_x(min(max(x, 0.0), 1.0)) for x in (row.low, row.high, row.at))
    return (
        f'<text x="{LABEL - 10}" y="{y + 4:.1f}" text-anchor="end" font-size="13">'
        f"{html_text(row.label)}</text>"
        f'<line x1="{low:.1f}" x2="{high:.1f}" y1="{y:.1f}" y2="{y:.1f}" stroke="{colour}" '
        f'stroke-width="6" stroke-opacity="{opacity}"/>'
        f'<circle cx="{at:.1f}" cy="{y:.1f}" r="4.5" fill="{colour}"/>'
    )


def untitled_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return an HTML table with a head row."""
    lines = _table_row(head, "th") + "".join(_table_row(row, "td") for row in rows)
    return f"<table>{lines}</table>"


def _table_row(texts: Sequence[str], tag: str) -> str:
    cells = "".join(f"<{tag}>{html_text(text)}</{tag}>" for text in texts)
    return f"<tr>{cells}</tr>"


def paragraphs(texts: Sequence[str]) -> str:
    """Return a paragraph for each text."""
    return "".join(f"<p>{html_text(text)}</p>" for text in texts)


def write_sheet(path: Path, title: str, parts: Sequence[tuple[str, str]]) -> Path:
    """Write a page of headings with HTML under them; a part without a heading stands first."""
    sections = []
    for heading, part in parts:
        head = f"<h2>{html_text(heading)}</h2>\n" if heading else ""
        sections.append(head + part)
    body = "\n".join(sections)
    return write_html(path, render_page("study", title, f'<main class="sheet">\n{body}\n</main>'))


def _x(position: float) -> float:
    return LABEL + AXIS * position
