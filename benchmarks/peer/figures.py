"""Work-precision figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .exudyn_rope import ELEMENTS
from .precision import Measured, Metric, front

_STYLE: dict[Any, Any] = {
    "font.size": 9.5,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e3e3e3",
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "figure.constrained_layout.use": True,
}
_OURS = ("#1f5fa8", "#5d9bd3", "#0b2f57", "#7fb3d5")
_THEIRS = {"ancf": "#d98880", "ancf-lobatto": "#b03a2e", "beam": "#f0b27a", "beam-quadratic": "#d9731a"}
_MARKERS = {0.005: "s", 0.01: "o", 0.02: "^", 0.04: "v"}
_TITLES: dict[Metric, tuple[str, str]] = {
    "force": ("end force", "RMS error of the end forces / largest force [-]"),
    "loop": ("place of the loop", "largest error of the loop's lowest point [m]"),
}
#: errors beyond these are no result, and not shown
_LIMIT: dict[Metric, float] = {"force": 3e-2, "loop": 0.5}


def work_precision(measured: list[Measured], metric: Metric, path: Path) -> None:
    """Error against CPU time per simulated second; the fronts of both codes are drawn and labelled."""
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(8.2, 5.6))
        ax = figure.subplots()
        title, label = _TITLES[metric]
        shown = [m for m in measured if m.of(metric) < _LIMIT[metric]]
        for group, colour in _colours(shown).items():
            name = ELEMENTS[group].label if group in ELEMENTS else f"ours, {group}"
            members = [m for m in shown if m.run.group == group]
            for step in sorted({m.run.step for m in members}):
                points = [m for m in members if m.run.step == step]
                x, y = [m.run.cost for m in points], [m.of(metric) for m in points]
                ax.plot(x, y, _MARKERS[step], color=colour, ms=5.5, label=name)
                name = "_"
        for code, colour, below in (("ours", _OURS[0], True), ("Exudyn", "#d9731a", False)):
            kept = front([m for m in shown if m.run.code == code], metric)
            ax.plot([m.run.cost for m in kept], [m.of(metric) for m in kept], color=colour, lw=1.0, zorder=1)
            _label(ax, kept, metric, colour, below)
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
        for step, marker in _MARKERS.items():
            ax.plot([], [], marker, color="#8a8a8a", ms=5.5, label=f"step {1e3 * step:g} ms")
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlabel("CPU time per simulated second [s/s]")
        ax.set_ylabel(label)
        ax.set_title(f"Planar 120 m winding: error of the {title} against computation time")
        figure.legend(loc="outside lower center", ncols=3)
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=110, metadata={"Software": None})


def _colours(shown: list[Measured]) -> dict[str, str]:
    groups = list(dict.fromkeys(m.run.group for m in shown if m.run.code == "ours"))
    return dict(zip(groups, _OURS, strict=False)) | _THEIRS


def _label(ax: Axes, kept: list[Measured], metric: Metric, colour: str, below: bool) -> None:
    last = np.array([-np.inf, -np.inf])
    for m in kept:
        here = np.log10([m.run.cost, m.of(metric)])
        if np.hypot(*(here - last) * (4.0, 1.0)) < 0.35:
            continue  # would print over its neighbour
        last = here
        short = m.run.label.replace("l = ", "").replace(", IV of 24", "*")
        ax.annotate(
            short,
            (m.run.cost, m.of(metric)),
            xytext=(-6, -7) if below else (6, 5),
            fontsize=9,
            color=colour,
            textcoords="offset points",
            ha="right" if below else "left",
            va="top" if below else "bottom",
        )
