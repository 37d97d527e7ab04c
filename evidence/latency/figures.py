"""The share of a trip's steps that take longer than a time."""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.figure import Figure

from benchmarks.latency import FMU_STEP
from evidence.drawing import CURVES, REFERENCE, figure
from evidence.tables import Tables, rows


def distribution(tables: Tables) -> Figure:
    """One curve per scene and trip; the communication step as a line."""
    made, axes = figure(1, 1, 4.6)
    t, ax = tables["curves"], axes[0, 0]
    for scene, colour in zip(dict.fromkeys(t["scene"].tolist()), CURVES, strict=False):
        for trip, style in zip(dict.fromkeys(t["trip"].tolist()), ("-", "--"), strict=True):
            r = rows(t, scene=scene, trip=trip)
            ax.plot(
                1e6 * r["time [s]"], r["share"], style, color=colour, label=f"{scene}, {trip}", drawstyle="steps-pre"
            )
    ax.axvline(1e6 * FMU_STEP, color=REFERENCE, lw=1.0)
    ax.text(0.94e6 * FMU_STEP, 0.5, "communication step", ha="right", color=REFERENCE)
    ax.set(
        xscale="log",
        yscale="log",
        xlabel="time of a step [us]",
        ylabel="share of the steps that take longer",
        title=f"Level standard, communication steps of {1e3 * FMU_STEP:g} ms, in process: the steps' own times",
    )
    ax.legend(loc="lower left")
    return made


FIGURES: dict[str, Callable[[Tables], Figure]] = {"distribution": distribution}
