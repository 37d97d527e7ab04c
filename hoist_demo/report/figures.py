"""Figures of a run, as PNG files whose bytes depend on the data alone.

Blue is always the left end, orange the right one, grey the reference or limit. A figure or panel
whose signals were not recorded, or never move, is left out.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler
from numpy.typing import NDArray

from hoist_demo.cosimulation.participants.rope_data import NO_DATA, RopeData
from hoist_demo.parameters import Hoist
from hoist_demo.recording.ropes import rope_signals
from hoist_demo.recording.time_series import Array, Recording, shape_rows
from hoist_demo.report.panel_layout import (
    ABOVE,
    BELOW,
    TITLE_PAD,
    WIDTH,
    lay_out_stack,
    legend,
    place_labels,
    stacked_panels,
    widest_labels,
)
from hoist_demo.report.panels import Mark, Panel, derived_signals, is_constant, panels
from rope_model.files import whole_file

COLOURS = {"left": "#1f5fa8", "right": "#d9731a"}
#: The right end's gaps show the left one where both coincide.
DASHES: dict[str, Any] = {"left": "-", "right": (0, (4, 2.5))}
REFERENCE = "#8a8a8a"
ACCENTS = ("#2f8f5b", "#8e44ad", "#b03a2e", "#5d6d7e")

_STYLE_FILE = Path(__file__).with_name("figures.mplstyle")
STYLE: dict[Any, Any] = {
    **matplotlib.rc_params_from_file(_STYLE_FILE, use_default_template=False),
    "axes.prop_cycle": cycler(color=(*ACCENTS, *COLOURS.values(), "black")),
}

#: Shortest axis of time of a run that stopped at once [s]: an axis needs a length.
SHORTEST_AXIS = 1e-9
SHAPES_PLACE = 3  #: Place of the figure of shapes among the others.

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
    **{
        letter: {"color": colour}
        for letter, colour in zip("abcde", (*ACCENTS, "black"), strict=True)
    },
}


def write_figures(
    recording: Recording,
    hoist: Hoist,
    directory: Path,
    marks: Sequence[Mark] = (),
    ropes: Sequence[RopeData] = (NO_DATA,),
) -> list[Path]:
    """Write PNG files, with ``marks`` as dashed lines, and return their paths in reading order."""
    signals = dict(recording.signals)
    for name, (values, _) in derived_signals(recording, hoist).items():
        signals[name] = values
    names = [rope.name for rope in ropes]
    shown = [
        panel for panel in panels(recording, hoist, names) if not is_constant(recording, panel)
    ]
    paths: list[Path] = []
    with matplotlib.rc_context(STYLE):
        for name, groups in _FIGURES.items():
            of_figure = [panel for panel in shown if panel.group in groups]
            if not of_figure:
                continue
            figure, axes = stacked_panels([panel.title for panel in of_figure])
            axes[-1].set_xlabel("time [s]")
            start = float(recording.time[0])
            end = float(recording.time[-1])
            axes[-1].set_xlim(start, max(end, start + SHORTEST_AXIS))
            for ax, panel in zip(axes, of_figure, strict=True):
                _draw(ax, panel, recording.time, signals)
            if name == "swivels":
                _show_slip(axes, recording)
            lay_out_stack(figure, axes, _mark(figure, marks))
            paths.append(save_figure(figure, directory / f"{name}.png"))
        figure_of_shapes = shapes(recording, ropes)
        if figure_of_shapes is not None:
            path = save_figure(figure_of_shapes, directory / "shapes.png")
            paths.insert(min(SHAPES_PLACE, len(paths)), path)
    return paths


def _draw(ax: Axes, panel: Panel, time: Array, signals: Mapping[str, Array]) -> None:
    for line in panel.lines:
        values = signals[line.signal]
        start = values[0] if line.from_start else 0.0
        ax.plot(time, line.factor * (values - start), label=line.label, **_STYLES[line.style])
    if panel.limit is not None:
        ax.axhline(panel.limit.value, color=ACCENTS[2], lw=1.0, ls="--", label=panel.limit.label)
    ax.set_ylabel("" if panel.unit == "1" else f"[{panel.unit}]")
    _widen(ax, 0.5 * panel.min_range)
    legend(ax)


def _show_slip(axes: Sequence[Axes], recording: Recording) -> None:
    """Tint the upper half (left end) or lower half (right end) where a swivel slips."""
    for ax, (end, low) in product(axes, (("left", 0.5), ("right", 0.0))):
        name = f"{end}.swivel.slipping"
        if name in recording:
            slipping = recording[name] > 0.5
            ax.fill_between(
                recording.time,
                low,
                low + 0.5,
                where=slipping.tolist(),
                step="post",
                transform=ax.get_xaxis_transform(),
                color=COLOURS[end],
                alpha=0.12,
                lw=0.0,
                label=f"{end} slips" if bool(slipping.any()) else None,
            )


class _TripPanel(NamedTuple):
    """Panel over the number of the trip."""

    title: str
    axis: str  # label of the axis
    labels: Mapping[str, str]  # by column of the table of trips
    factor: float = 1.0  # to the unit of the axis


_TRIP_PANELS = (
    _TripPanel(
        "Yaw of the loop",
        "yaw [deg]",
        {"loop_yaw": "largest", "yaw_start": "as the trip begins"},
        factor=180.0 / math.pi,
    ),
    _TripPanel("Sway of the loop", "[m]", {"sway": "in plane", "sway_across": "out of plane"}),
    _TripPanel("Ripple of the end forces", "[N]", {"rope_force_ripple": "worse end"}),
    _TripPanel("Smallest clearance between the legs", "[m]", {"clearance": ""}),
    _TripPanel("Change against the trip a cycle before", "[%]", {"difference": ""}, factor=100.0),
)


def write_duty_figure(trips: Recording, path: Path) -> Path:
    """Draw the table of ``hoist_demo.duty`` over the number of the trip.

    A panel without numbers is left out.
    """
    declared = [
        panel._replace(labels=_curves_over_trips(trips, panel.labels)) for panel in _TRIP_PANELS
    ]
    shown = [panel for panel in declared if panel.labels]
    with matplotlib.rc_context(STYLE):
        figure, axes = stacked_panels([panel.title for panel in shown])
        for ax, panel in zip(axes, shown, strict=True):
            for name, label in panel.labels.items():
                ax.plot(trips["trip"], panel.factor * trips[name], ".-", ms=3.0, label=label)
            ax.set_ylabel(panel.axis)
            if len(panel.labels) > 1:
                legend(ax)
            if "difference" in panel.labels:
                ax.set_yscale("log")
        axes[-1].set_xlabel("trip")
        lay_out_stack(figure, axes)
        return save_figure(figure, path)


def _curves_over_trips(trips: Recording, curves: Mapping[str, str]) -> dict[str, str]:
    """Return the columns of a panel with their labels; of several ropes with each rope's name."""
    found: dict[str, str] = {}
    for column, values in trips.signals.items():
        rope, _, name = column.rpartition(".")
        if name in curves and np.isfinite(values).any():
            found[column] = ", ".join(filter(None, (rope, curves[name])))
    return found


def shapes(recording: Recording, ropes: Sequence[RopeData]) -> Figure | None:
    """Draw the ropes and their loops, enlarged, from the front and the side at a few instants."""
    drawn = []
    for row in shape_rows(recording, 6):
        curves = _curves_at(recording, ropes, row)
        if curves:
            drawn.append((recording.time[row], curves))
    if not drawn:
        return None
    figure = Figure(figsize=(WIDTH, _SHAPES_HEIGHT))
    grid = figure.subplots(2, 2, sharex="col", height_ratios=(1.5, 1.0))
    colours = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.9, len(drawn)))
    low = min(min(float(np.min(shape[:, 1])) for shape in curves) for _, curves in drawn)
    for column, (view, axis) in enumerate((("Front view", "x"), ("Side view", "z"))):
        for row, title in enumerate((f"{view}, {axis} stretched", f"{view} of the loop")):
            ax = grid[row, column]
            for colour, (t, curves) in zip(colours, drawn, strict=True):
                for shape in curves:
                    label = "" if shape is not curves[0] else f"t = {t:.1f} s"
                    ax.plot(shape[:, 2 * column], shape[:, 1], color=colour, label=label)
            ax.set_title(title)
            ax.set_ylabel("y [m]")
            if row == 1:
                ax.set_xlabel(f"{axis} [m]")
                ax.set_ylim(low - 0.3, low + 6.0)
        _widen(grid[0, column], 0.05, axis="x")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=len(drawn))
    _lay_out_shapes(figure, grid)
    return figure


_SHAPES_HEIGHT = 7.2  #: Height of the figure of shapes [inch].
_SHAPES_LEGEND = 0.3  #: Height of the legend below them [inch].
_SHAPES_RIGHT = 0.15  #: Margin right of them, for half of a tick label [inch].


def _lay_out_shapes(figure: Figure, grid: NDArray[np.object_]) -> None:
    """Place the four views between their labels and the legend."""
    bottom = BELOW + _SHAPES_LEGEND
    row = (_SHAPES_HEIGHT - bottom - 2.0 * ABOVE) / 2.0
    figure.subplots_adjust(
        bottom=bottom / _SHAPES_HEIGHT, top=1.0 - ABOVE / _SHAPES_HEIGHT, hspace=ABOVE / row
    )
    axes: list[Axes] = grid.ravel().tolist()
    left = widest_labels(figure, axes)
    column = (WIDTH - _SHAPES_RIGHT) / 2.0 - left
    figure.subplots_adjust(
        left=left / WIDTH, right=1.0 - _SHAPES_RIGHT / WIDTH, wspace=left / column
    )
    place_labels(figure, axes, left)


def _curves_at(recording: Recording, ropes: Sequence[RopeData], row: int) -> list[Array]:
    """Return the curves in the shaft (n, 3) [m] of the ropes that hang at a row."""
    curves = []
    for rope in ropes:
        signals = rope_signals(recording, rope.name)
        if row < len(signals.time):
            shape = signals.shape_at(row)
            if shape is not None and np.isfinite(shape).all():
                curves.append(np.asarray(shape + rope.suspension.origin))
    return curves


#: Two thirds of the time of the default level, for files that are 1 % larger.
_COMPRESSION = {"compress_level": 4}


def save_figure(figure: Figure, path: Path) -> Path:
    """Write the figure; savefig would draw it twice, the first time for the layout alone."""
    with whole_file(path) as draft:
        canvas = FigureCanvasAgg(figure)
        canvas.print_png(draft, metadata={"Software": None}, pil_kwargs=_COMPRESSION)  # type: ignore[no-untyped-call]
    return path


def _mark(figure: Figure, marks: Sequence[Mark]) -> float:
    """Draw marks as dashed lines in all panels, with their names over the first one.

    Return the height of the names [points].
    """
    top = figure.axes[0]
    first, last = top.get_xlim()
    # end of the last name in each line of names, as a share of the panel's width
    lines: list[float] = []
    for mark in marks:
        for ax in figure.axes:
            ax.axvline(mark.t, color="black", lw=0.8, ls=(0, (4, 3)))
        begin = (mark.t - first) / (last - first)
        width = _LETTER * len(mark.label)
        offset = 2  # of the name from the mark [points]
        alignment = "left"
        if begin > _RIGHT_PART:
            begin -= width
            offset = -2
            alignment = "right"
        line = next((k for k, free in enumerate(lines) if free <= begin), len(lines))
        lines[line : line + 1] = [begin + width]
        top.annotate(
            mark.label,
            (mark.t, 1.0),
            xycoords=top.get_xaxis_transform(),
            xytext=(offset, 1 + _LINE * line),
            textcoords="offset points",
            ha=alignment,
            va="bottom",
            fontsize=7.0,
        )
    height = _LINE * len(lines)
    top.set_title(top.get_title(loc="left"), pad=TITLE_PAD + height)
    return height


_LETTER = 0.009  #: Width of a letter of a mark's name, as a share of the panel's.
_LINE = 9.0  #: Height of a line of names in points.
_RIGHT_PART = 0.6  #: Share of the width beyond which a name stands left of its mark.


def _widen(ax: Axes, half_range: float, axis: str = "y") -> None:
    """Show at least +- ``half_range`` about the middle, so that no rounding error fills a panel."""
    low, high = ax.get_ylim() if axis == "y" else ax.get_xlim()
    if high - low < 2.0 * half_range and math.isfinite(high - low):
        middle = (low + high) / 2.0
        ax.set(**{f"{axis}lim": (middle - half_range, middle + half_range)})
