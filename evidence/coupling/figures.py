"""Error over communication step, cost over error, and the map of stability."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from evidence.drawing import ACCENTS, COLOURS, REFERENCE, figure
from evidence.tables import Table, Tables, rows
from hoist_demo.cosimulation.schemes.stability import MARGIN

from .light import IMPEDANCE, LEG

#: colour by kind of scheme, marker by order
KINDS = {
    "jacobi": ACCENTS[3],
    "gauss-seidel": COLOURS["left"],
    "impulse-preserving": REFERENCE,
    "semi-implicit": COLOURS["right"],
    "iterative": ACCENTS[0],
    "implicit-impulse": "black",
    "energy-controlled": ACCENTS[1],
}
MARKERS = {"0": "o", "1": "s", "2": "^", "jacobian": "D", "aitken": "v", "secant": "P"}


def look(scheme: str) -> dict[str, Any]:
    """Colour and marker of a scheme."""
    kind, _, last = scheme.rpartition("-")
    colour = KINDS.get(scheme) or KINDS[kind]
    return {"color": colour, "marker": MARKERS.get(last, "x"), "ls": "--" if kind == "jacobi" else "-"}


def _curves(ax: Axes, t: Table, x: str, y: str) -> None:
    for scheme in dict.fromkeys(t["scheme"].tolist()):
        r = rows(t, scheme=scheme)
        scale = 1e3 if x == "H [s]" else 1.0
        ax.plot(scale * r[x], r[y], label=scheme, ms=4.5, **look(scheme))
    ax.set(xscale="log", yscale="log")


def error(tables: Tables) -> Figure:
    """Error over step, on both scenes."""
    made, axes = figure(1, 2, 5.4)
    scenes = (("oscillator", "two masses, against the exact solution"), ("schemes", "hoist, against the converged one"))
    for ax, (name, title) in zip(axes[0], scenes, strict=True):
        t = tables[name]
        finite = {key: column[np.isfinite(t["force error"])] for key, column in t.items()}
        _curves(ax, finite, "H [s]", "force error")
        ax.set(xlabel="communication step H [ms]", title=title)
        ax.set_xticks([5, 10, 20, 40], ["5", "10", "20", "40"])
        ax.minorticks_off()
    axes[0, 0].set_ylabel("RMS error of the force / largest force")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    made.legend(handles, labels, loc="outside lower center", ncols=5)
    return made


def cost(tables: Tables) -> Figure:
    """Error over processor time on the hoist."""
    made, axes = figure(1, 1, 5.2)
    t = tables["schemes"]
    finite = {key: column[np.isfinite(t["force error"])] for key, column in t.items()}
    _curves(axes[0, 0], finite, "cost [s/s]", "force error")
    axes[0, 0].set(
        xlabel="processor time per simulated second [s/s], rope on steps of 2.5 ms",
        ylabel="RMS error of the end forces / largest force",
        title="Hoist: error over cost, communication steps of 40, 20, 10 and 5 ms",
    )
    made.legend(loc="outside lower center", ncols=5)
    return made


def stability(tables: Tables) -> Figure:
    """What was stable, with theory drawn in."""
    t = tables["stability"]
    names = list(dict.fromkeys(t["scheme"].tolist()))
    made, axes = figure(2, 4, 7.0, sharex=True, sharey=True)
    for ax, name in zip(axes.flat, names, strict=True):
        r = rows(t, scheme=name)
        H, mass, stable = 1e3 * r["H [s]"], r["mass [kg]"] / LEG, r["stable"] > 0
        ax.plot(H[stable], mass[stable], "o", color=ACCENTS[0], ms=5, label="stable")
        ax.plot(H[~stable], mass[~stable], "x", color=ACCENTS[2], ms=6, label="unstable")
        told = r["predicted growth"] >= MARGIN
        ax.plot(H[told], mass[told], "s", color=COLOURS["left"], mfc="none", ms=10, lw=0.5, label="predicted unstable")
        steps, first = np.unique(r["H [s]"], return_index=True)
        ax.plot(1e3 * steps, r["added mass [kg]"][first] / LEG, "-", color=REFERENCE, label="M = added mass")
        ax.plot(1e3 * steps, 0.5 * IMPEDANCE * steps / LEG, "--", color=REFERENCE, label="M = Z H / 2")
        ax.set(xscale="log", yscale="log", title=name, ylim=(0.08, 8.0))
        ax.set_xticks([5, 10, 20, 40], ["5", "10", "20", "40"])
        ax.minorticks_off()
    for ax in axes[-1]:
        ax.set_xlabel("communication step H [ms]")
    for ax in axes[:, 0]:
        ax.set_ylabel("conveyance M / leg")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    made.legend(handles, labels, loc="outside lower center", ncols=5)
    return made


FIGURES: dict[str, Callable[[Tables], Figure]] = {"error": error, "cost": cost, "stability": stability}
