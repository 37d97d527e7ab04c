"""Pages from templates of assets/, with text, data, style and scripts in one file.

A page refers to nothing outside of it.

Every page forbids its browser the network (Content-Security-Policy), so a stray reference would be
an error in the console and not a hidden dependence.
"""

import json
import math
import re
import string
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from hoist_demo.parameters import ASSUMED_DATA
from rope_model.files import write_text
from rope_model.texts import html_text

LONG = 24  #: Characters from which a value may break anywhere, such as a hash.
Row = tuple[str, ...]  #: Quantity, value and unit as texts, and perhaps what more is known of it.


def asset(name: str) -> str:
    """Read a file of assets/."""
    return (files("hoist_demo.report.html") / "assets" / name).read_text(encoding="utf-8")


def fill(template: str, **texts: str) -> str:
    """Fill a template of assets/ with HTML."""
    return string.Template(asset(template)).substitute(texts)


def render_page(kind: str, title: str, body: str, note: str = "", scripts: str = "") -> str:
    """Return a page with its head; `kind` is its CSS class, `scripts` what `running` gives."""
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


def running(files: Sequence[str], data: Mapping[str, object]) -> str:
    """Return the script elements of a page: the data as JSON, and the code that reads them."""
    code = "\n".join(asset(name) for name in ("common.js", *files))
    text = json.dumps(_finite(data), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    inside = text.replace("<", "\\u003c")  # it may stand in a script element
    return f'<script type="application/json" id="data">{inside}</script>\n<script>\n"use strict";\n{code}\n</script>'


def write_html(path: Path, text: str) -> Path:
    """Write a page; the same text gives the same bytes on every system."""
    return write_text(path, text, errors="replace")


def titled_table(title: str, rows: Sequence[Row]) -> str:
    """Return a titled table of quantity, value, unit and more columns; "" without rows."""
    lines = [
        f'<tr><td>{html_text(quantity)}</td><td class="{_value(value)}">{html_text(value)}</td>'
        + "".join(f'<td class="unit">{html_text(text)}</td>' for text in more)
        + "</tr>"
        for quantity, value, *more in rows
    ]
    return (
        f"<section><h3>{html_text(title)}</h3><table>{''.join(lines)}</table></section>"
        if lines
        else ""
    )


def _value(text: str) -> str:
    return "value long" if len(text) > LONG else "value"


def number(value: float, digits: int = 5) -> str:
    """Format a number for people, without an exponent where ten places do."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.10g}" if "e+" in text else text


def engineering(largest: float, unit: str) -> tuple[float, str]:
    """Return the factor to a unit in which this magnitude has few digits, and that unit.

    For 9.96e7 J these are 1e-6 and MJ.
    """
    steps = _PREFIXES if re.split(r"[.\s/]", unit)[0] in ("J", "N", "W", "Pa") else ()
    return next(
        ((1.0 / size, prefix + unit) for size, prefix in steps if largest >= 10.0 * size),
        (1.0, unit),
    )


_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"))


def unit_text(unit: str) -> str:
    """Format a unit for people: `N.m2` and `N m^2` as N m², and nothing for a pure number."""
    text = unit.replace(".", " ").replace("^", "") if unit != "1" else ""
    return re.sub(r"(?<=[A-Za-z])[23]", lambda match: {"2": "²", "3": "³"}[match[0]], text)


def _finite(data: object) -> object:
    """Replace NaN and infinities by None, which JSON writes as null."""
    if isinstance(data, float):
        return data if math.isfinite(data) else None
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
    """Row of `bars`: a line from `low` to `high` with a dot `at`, as parts of the axis."""

    label: str
    low: float
    high: float
    at: float
    solid: bool = True  # else faint


def bars(rows: Sequence[Bar], ticks: Sequence[tuple[float, str]], title: str) -> str:
    """Draw rows over a common axis from 0 to 1, as SVG.

    `ticks` are places on it with their texts.
    """
    height = ROW * (len(rows) + 1)
    parts = [
        f'<line class="grid" x1="{_x(position):.1f}" x2="{_x(position):.1f}" y1="0" y2="{height - ROW}"/>'
        f'<text class="tick" text-anchor="middle" x="{_x(position):.1f}" y="{height - 8}">{html_text(text)}</text>'
        for position, text in ticks
    ]
    for k, row in enumerate(rows):
        y = ROW * (k + 0.5)
        colour = "var(--left)" if row.solid else "var(--soft)"
        low, high, at = (_x(min(max(x, 0.0), 1.0)) for x in (row.low, row.high, row.at))
        parts.append(
            f'<text x="{LABEL - 10}" y="{y + 4:.1f}" text-anchor="end" font-size="13">{html_text(row.label)}</text>'
            f'<line x1="{low:.1f}" x2="{high:.1f}" y1="{y:.1f}" y2="{y:.1f}" stroke="{colour}" stroke-width="6" '
            f'stroke-opacity="{0.55 if row.solid else 0.25}"/>'
            f'<circle cx="{at:.1f}" cy="{y:.1f}" r="4.5" fill="{colour}"/>'
        )
    return (
        f'<svg role="img" aria-label="{html_text(title)}" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
        f'height="{height}">{"".join(parts)}</svg>'
    )


def plain_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return an HTML table with a head row."""
    cells = "".join(
        f"<tr>{''.join(f'<td>{html_text(cell)}</td>' for cell in row)}</tr>" for row in rows
    )
    return (
        f"<table><tr>{''.join(f'<th>{html_text(name)}</th>' for name in head)}</tr>{cells}</table>"
    )


def paragraphs(texts: Sequence[str]) -> str:
    """Return a paragraph for each text."""
    return "".join(f"<p>{html_text(text)}</p>" for text in texts)


def write_sheet(path: Path, title: str, parts: Sequence[tuple[str, str]]) -> Path:
    """Write a page of headings with HTML under them; a part without a heading stands first."""
    body = "\n".join(
        (f"<h2>{html_text(heading)}</h2>\n" if heading else "") + part for heading, part in parts
    )
    return write_html(path, render_page("study", title, f'<main class="sheet">\n{body}\n</main>'))


def _x(position: float) -> float:
    return LABEL + AXIS * position
