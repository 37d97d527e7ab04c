"""How the figures look: one style, one file per picture, bytes that depend on the data alone."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from evidence.tables import Tables
from hoist_demo.report.figures import ACCENTS, COLOURS, REFERENCE, STYLE

__all__ = ["ACCENTS", "COLOURS", "CURVES", "REFERENCE", "draw_to", "figure"]

#: four curves told apart by hue and lightness
CURVES = (COLOURS["left"], COLOURS["right"], ACCENTS[0], ACCENTS[1])

#: that of the reports, larger
_STYLE: dict[Any, Any] = {
    **STYLE,
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.titleweight": "normal",
    "lines.linewidth": 1.3,
    "legend.fontsize": 9.0,
}


def figure(rows: int, columns: int, height: float, **options: Any) -> tuple[Figure, Any]:
    """A figure of ``height`` inches, as wide as the page, and its axes (rows, columns)."""
    made = Figure(figsize=(9.0, height), layout="constrained")
    return made, made.subplots(rows, columns, squeeze=False, **options)


def draw_to(path: Path, draw: Callable[[Tables], Figure], tables: Tables) -> None:
    """Write one PNG file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with matplotlib.rc_context(_STYLE):
        draw(tables).savefig(path, dpi=110, metadata={"Software": None})
