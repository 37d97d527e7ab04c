"""Figures of the worked studies: winding time and swing over jerk and creep, arrivals, and swivels along a winding."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from evidence.rendering import DOCS
from hoist_demo.parameters import Hoist
from hoist_demo.study.store import Results, Store

from .page import NAMES

IMAGES = DOCS / "images" / "study"
COLOURS = ("#b03a2e", "#d9731a", "#8e44ad", "#1f5fa8", "#2f8f5b")
CREEP_COLOURS = dict(zip(NAMES, ("#b03a2e", "#d9731a", "#2f8f5b"), strict=True))
STYLE: dict[Any, Any] = {"font.size": 9, "axes.grid": True, "grid.color": "#e3e3e3", "savefig.dpi": 150}


def creep_figure(creep: pd.DataFrame) -> Figure:
    """Winding time, swing and ripple over the creeps, a line per controller and jerk."""
    figure, axes = plt.subplots(1, 3, figsize=(9.0, 3.6), layout="constrained")
    for (controller, jerk), rows in creep.groupby(["controller", "winding.jerk"], sort=False):
        style = {"color": CREEP_COLOURS[controller], "ls": "-" if jerk > 2.0 else "--", "marker": "o", "ms": 4}
        axes[0].plot(rows["variant"], rows["cycle_time"], **style, label=f"{NAMES[controller]}, {jerk:g} m/s$^3$")
        axes[1].semilogy(rows["variant"], 1e3 * rows["swing_right"], **style)
        axes[2].plot(rows["variant"], rows["rope_force_ripple"], **style)
    axes[0].set_ylabel("winding time [s]")
    axes[1].set_ylabel("swing after arrival, right [mm]")
    axes[2].set_ylabel("rope force ripple [N]")
    for axis in axes:
        axis.tick_params(axis="x", rotation=35)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", frameon=False, fontsize=8, ncols=3)
    return figure


def controllers(results: Results) -> None:
    """Winding time and residual swing over jerk, per controller."""
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.4), layout="constrained")
    for colour, (variant, rows) in zip(COLOURS, results.table.groupby("variant", sort=False), strict=False):
        axes[0].plot(rows["winding.jerk"], rows["cycle_time"], "o-", color=colour, label=variant)
        axes[1].semilogy(rows["winding.jerk"], 1e3 * rows["swing_right"], "o-", color=colour)
    axes[0].set(xlabel="limit of jerk [m/s$^3$]", ylabel="winding time [s]")
    axes[1].set(xlabel="limit of jerk [m/s$^3$]", ylabel="residual swing, right, peak to peak [mm]")
    axes[0].legend(frameon=False, fontsize=8)
    save(figure, "controllers")


def arrivals(store: Store, results: Results) -> None:
    """The right conveyance against the rope at the sheave, and the torque, about the arrival."""
    figure, axes = plt.subplots(2, 1, figsize=(9.0, 5.2), sharex=True, layout="constrained")
    radius = Hoist().sheave_radius
    for colour, row in zip(COLOURS, results.table.itertuples(), strict=False):
        series = store.signals(row.key)
        t = 0.01 * np.arange(len(series)) - 1.0  # s, from the end of the start delay
        swing = series["conveyance.right.y"] + radius * series["drive.angle"]
        axes[0].plot(t, 1e3 * (swing - swing.iloc[-1]), color=colour, label=row.variant)
        axes[1].plot(t, 1e-3 * series["drive.torque"], color=colour)
        axes[0].axvline(row.cycle_time, color=colour, lw=0.8, ls=":")
    axes[0].set(ylabel="right conveyance on its ropes [mm]", xlim=(20.5, 27.5), ylim=(-10.0, 9.0))
    axes[1].set(ylim=(30.0, 70.0), ylabel="motor torque [kN m]", xlabel="time since the start of the trip [s]")
    axes[0].legend(frameon=False, fontsize=8, ncols=2)
    save(figure, "arrival")


def swivels(store: Store, results: Results) -> None:
    """Torque and angle of the right swivel and yaw of the loop along the winding, without and with installed twist."""
    twists = results.table["rope.installed_twist"].unique()
    variants = list(results.table["variant"].unique())
    colours = dict(zip(variants, plt.get_cmap("viridis")(np.linspace(0.0, 0.9, len(variants))), strict=True))
    figure, axes = plt.subplots(3, len(twists), figsize=(9.0, 7.0), sharex=True, layout="constrained")
    for column, twist in enumerate(twists):
        axes[0, column].set_title(f"installed twist {twist / (2 * np.pi):.2g} turns", fontsize=9)
        for row in results.table[results.table["rope.installed_twist"] == twist].itertuples():
            series = store.signals(row.key)
            t = 0.01 * np.arange(len(series))
            axes[0, column].plot(t, series["right.swivel.torque"], color=colours[row.variant], lw=1, label=row.variant)
            axes[1, column].plot(t, series["right.swivel.angle"] / (2 * np.pi), color=colours[row.variant], lw=1)
            axes[2, column].plot(t, np.degrees(series["loop.yaw"]), color=colours[row.variant], lw=1)
        axes[2, column].set_xlabel("time [s]")
    for k, label in enumerate(("right swivel torque [N m]", "right swivel angle [turns]", "loop yaw [deg]")):
        axes[k, 0].set_ylabel(label)
    figure.legend(
        *axes[0, 0].get_legend_handles_labels(), loc="outside lower center", frameon=False, fontsize=8, ncols=4
    )
    save(figure, "swivel")


def save(figure: Any, name: str) -> None:
    """The figure without a date, so that the same data give the same bytes."""
    figure.savefig(IMAGES / f"{name}.png", metadata={"Software": None})
    plt.close(figure)
