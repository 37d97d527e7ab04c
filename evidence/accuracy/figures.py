"""Work-precision diagrams: error over processor time."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from evidence.accuracy.front import pareto
from evidence.accuracy.measure import COST
from evidence.accuracy.reading import FORCE, LOOP, limit
from evidence.drawing import ACCENTS, COLOURS, REFERENCE, figure
from evidence.tables import Table, Tables, rows, where

LABELS = {
    FORCE: "RMS error of the end forces / largest force",
    LOOP: "largest error of the loop's lowest point [m]",
}
SHORT = {FORCE: "end forces", LOOP: "loop's lowest point"}
SIZES = {5e-3: 3.0, 10e-3: 4.5, 20e-3: 6.5, 40e-3: 9.0}  # points, by the largest step
REAL_TIME = {1.0: "real time", 0.1: "10 x faster", 1 / 30: "30 x faster"}
#: of the levels' names, points
OFFSETS = {
    "draft": (-40, 22),
    "standard": (-66, -30),
    "standard, 10 ms": (-34, -46),
    "reference": (-16, 24),
}


class Look(NamedTuple):
    """How a kind of points is drawn."""

    label: str
    colour: str
    marker: str


EEM = Look("equal elements", REFERENCE, "s")
TMN = Look("TMN-ETM, chosen by the loop's error", COLOURS["left"], "o")
PUBLISHED = Look("TMN-ETM, published pattern, l = 2 m", COLOURS["right"], "D")
FIDELITIES = Look("fidelities of the model, standard mesh", ACCENTS[1], "P")
PEER = Look("Exudyn, in a run of its own", "#a08060", "x")


def kinds(t: Table) -> list[tuple[Look, Table]]:
    """Return the points by how they are drawn."""
    tmn = rows(t, family="tmn")
    published = np.char.startswith(tmn["name"].astype(str), "published")
    return [
        (EEM, rows(t, family="eem")),
        (TMN, where(tmn, ~published)),
        (PUBLISHED, where(tmn, published)),
        (FIDELITIES, rows(t, family="fidelities")),
    ]


def work_precision(tables: Tables, coupling: str, error: str) -> Figure:
    """Draw one error measure of one scene."""
    t = rows(tables["points"], coupling=coupling)
    made, axes = figure(1, 1, 6.0)
    ax = axes[0, 0]
    bound = limit(t, coupling, error)
    looks = []
    for look, points in kinds(t):
        looks.append(look)
        for x, y, step in zip(points[COST], points[error], points["largest step [s]"], strict=True):
            if np.isfinite(y) and y > 0:
                face = look.colour if y > bound else "none"
                ax.plot(
                    x,
                    y,
                    look.marker,
                    color=look.colour,
                    mfc=face,
                    ms=SIZES.get(step, 4.5),
                    alpha=0.75,
                    mew=0.9,
                )
    if coupling == "uncoupled":
        looks.append(PEER)
        theirs = rows(tables["exudyn/winding"], code="Exudyn")
        y = theirs["force_error_vs_ours" if error == FORCE else "loop_error_vs_ours_m"]
        ax.plot(
            theirs["cpu_s_per_s"],
            np.where(y < 1.0, y, np.nan),
            PEER.marker,
            color=PEER.colour,
            ms=4.5,
        )
    handles = [
        Line2D([], [], color=look.colour, marker=look.marker, ls="", label=look.label)
        for look in looks
    ]
    handles += _fronts(ax, t, error)
    ax.set(xscale="log", yscale="log", ylabel=LABELS[error])
    ax.set_xlabel("processor time per simulated second [s/s]")
    ax.set_title(
        f"{coupling.capitalize()} winding: error of the {SHORT[error]} over processor time"
    )
    _levels(ax, rows(t, family="levels"), error)
    _marks(ax, bound)
    sizes = [
        Line2D([], [], color="#555555", marker="o", ls="", ms=m, label=f"{1e3 * h:g} ms")
        for h, m in SIZES.items()
    ]
    made.legend(handles=handles, loc="outside lower left", ncols=3)
    ax.legend(
        handles=sizes,
        loc="upper right",
        title="largest step",
        frameon=True,
        framealpha=0.9,
        edgecolor="none",
    )
    return made


def _fronts(ax: Axes, t: Table, error: str) -> list[Line2D]:
    """Draw the fronts of equal elements and of all meshes together."""
    lines = []
    for families, colour, width, label in (
        (("eem",), REFERENCE, 1.2, "front of equal elements"),
        (("eem", "tmn", "levels"), "black", 1.6, "front of all meshes"),
    ):
        r = rows(t, family=families)
        front = pareto(r[COST], r[error])
        lines += ax.plot(
            r[COST][front], r[error][front], "-", color=colour, lw=width, label=label, zorder=1.5
        )
    return lines


def _levels(ax: Axes, t: Table, error: str) -> None:
    style: dict[str, Any] = {
        "arrowprops": {"arrowstyle": "-", "lw": 0.7},
        "bbox": {"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none"},
    }
    for name, x, y in zip(t["name"], t[COST], t[error], strict=True):
        if np.isfinite(y):
            ax.plot(x, y, "*", color="#f1c40f", mec="black", mew=0.7, ms=14, zorder=4)
            at = OFFSETS.get(name, (-34, -30))
            ax.annotate(
                name,
                (x, y),
                at,
                textcoords="offset points",
                ha="right",
                fontweight="bold",
                zorder=5,
                **style,
            )


def _marks(ax: Axes, bound: float) -> None:
    """Mark real time, and the reference solution's own error."""
    low, high = ax.get_ylim()
    left, right = ax.get_xlim()
    low = min(low, 0.5 * bound) if bound > 0 else low
    left *= 0.5  # room for the levels' names
    ax.set(ylim=(low, high), xlim=(left, max(right, 1.3)))
    for x, name in REAL_TIME.items():
        ax.axvline(x, color="#c0392b", lw=0.9, ls=":", zorder=1)
        ax.text(
            x,
            0.01,
            f"{name} ",
            color="#c0392b",
            fontsize=9,
            transform=ax.get_xaxis_transform(),
            rotation=90,
            va="bottom",
            ha="right",
        )
    ax.axhspan(low, bound, color="#f0f0f0", zorder=0)
    ax.text(
        left * 1.05,
        bound,
        "below: the reference solution's own error",
        va="top",
        fontsize=9,
        color="#666666",
    )


FIGURES: dict[str, Callable[[Tables], Figure]] = {
    "coupled-force": partial(work_precision, coupling="coupled", error=FORCE),
    "uncoupled-loop": partial(work_precision, coupling="uncoupled", error=LOOP),
}
