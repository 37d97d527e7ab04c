"""Asked, reached and estimated errors of the scenes, and what they cost."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from evidence.drawing import ACCENTS, COLOURS, REFERENCE, figure
from evidence.tables import Table, Tables

from .judging import completed
from .scenes import KINDS
from .wind import ASKED

_COLOURS = dict(zip(KINDS, (COLOURS["left"], ACCENTS[2], COLOURS["right"]), strict=True))


def distributions(tables: Tables) -> Figure:
    """Four panels: errors of force and loop over what was asked; estimates against errors; cost."""
    made, axes = figure(2, 2, 7.0)
    t = completed(tables["scenes"])
    _share(axes[0, 0], "end force", t["end force"] / ASKED.end_force, t["end force, before"] / ASKED.end_force)
    _share(axes[0, 1], "place of the loop", t["loop [m]"] / ASKED.loop, t["loop, before [m]"] / ASKED.loop)
    _estimates(axes[1, 0], t)
    _costs(axes[1, 1], t)
    return made


def _share(ax: Axes, what: str, now: np.ndarray, before: np.ndarray) -> None:
    for values, colour, label in ((now, COLOURS["left"], "now"), (before, REFERENCE, "steps by places alone")):
        ax.plot(np.sort(values), np.linspace(0, 1, values.size), color=colour, label=label, drawstyle="steps-post")
    ax.axvline(1.0, color=ACCENTS[2], lw=1.0)
    ax.set(xscale="log", xlabel="error / asked", ylabel="share of the scenes below", title=f"Error of the {what}")
    ax.legend()


def _estimates(ax: Axes, t: Table) -> None:
    for kind, colour in _COLOURS.items():
        mine = t["kind"] == kind
        ax.loglog(t["end force"][mine], t["end force, estimated"][mine], ".", ms=4, color=colour, label=kind)
    line = np.array([t["end force"].min(), t["end force"].max()])
    for factor in (0.5, 1.0, 2.0):
        ax.loglog(line, factor * line, color=REFERENCE, lw=1.0 if factor == 1 else 0.5)
    ax.set(xlabel="error of the end force", ylabel="status.end_force_error", title="Estimated, within a factor of 2")
    ax.legend()


def _costs(ax: Axes, t: Table) -> None:
    for kind, colour in _COLOURS.items():
        mine = t["kind"] == kind
        ratio = t["end force, before"][mine] / t["end force"][mine]
        ax.loglog(t["work"][mine] / t["work, before"][mine], ratio, ".", ms=4, color=colour, label=kind)
    ax.axhline(1.0, color=REFERENCE, lw=0.5)
    ax.axvline(1.0, color=REFERENCE, lw=0.5)
    ax.set(xlabel="work / work before", ylabel="error before / error", title="What the end force gains and costs")
    ax.legend(loc="lower right")


FIGURES: dict[str, Callable[[Tables], Figure]] = {"distributions": distributions}
