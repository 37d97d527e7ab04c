"""The page's figure: the three laws, and asked against achieved errors."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from evidence.drawing import ACCENTS, COLOURS, CURVES, REFERENCE, figure
from evidence.tables import Table, Tables

from . import laws
from .judging import is_resolved
from .laws import Laws
from .scenes import KINDS
from .statics import COVER_LENGTHS


def draw(tables: Tables) -> Figure:
    """Four panels."""
    made, axes = figure(2, 2, 7.0)
    found = laws.fit(tables)
    _loop(axes[0, 0], tables["loop"], found)
    _cover(axes[0, 1], tables["cover"], found)
    _ends(axes[1, 0], tables["ends"], found)
    _errors_of_trips(axes[1, 1], tables["judge"])
    return made


def _loop(ax: Axes, t: Table, found: Laws) -> None:
    w, S = t["w [m]"], laws.stiffness(t["EA [N]"], t["EI [N m2]"], t["w [m]"])
    for name, colour, label in (
        ("too high [m]", COLOURS["left"], "too high"),
        ("aside [m]", COLOURS["right"], "aside"),
    ):
        ax.loglog(t["fine [m]"] / w, t[name] / w, ".", color=colour, ms=4, label=label)
    x = np.geomspace(0.09, 0.9, 50)
    for value, style in ((S.min(), ":"), (S.max(), "-")):
        law = laws.loop_error(found.loop.values, x, np.ones_like(x), np.full_like(x, value))
        ax.loglog(x, law, style, color=REFERENCE, lw=1, label=f"law, EA w$^2$/EI = {value:.1e}")
    ax.set(xlabel="elements of the loop / w", ylabel="loop's place off / w", title="Loop")
    ax.legend()


def _cover(ax: Axes, t: Table, found: Laws) -> None:
    w = t["w [m]"]
    x, up = t["fine [m]"] / w, np.linspace(1.0, 3.0, 50)
    for value, colour in zip(COVER_LENGTHS, CURVES, strict=False):
        mine = np.isclose(x, value, rtol=1e-3)
        ax.semilogy(t["cover [m]"][mine] / w[mine], t["off [m]"][mine] / w[mine], ".", color=colour, ms=4)
        law = laws.cover_error(found.cover.values, np.full_like(up, value), up, np.ones_like(up))
        ax.semilogy(up, law, "-", color=colour, lw=1, label=f"elements of {value:g} w")
    ax.set(xlabel="fine elements end this far above / w", ylabel="loop's place off / w", title="What fades out above")
    ax.legend()


def _ends(ax: Axes, t: Table, found: Laws) -> None:
    y = t["end element [m]"] / t["layer [m]"]
    ax.loglog(y, t["moment error"], ".", color=COLOURS["left"], ms=4)
    line = np.geomspace(y.min(), laws.RESOLVED, 20)
    ax.loglog(line, laws.moment_error(found.ends.values, line, np.ones_like(line)), "-", color=REFERENCE, lw=1)
    ax.set(xlabel="end element / bending layer", ylabel="error of the clamp moment", title="Ends")


def _errors_of_trips(ax: Axes, t: Table) -> None:
    for kind, colour in zip(KINDS, (COLOURS["left"], ACCENTS[2]), strict=True):
        mine = is_resolved(t) & (t["trip"] == kind)
        ax.loglog(1e3 * t["asked [m]"][mine], 1e3 * t["achieved [m]"][mine], ".", color=colour, ms=4, label=kind)
    line = 1e3 * np.array([t["asked [m]"].min(), t["asked [m]"].max()])
    ax.loglog(line, line, "-", color=REFERENCE, lw=1, label="asked")
    ax.set(xlabel="asked [mm]", ylabel="largest error of the loop's place [mm]", title="Judging seed")
    ax.legend()
