"""Figures of what each place in the rope went through, over the place."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from hoist_demo.recording.exposure import BINS, VIBRATING, bin_columns
from hoist_demo.recording.time_series import Array, Recording
from hoist_demo.report.figures import ACCENTS, STYLE, save_figure, stacked_panels

_UNITS = {"curvature": ("[1/m]", 1.0), "torque": ("[N m]", 1.0), "tension": ("[kN]", 1e-3)}
FAINTEST = 1e-3  #: Part of the largest amplitude below which nothing is told apart.
_PLACE = "place in the rope, from its left end [m]"


def write_exposure_figure(exposure: Recording, path: Path) -> Path:
    """Draw the table of `hoist_demo.recording.exposure`, without panels for what the fidelity leaves out."""
    shown = [name for name in _UNITS if np.isfinite(exposure[f"{name}.range"]).any()]
    curves = {"curvature.cycles": ("Bending cycles", "number"), "bent": ("Time in the bend", "[s]")}
    titles = [f"Cycles of {name} by their range; the line is the largest" for name in shown]
    with matplotlib.rc_context(STYLE):
        figure, axes = stacked_panels([*titles, *(title for title, _ in curves.values()), "Strongest vibration"])
        for ax, name in zip(axes, shown, strict=False):
            _draw_ranges(figure, ax, exposure, name)
        for ax, (name, (_, label)) in zip(axes[len(shown) :], curves.items(), strict=False):
            ax.fill_between(exposure["s"], exposure[name], color=ACCENTS[0], alpha=0.3, lw=0.0)
            ax.plot(exposure["s"], exposure[name], color=ACCENTS[0])
            ax.set_ylabel(label)
            ax.set_ylim(bottom=0.0)
        for name, colour in zip(VIBRATING, ACCENTS, strict=False):
            if name in shown:
                axes[-1].plot(exposure["s"], exposure[f"{name}.frequency"], ".", ms=4.0, color=colour, label=name)
        axes[-1].set_ylabel("[Hz]")
        axes[-1].set_ylim(bottom=0.0)
        axes[-1].legend()
        axes[-1].set_xlabel(_PLACE)
        return save_figure(figure, path)


def write_spectra_figure(spectra: Recording, s: Array, path: Path) -> Path | None:
    """Draw the table of `hoist_demo.recording.exposure.spectra_table` for stations at `s` [m]; None if empty."""
    shown = {name: np.array([spectra[f"{name}[{k + 1}]"] for k in range(s.size)]).T for name in VIBRATING}
    shown = {name: amplitude for name, amplitude in shown.items() if np.nanmax(amplitude, initial=0.0) > 0.0}
    if not shown:
        return None
    with matplotlib.rc_context(STYLE):
        figure, axes = stacked_panels([f"Amplitude of {name} over frequency" for name in shown])
        for ax, (name, amplitude) in zip(axes, shown.items(), strict=True):
            label, factor = _UNITS[name]
            largest = factor * float(np.nanmax(amplitude))
            colours = LogNorm(FAINTEST * largest, largest, clip=True)
            mesh = ax.pcolormesh(s, spectra["frequency"], factor * amplitude, norm=colours, shading="nearest")
            figure.colorbar(mesh, ax=ax, label=label)
            seen = spectra["frequency"][np.nanmax(factor * amplitude, axis=1) > FAINTEST * largest]
            ax.set_ylim(seen[0], seen[-1])
            _use_log_scale(ax, "[Hz]")
        axes[-1].set_xlabel(_PLACE)
        return save_figure(figure, path)


def _draw_ranges(figure: Figure, ax: Axes, exposure: Recording, name: str) -> None:
    label, factor = _UNITS[name]
    edges = factor * np.array([*BINS[name], 2.0 * BINS[name][-1]])
    counts = np.ma.masked_less_equal([exposure[column] for column in bin_columns(name)], 0.0)
    s = exposure["s"]
    sides = np.concatenate(([s[0]], 0.5 * (s[1:] + s[:-1]), [s[-1]]))
    if counts.count():
        most = max(float(counts.max()), 1.0)
        mesh = ax.pcolormesh(sides, edges, counts, norm=LogNorm(0.5, most), cmap="viridis_r")
        ticks = [0.5, *(digit * 10.0**power for power in range(6) for digit in (1, 2, 5))]
        bar = figure.colorbar(mesh, ax=ax, label="number", ticks=[x for x in ticks if x <= most], format="%g")
        bar.minorticks_off()
        top = np.flatnonzero(counts.filled(0.0).any(axis=1))[-1]
        ax.set_ylim(edges[0], edges[top + 1])
    ax.plot(s, factor * exposure[f"{name}.range"], color="black", lw=0.8)
    _use_log_scale(ax, label)


def _use_log_scale(ax: Axes, label: str) -> None:
    """Few numbers as they are, not as powers."""
    ax.set_yscale("log")
    bottom, top = ax.get_ylim()
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if top < 500.0 * bottom else (1.0,)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.minorticks_off()
    ax.set_ylabel(label)
