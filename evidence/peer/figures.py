"""Work-precision figures."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from evidence.drawing import figure
from evidence.tables import Tables

from .elements import ELEMENTS
from .precision import LEVELS, Metric, Point, front, points

_OURS = ("#1f5fa8", "#5d9bd3", "#0b2f57", "#7fb3d5")
_THEIRS = {"ancf": "#d98880", "ancf-lobatto": "#b03a2e", "beam": "#f0b27a", "beam-quadratic": "#d9731a"}
_MARKERS = {0.005: "s", 0.01: "o", 0.02: "^", 0.04: "v"}
_TITLES: dict[Metric, tuple[str, str]] = {
    "force": ("end force", "RMS error of the end forces / largest force [-]"),
    "loop": ("place of the loop", "largest error of the loop's lowest point [m]"),
}
#: errors beyond these are no result, and not shown
_LIMIT: dict[Metric, float] = {"force": 3e-2, "loop": 0.5}


def work_precision(tables: Tables, metric: Metric) -> Figure:
    """Error against CPU time per simulated second; the fronts of both codes are drawn and labelled."""
    made, axes = figure(1, 1, 5.8)
    made.set_dpi(110)
    ax = axes[0, 0]
    title, label = _TITLES[metric]
    shown = [m for m in points(tables["winding"]) if m.of(metric) < _LIMIT[metric]]
    for group, colour in _colours(shown).items():
        name = ELEMENTS[group].label if group in ELEMENTS else f"ours, {group}"
        members = [m for m in shown if m.group == group]
        for step in sorted({m.step for m in members}):
            mine = [m for m in members if m.step == step]
            x, y = [m.cost for m in mine], [m.of(metric) for m in mine]
            ax.plot(x, y, _MARKERS[step], color=colour, ms=5.5, label=name)
            name = "_"
    labels: list[tuple[Point, str]] = []
    for code, colour in (("ours", _OURS[0]), ("Exudyn", "#d9731a")):
        kept = front([m for m in shown if m.code == code], metric)
        ax.plot([m.cost for m in kept], [m.of(metric) for m in kept], color=colour, lw=1.0, zorder=1)
        labels += [(m, colour) for m in kept]
    ax.axvline(1.0, color="#8a8a8a", ls="--", lw=1.0)
    ax.annotate(
        "real time",
        (1.0, 0.98),
        xycoords=("data", "axes fraction"),
        xytext=(3, 0),
        textcoords="offset points",
        va="top",
        color="#5f5f5f",
        rotation=90,
    )
    ax.set_xscale("log")
    ax.set_xlim(left=0.35 * min(m.cost for m in shown))
    ax.set_yscale("log")
    ax.set_xlabel("CPU time per simulated second [s/s]")
    ax.set_ylabel(label)
    ax.set_title(f"Planar 120 m winding: error of the {title} against computation time")
    made.legend(loc="outside lower center", ncols=3)
    keys = [Line2D([], [], ls="", marker=m, color="#8a8a8a", label=f"step {1e3 * h:g} ms") for h, m in _MARKERS.items()]
    ax.legend(handles=keys, loc="upper right", bbox_to_anchor=(0.92, 1.0))
    made.draw_without_rendering()  # settles where the axes are
    _label(ax, labels, shown, metric)
    return made


def _colours(shown: list[Point]) -> dict[str, str]:
    groups = list(dict.fromkeys(m.group for m in shown if m.code == "ours"))
    return dict(zip(groups, _OURS, strict=False)) | _THEIRS


def _label(ax: Axes, labels: list[tuple[Point, str]], shown: list[Point], metric: Metric) -> None:
    """Label what can be labelled without printing over points or other labels."""
    points = ax.transData.transform([(m.cost, m.of(metric)) for m in shown])
    taken: list[tuple[float, float, float, float]] = [(x - 5, y - 5, x + 5, y + 5) for x, y in points]
    for m, colour in labels:
        text = m.label.removeprefix("mesh to ")
        x, y = ax.transData.transform((m.cost, m.of(metric)))
        w, h = 7.6 * len(text), 15.0  # px of 9 pt at 110 dpi
        for right, up in ((1, 1), (-1, -1), (1, -1), (-1, 1)):
            x0, y0 = (x + 7 if right > 0 else x - 7 - w), (y + 2 if up > 0 else y - 2 - h)
            box = (x0, y0, x0 + w, y0 + h)
            if not any(box[0] < t[2] and t[0] < box[2] and box[1] < t[3] and t[1] < box[3] for t in taken):
                left, low = ax.transData.inverted().transform((x0, y0))
                ax.annotate(text, (left, low), color=colour, fontsize=9, ha="left", va="bottom", annotation_clip=False)
                taken.append(box)
                break


FIGURES: dict[str, Callable[[Tables], Figure]] = {metric: partial(work_precision, metric=metric) for metric in LEVELS}
