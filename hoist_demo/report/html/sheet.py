"""A page of tables and bars, without scripts: what was found, drawn where it lies in what was known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hoist_demo.report.html import page
from rope_model.texts import html_text

#: Of a picture: its width, a row's height, where the axis begins, and its length, in pixels.
WIDTH, ROW, LABEL, AXIS = 760, 26, 290, 440


@dataclass(frozen=True)
class Bar:
    """A row: what is drawn from `low` to `high`, with a dot `at`, as parts of the axis; texts beside it."""

    label: str
    low: float
    high: float
    at: float
    told: bool = True  # drawn full rather than faint


def bars(rows: Sequence[Bar], ticks: Sequence[tuple[float, str]], title: str) -> str:
    """Bars over a common axis from 0 to 1, as SVG; `ticks` are places on the axis with their texts."""
    height = ROW * (len(rows) + 1)
    parts = [
        f'<line class="grid" x1="{_x(place):.1f}" x2="{_x(place):.1f}" y1="0" y2="{height - ROW}"/>'
        f'<text class="tick" text-anchor="middle" x="{_x(place):.1f}" y="{height - 8}">{html_text(text)}</text>'
        for place, text in ticks
    ]
    for k, row in enumerate(rows):
        y, colour = ROW * (k + 0.5), "var(--left)" if row.told else "var(--soft)"
        low, high, at = (_x(min(max(x, 0.0), 1.0)) for x in (row.low, row.high, row.at))
        parts.append(
            f'<text x="{LABEL - 10}" y="{y + 4:.1f}" text-anchor="end" font-size="13">{html_text(row.label)}</text>'
            f'<line x1="{low:.1f}" x2="{high:.1f}" y1="{y:.1f}" y2="{y:.1f}" stroke="{colour}" stroke-width="6" '
            f'stroke-opacity="{0.55 if row.told else 0.25}"/>'
            f'<circle cx="{at:.1f}" cy="{y:.1f}" r="4.5" fill="{colour}"/>'
        )
    return (
        f'<svg role="img" aria-label="{html_text(title)}" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
        f'height="{height}">{"".join(parts)}</svg>'
    )


def grid(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table."""
    cells = "".join(f"<tr>{''.join(f'<td>{html_text(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><tr>{''.join(f'<th>{html_text(name)}</th>' for name in head)}</tr>{cells}</table>"


def paragraphs(texts: Sequence[str]) -> str:
    """Each text by itself."""
    return "".join(f"<p>{html_text(text)}</p>" for text in texts)


def write_sheet(path: Path, title: str, parts: Sequence[tuple[str, str]]) -> Path:
    """The page of headings and what stands under them, as HTML; one without a heading stands first."""
    body = "\n".join((f"<h2>{html_text(heading)}</h2>\n" if heading else "") + part for heading, part in parts)
    return page.write(path, page.render("study", title, f'<main class="sheet">\n{body}\n</main>'))


def _x(place: float) -> float:
    return LABEL + AXIS * place
