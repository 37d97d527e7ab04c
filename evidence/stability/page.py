"""docs/stability.md from docs/data/stability and docs/data/coupling, and its two figures."""

from collections.abc import Callable
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from evidence.claims import recorded
from evidence.coupling.page import cases, schemes
from evidence.drawing import CURVES, figure
from evidence.rendering import render, with_unit
from evidence.stability.entry import Entry
from evidence.stability.measure import CHAPTERS
from evidence.tables import Table, Tables, rows
from hoist_demo.cosimulation.schemes.stability import MARGIN
from hoist_demo.parameters import Coupling

#: of the figures: title, whether logarithmic
TITLES = {
    "locking": ("Side force of a hanging loop: elements that are too long make it too stiff", True),
    "swivel-chattering": ("A swivel that comes to rest", False),
}
MARKED = 9  #: Number of points from which on a curve has no markers.


def page(tables: Tables) -> str:
    """Return the whole page."""
    entries = [entry for part in CHAPTERS.values() for entry in part]
    data = {
        "summary": [_summary(tables["claims"], e) for e in entries],
        "titles": {e.key: e.title for e in entries},
        "schemes": schemes(tables["coupling/schemes"]),
        "cases": cases(tables["coupling/cases"]),
        "default": Coupling().scheme,
        "margin": MARGIN,
    }
    return render("stability/stability.md.j2", data)


def anchor(title: str) -> str:
    """Return the title's anchor as GitHub makes it."""
    return "".join(c for c in title.lower().replace(" ", "-") if c.isalnum() or c == "-")


def _summary(t: Table, entry: Entry) -> tuple[str, ...]:
    """Return the first claim of either side, and how many of all hold."""
    claims = [(side, m) for (key, side), m in recorded(t) if key == entry.key]
    first = [
        next(m for side, m in claims if side == wanted) for wanted in ("counterexample", "ours")
    ]
    cells = [f"{m.what}: {with_unit(m.value, m.unit, '.4g')}" for m in first]
    held = f"{sum(m.holds for _, m in claims)} of {len(claims)}"
    return f"[{entry.title}](#{anchor(entry.title)})", *cells, held


def draw(tables: Tables, key: str) -> Figure:
    """Draw the recorded curves of an entry."""
    made, axes = figure(1, 1, 3.6)
    ax = axes[0, 0]
    t = tables[key]
    _, x, y = t
    title, logarithmic = TITLES[key]
    for k, name in enumerate(dict.fromkeys(t["curve"].tolist())):
        of = rows(t, curve=name)
        ax.plot(of[x], of[y], _line(of[x].size), color=CURVES[k], label=name)
    ax.set(title=title, xlabel=x, ylabel=y)
    if logarithmic:
        ax.set(xscale="log", yscale="log")
    else:
        ax.set_xlim(float(np.min(t[x])), float(np.max(t[x])))
    ax.legend()
    return made


FIGURES: dict[str, Callable[[Tables], Figure]] = {key: partial(draw, key=key) for key in TITLES}


def _line(points: int) -> str:
    """Return the format of a curve for Matplotlib: markers while they can be told apart."""
    if points == 1:
        return "*"
    if points < MARKED:
        return "o-"
    return "-"
