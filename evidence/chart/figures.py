"""Work-precision diagrams: error over processor time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from evidence.drawing import ACCENTS, COLOURS, REFERENCE, figure
from evidence.tables import Table, Tables, rows

from . import depth
from .front import pareto
from .measure import COST
from .reading import FORCE, LOOP, TWIST, limit

LABELS = {
    FORCE: "RMS error of the end forces / largest force",
    LOOP: "largest error of the loop's lowest point [m]",
    TWIST: "largest error of theta at the observation points [rad]",
}
SHORT = {FORCE: "end forces", LOOP: "loop's lowest point", TWIST: "twist angle"}
TIME = "processor time per simulated second [s/s]"
SIZES = {5e-3: 3.0, 10e-3: 4.5, 20e-3: 6.5, 40e-3: 9.0}  # points, by the largest step
REAL_TIME = {1.0: "real time", 0.1: "10 x faster", 1 / 30: "30 x faster"}
PEER = "#a08060"
#: of the levels' names, points
OFFSETS = {"draft": (-40, 22), "reference": (-16, 24)}


class Look(NamedTuple):
    """How a kind of points is drawn."""

    label: str
    colour: str
    marker: str


EEM = Look("EEM", REFERENCE, "s")
TMN = Look("TMN-ETM, chosen by the loop's error", COLOURS["left"], "o")
PUBLISHED = Look("TMN-ETM, published pattern, l = 2 m", COLOURS["right"], "D")
FORMER = Look("TMN-ETM, l = 2 m, ends halved", ACCENTS[0], "^")
FIDELITIES = Look("fidelities of the model, standard mesh", ACCENTS[1], "P")
PORTABLE = Look("interpreted", ACCENTS[2], "v")


def kinds(t: Table) -> list[tuple[Look, Table]]:
    """The points by how they are drawn."""
    eem, tmn = rows(t, family="eem"), rows(t, family="tmn")
    published, former = (np.char.startswith(tmn["name"].astype(str), name) for name in ("published", "l = 2 m"))
    return [
        (EEM, eem),
        (TMN, _where(tmn, ~published & ~former)),
        (PUBLISHED, _where(tmn, published)),
        (FORMER, _where(tmn, former)),
        (FIDELITIES, rows(t, family="fidelities")),
        (PORTABLE, rows(t, family="kernels", kernels="portable")),
    ]


def work_precision(tables: Tables, coupling: str, error: str) -> Figure:
    """One error measure of one scene."""
    t = rows(tables["points"], coupling=coupling)
    made, axes = figure(1, 1, 6.2)
    ax = axes[0, 0]
    bound = limit(t, coupling, error)
    handles = []
    for look, points in kinds(t):
        if np.isfinite(points[error]).any():
            _scatter(ax, points, error, bound, look)
            handles.append(Line2D([], [], color=look.colour, marker=look.marker, ls="", label=look.label))
    if coupling == "uncoupled" and "peer" in tables:
        handles.append(_peer(ax, tables["peer"], error))
    handles += _fronts(ax, t, error)
    ax.set(xscale="log", yscale="log", xlabel=TIME, ylabel=LABELS[error])
    ax.set_title(f"{coupling.capitalize()} winding: error of the {SHORT[error]} over processor time")
    _name_fidelities(ax, rows(t, family="fidelities"), error)
    _levels(ax, rows(t, family="levels"), error)
    _marks(ax, bound)
    sizes = [
        Line2D([], [], color="#555555", marker="o", ls="", ms=ms, label=f"{1e3 * step:g} ms")
        for step, ms in SIZES.items()
    ]
    made.legend(handles=handles, loc="outside lower left", ncols=3)
    ax.legend(handles=sizes, loc="upper right", title="largest step", frameon=True, framealpha=0.9, edgecolor="none")
    return made


def _where(t: Table, kept: NDArray[np.bool_]) -> Table:
    return {name: column[kept] for name, column in t.items()}


def _size(step: float) -> float:
    return SIZES.get(step, 4.5)


def _scatter(ax: Axes, t: Table, error: str, bound: float, look: Look) -> None:
    """Markers as large as the steps; hollow where the reference solution is not better."""
    for x, y, step in zip(t[COST], t[error], t["largest step [s]"], strict=True):
        if np.isfinite(y) and y > 0:
            face = look.colour if y > bound else "none"
            ax.plot(x, y, look.marker, color=look.colour, mfc=face, ms=_size(step), alpha=0.75, mew=0.9)


def _peer(ax: Axes, t: Table, error: str) -> Line2D:
    y = t["force_error_vs_ours"] if error == FORCE else t["loop_error_vs_ours_m"]
    ax.plot(t["cpu_s_per_s"], y, "x", color=PEER, ms=4.5, alpha=0.9)
    return Line2D([], [], color=PEER, marker="x", ls="", label="Exudyn, measured in another run (make peer)")


def _fronts(ax: Axes, t: Table, error: str) -> list[Line2D]:
    """The fronts of EEM and of all meshes together."""
    lines = []
    for families, colour, width, label in (
        (("eem",), REFERENCE, 1.2, "front of EEM"),
        (("eem", "tmn", "levels"), "black", 1.6, "front of all meshes"),
    ):
        r = rows(t, family=families)
        front = pareto(r[COST], r[error])
        lines += ax.plot(r[COST][front], r[error][front], "-", color=colour, lw=width, label=label, zorder=1.5)
    return lines


def _name_fidelities(ax: Axes, t: Table, error: str) -> None:
    for name, x, y in zip(t["name"], t[COST], t[error], strict=True):
        if np.isfinite(y) and y > 0 and not (name == "torsional" and t["coupling"][0] == "coupled"):  # is the standard
            ax.annotate(
                name, (x, y), (0, 8), textcoords="offset points", ha="center", fontsize=9, color=FIDELITIES.colour
            )


def _levels(ax: Axes, t: Table, error: str) -> None:
    for name, x, y in zip(t["name"], t[COST], t[error], strict=True):
        if not np.isfinite(y):
            continue
        ax.plot(x, y, "*", color="#f1c40f", mec="black", mew=0.7, ms=14, zorder=4)
        ax.annotate(
            name,
            (x, y),
            OFFSETS.get(name, (-34, -30)),
            textcoords="offset points",
            ha="right",
            fontsize=10,
            fontweight="bold",
            arrowprops={"arrowstyle": "-", "lw": 0.7},
            zorder=5,
            bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.8},
        )


def _marks(ax: Axes, bound: float) -> None:
    """Real time, and the reference solution's own error."""
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
            transform=ax.get_xaxis_transform(),
            rotation=90,
            va="bottom",
            ha="right",
            color="#c0392b",
            fontsize=9,
        )
    if bound > low:
        ax.axhspan(low, bound, color="#f0f0f0", zorder=0)
        ax.text(left * 1.05, bound, "below: the reference solution's own error", va="top", fontsize=9, color="#666666")


def solver_numbers(tables: Tables) -> Figure:
    """Tolerance, Newton's tolerance and rho_inf, one at a time about the default."""
    t = rows(tables["points"], coupling="coupled")
    made, axes = figure(3, 3, 7.2, sharey="row", sharex="col")
    columns = {"tolerance": "tolerance", "newton": "newton tolerance", "rho_inf": "rho_inf"}
    names = ("tolerance (largest step 40 ms)", "newton_tolerance", "rho_inf")
    quantities = {FORCE: "error of the\nend forces", LOOP: "error of the loop's\nlowest point [m]", COST: "time [s/s]"}
    for line, (quantity, label) in zip(axes, quantities.items(), strict=True):
        line[0].set_ylabel(label)
        for ax, family, name in zip(line, columns, names, strict=True):
            r = rows(t, family=family)
            ax.plot(r[columns[family]], r[quantity], "o-", color=COLOURS["left"], ms=5)
            if family != "rho_inf":
                ax.set_xscale("log")
            if quantity != COST:
                ax.set(yscale="log", ylim=(5e-5, 1e-3) if quantity == FORCE else (1e-3, 3e-2))
            else:
                ax.set(xlabel=name)
    axes[2, 0].set_ylim(bottom=0.0)
    made.suptitle("Coupled winding, standard mesh: one number of the solver at a time", x=0.01, ha="left", fontsize=10)
    return made


FIGURES: dict[str, Callable[[Tables], Figure]] = {
    "coupled-force": partial(work_precision, coupling="coupled", error=FORCE),
    "coupled-loop": partial(work_precision, coupling="coupled", error=LOOP),
    "coupled-twist": partial(work_precision, coupling="coupled", error=TWIST),
    "uncoupled-force": partial(work_precision, coupling="uncoupled", error=FORCE),
    "uncoupled-loop": partial(work_precision, coupling="uncoupled", error=LOOP),
    "depth": depth.draw,
    "solver": solver_numbers,
}
