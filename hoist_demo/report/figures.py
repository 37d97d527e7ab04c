"""Figures of a run, as PNG files whose bytes depend on the data alone.

Only exposure_figures knows matplotlib, too. Blue is always the left end, orange the right one, grey the reference or
limit.
A figure whose signals were not recorded is left out.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hoist_demo.parameters import Hoist
from hoist_demo.recording.time_series import Array, Recording, shape_rows
from hoist_demo.report.panels import Mark, Panel, derived_signals, panels

COLOURS = {"left": "#1f5fa8", "right": "#d9731a"}
#: The right end's gaps show the left one where both coincide.
DASHES: dict[str, Any] = {"left": "-", "right": (0, (4, 2.5))}
REFERENCE = "#8a8a8a"
ACCENTS = ("#2f8f5b", "#8e44ad", "#b03a2e", "#5d6d7e")

STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "figure.constrained_layout.use": True,
    "axes.formatter.useoffset": False,
}


#: Groups of panels by the name of their figure.
_FIGURES = {
    "tracking": ("Winding",),
    "forces": ("Drive",),
    "loop": ("Balance rope", "Stress"),
    "swivels": ("Swivels",),
    "energies": ("Energy",),
}
#: Styles of panels.Line.
_STYLES: dict[str, dict[str, Any]] = {
    **{end: {"color": COLOURS[end], "ls": DASHES[end]} for end in COLOURS},
    "asked": {"color": "black", "lw": 0.8, "ls": (0, (4, 3))},
    **{letter: {"color": colour} for letter, colour in zip("abcde", (*ACCENTS, "black"), strict=True)},
}


def write_figures(
    recording: Recording, hoist: Hoist, directory: Path, marks: Sequence[Mark] = (), locked: Collection[str] = ()
) -> list[Path]:
    """Write the PNG files, `marks` as dashed lines over time, and return their paths in reading order.

    `locked` are the ends whose swivel cannot turn.
    """
    signals = dict(recording.signals) | {name: x for name, (x, _) in derived_signals(recording, hoist).items()}
    shown = panels(recording, hoist)
    paths: list[Path] = []
    with matplotlib.rc_context(STYLE):
        for name, groups in _FIGURES.items():
            if own := [panel for panel in shown if panel.group in groups]:
                figure, axes = _stack(recording, [panel.title for panel in own])
                for ax, panel in zip(axes, own, strict=True):
                    _draw(ax, panel, recording.time, signals)
                if name == "swivels":
                    _show_slip(axes, recording, locked)
                _mark(figure, marks)
                paths.append(save_figure(figure, directory / f"{name}.png"))
        if (drawn := shapes(recording)) is not None:
            paths.insert(min(3, len(paths)), save_figure(drawn, directory / "shapes.png"))
    return paths


def _draw(ax: Axes, panel: Panel, time: Array, signals: Mapping[str, Array]) -> None:
    for line in panel.lines:
        values = signals[line.signal] - (signals[line.signal][0] if line.from_start else 0.0)
        steps = "steps-post" if panel.steps else "default"
        ax.plot(time, line.factor * values, drawstyle=steps, label=line.label, **_STYLES[line.style])
    if panel.limit is not None:
        ax.axhline(panel.limit[0], color=ACCENTS[2], lw=1.0, ls="--", label=panel.limit[1])
    ax.set_ylabel("" if panel.unit == "1" else f"[{panel.unit}]")
    _widen(ax, 0.5 * panel.least)
    legend(ax)


def _show_slip(axes: Sequence[Axes], recording: Recording, locked: Collection[str]) -> None:
    """Shade slip of the swivels; where both are locked, say so."""
    for ax in axes:
        for end in COLOURS:
            if (name := f"{end}.swivel.slipping") in recording:
                _shade(ax, recording.time, recording[name], end)
        if len(locked) == 2:
            ax.text(0.5, 0.6, "locked", transform=ax.transAxes, ha="center")


def write_duty_figure(trips: Recording, path: Path) -> Path:
    """Draw the table of `hoist_demo.duty` over the number of the trip."""
    degrees = 180.0 / math.pi
    panels: tuple[tuple[str, str, float, dict[str, str]], ...] = (
        ("Yaw of the loop", "yaw [deg]", degrees, {"loop_yaw": "largest", "yaw_start": "as the trip begins"}),
        ("Sway of the loop", "[m]", 1.0, {"sway": "in plane", "sway_across": "out of plane"}),
        ("Ripple of the end forces", "[N]", 1.0, {"rope_force_ripple": "worse end"}),
        ("Smallest clearance between the legs", "[m]", 1.0, {"clearance": ""}),
        ("Change against the trip a cycle before", "[%]", 100.0, {"difference": ""}),
    )
    shown = [panel for panel in panels if any(_shows(trips, name) for name in panel[-1])]
    with matplotlib.rc_context(STYLE):
        figure, axes = stacked_panels([title for title, *_ in shown])
        for ax, (_, label, factor, curves) in zip(axes, shown, strict=True):
            for (name, words), colour in zip(curves.items(), ACCENTS, strict=False):
                if _shows(trips, name):
                    ax.plot(trips["trip"], factor * trips[name], ".-", ms=3.0, color=colour, label=words)
            ax.set_ylabel(label)
            if len(curves) > 1:
                legend(ax)
            if "difference" in curves:
                ax.set_yscale("log")
        axes[-1].set_xlabel("trip")
        return save_figure(figure, path)


def write_ropes_figure(recording: Recording, names: Sequence[str], path: Path) -> Path:
    """Pulls and yaw of several ropes, by the names under which a group of ropes records them."""
    panels = (
        ("Pull on the left conveyance", "$-f_y$ [kN]", -1e-3, "left.fy"),
        ("Pull on the right one", "$-f_y$ [kN]", -1e-3, "right.fy"),
        ("Yaw of the loop", "yaw [deg]", 180.0 / math.pi, "loop.yaw"),
    )
    shown = [panel for panel in panels if any(_shows(recording, f"{name}.{panel[-1]}") for name in names)]
    with matplotlib.rc_context(STYLE):
        figure, axes = _stack(recording, [title for title, *_ in shown])
        for ax, (_, label, factor, signal) in zip(axes, shown, strict=True):
            for name in names:
                ax.plot(recording.time, factor * recording[f"{name}.{signal}"], label=name)
            ax.set_ylabel(label)
        legend(axes[0])
        return save_figure(figure, path)


def shapes(recording: Recording) -> Figure | None:
    """The rope from the front, the side and above at a few instants, and its loop enlarged."""
    rows = shape_rows(recording, 6)
    points = [(recording.time[row], recording.shape_at(row)) for row in rows]
    drawn = [(t, shape) for t, shape in points if shape is not None and bool(np.all(np.isfinite(shape)))]
    if not drawn:
        return None
    figure = Figure(figsize=(8.0, 7.2))
    layout: Any = [["front", "side", "top"], ["front loop", "side loop", "top"]]
    axes = figure.subplot_mosaic(layout, width_ratios=(1.0, 1.0, 1.15), height_ratios=(1.5, 1.0))
    colours = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.9, len(drawn)))
    for colour, (t, shape) in zip(colours, drawn, strict=True):
        x, y, z = shape.T
        label = f"t = {t:.1f} s"
        for name in ("front", "front loop"):
            axes[name].plot(x, y, color=colour, label=label)
        for name in ("side", "side loop"):
            axes[name].plot(z, y, color=colour)
        axes["top"].plot(x, z, color=colour)
    low = min(float(np.min(shape[:, 1])) for _, shape in drawn)
    labels = {"front": ("x [m]", "y [m]"), "side": ("z [m]", "y [m]"), "top": ("x [m]", "z [m]")}
    titles = {
        "front": "Front view, x stretched",
        "front loop": "Loop, front view",
        "side": "Side view, z stretched",
        "side loop": "Loop, side, z stretched",
        "top": "From above, z stretched",
    }
    for name, ax in axes.items():
        view = name.removesuffix(" loop")
        ax.set_title(titles[name])
        ax.set_xlabel(labels[view][0])
        ax.set_ylabel(labels[view][1])
        if name != view:
            ax.set_ylim(low - 0.3, low + 6.0)
        if view == "side":
            _widen(ax, 0.05, axis="x")
    _widen(axes["top"], 0.05)
    figure.legend(*axes["front"].get_legend_handles_labels(), loc="outside lower center", ncols=len(drawn))
    return figure


def save_figure(figure: Figure, path: Path) -> Path:
    """Write the figure; savefig would draw it twice, the first time for the layout alone."""
    figure.set_dpi(150)
    FigureCanvasAgg(figure).print_png(path, metadata={"Software": None})  # type: ignore[no-untyped-call]
    return path


def _shows(recording: Recording, *names: str) -> bool:
    """Return True if all these signals were recorded and computed; a fidelity's gaps are NaN."""
    return all(name in recording and bool(np.isfinite(recording[name]).any()) for name in names)


def _stack(recording: Recording, titles: Sequence[str]) -> tuple[Figure, list[Axes]]:
    """Panels above one another over a common time axis."""
    figure, axes = stacked_panels(titles)
    axes[-1].set_xlabel("time [s]")
    axes[-1].set_xlim(float(recording.time[0]), max(float(recording.time[-1]), float(recording.time[0]) + 1e-9))
    return figure, axes


def stacked_panels(titles: Sequence[str]) -> tuple[Figure, list[Axes]]:
    """Panels above one another over a common axis."""
    figure = Figure(figsize=(8.0, 1.75 * len(titles) + 0.5))
    grid = figure.subplots(len(titles), 1, sharex=True, squeeze=False)
    axes: list[Axes] = list(grid[:, 0])
    for ax, title in zip(axes, titles, strict=True):
        ax.set_title(title)
    figure.align_ylabels(axes)
    return figure, axes


def _mark(figure: Figure, marks: Sequence[Mark]) -> None:
    """Instants in order of time in all panels, their names over the first one, whose title makes room."""
    top = figure.axes[0]
    first, last = top.get_xlim()
    lines: list[float] = []  # of names: where each is free from on, as a share of the panel's width
    for mark in marks:
        for ax in figure.axes:
            ax.axvline(mark.t, color="black", lw=0.8, ls=(0, (4, 3)))
        begin, width = (mark.t - first) / (last - first), _LETTER * len(mark.label)
        if right := begin > 0.6:
            begin -= width
        line = next((k for k, free in enumerate(lines) if free <= begin), len(lines))
        lines[line : line + 1] = [begin + width]
        top.annotate(
            mark.label,
            (mark.t, 1.0),
            xycoords=top.get_xaxis_transform(),
            xytext=(-2 if right else 2, 1 + _LINE * line),
            textcoords="offset points",
            ha="right" if right else "left",
            va="bottom",
            fontsize=7.0,
        )
    if lines:
        top.set_title(top.get_title(loc="left"), pad=6.0 + _LINE * len(lines))


#: Width of a letter of a mark's name, as a share of the panel's, and height of a line of names in points.
_LETTER, _LINE = 0.009, 9.0


def legend(ax: Axes) -> None:
    """Legend beside the panel, where it hides nothing."""
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)


def _widen(ax: Axes, least: float, axis: str = "y") -> None:
    """Keep rounding errors from filling a panel: show at least a range of +- `least` about the middle."""
    low, high = ax.get_ylim() if axis == "y" else ax.get_xlim()
    if high - low < 2.0 * least and math.isfinite(high - low):
        middle = (low + high) / 2.0
        set_limits = ax.set_ylim if axis == "y" else ax.set_xlim
        set_limits(middle - least, middle + least)


def _shade(ax: Axes, t: Array, slipping: Array, end: str) -> None:
    """Tint the upper half (left end) or lower half (right end) where the swivel slips."""
    low, high = (0.5, 1.0) if end == "left" else (0.0, 0.5)
    inside = slipping > 0.5
    ax.fill_between(
        t,
        low,
        high,
        where=inside.tolist(),
        step="post",
        transform=ax.get_xaxis_transform(),
        color=COLOURS[end],
        alpha=0.12,
        lw=0.0,
        label=f"{end} slips" if bool(inside.any()) else None,
    )
