"""Kinetic energy of both meshes, and what a transformation changes."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from evidence.claims import below
from evidence.drawing import COLOURS, REFERENCE, figure
from evidence.tables import Tables

from .section import Claim, Picture, Section
from .windings import COUPLINGS

#: J, stated in the source: change per transformation, and difference to EEM of about 1e4 J
SOURCE_CHANGE, SOURCE_DIFFERENCE = 1e-4, 1.0


def changes(
    tables: Tables, coupling: str, kind: str = "kinetic [J]"
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Instants and energy changes of the transformations."""
    t = tables["transformations"]
    mine = t["coupling"] == coupling
    return t["t [s]"][mine], t[kind][mine]


def largest_change(tables: Tables) -> float:
    """J, of both windings."""
    return float(max(np.abs(changes(tables, coupling)[1]).max() for coupling in COUPLINGS))


def relative_change(tables: Tables) -> float:
    """Largest change of the kinetic energy over the kinetic energy at that instant."""
    worst = 0.0
    for coupling in COUPLINGS:
        t = tables[f"winding-{coupling}"]
        at, change = changes(tables, coupling)
        worst = max(worst, float(np.max(np.abs(change) / np.interp(at, t["t [s]"], t["TMN-ETM kinetic [J]"]))))
    return worst


def claims(tables: Tables) -> list[Claim]:
    """What the source says of the energy."""
    difference = max(np.abs(tables[f"winding-{c}"]["difference kinetic [J]"]).max() for c in COUPLINGS)
    return [
        Claim(
            "energy before and after a transformation agrees",
            below("largest relative change of the kinetic energy", relative_change(tables), 1e-6),
        ),
        Claim(
            "the kinetic energy changes by less than 1e-4 J per transformation",
            below("largest change", largest_change(tables), SOURCE_CHANGE, "J"),
        ),
        Claim(
            "the kinetic energy differs from EEM by less than 1 J of 1e4 J",
            below("largest difference", difference, SOURCE_DIFFERENCE, "J"),
        ),
    ]


def draw(tables: Tables) -> Figure:
    """Energy, difference, changes."""
    made, axes = figure(3, 1, 6.6, sharex=True)
    ax = axes[0, 0]
    for coupling, colour in zip(COUPLINGS, (COLOURS["right"], COLOURS["left"]), strict=True):
        t = tables[f"winding-{coupling}"]
        if coupling == "coupled":
            ax.plot(t["t [s]"], 1e-3 * t["EEM kinetic [J]"], color=REFERENCE, lw=3.5, alpha=0.55, label="EEM, coupled")
            ax.plot(t["t [s]"], 1e-3 * t["TMN-ETM kinetic [J]"], color=colour, lw=1.1, label="TMN-ETM, coupled")
        axes[1, 0].plot(t["t [s]"], t["difference kinetic [J]"], color=colour, lw=1.1, label=coupling)
        at, change = changes(tables, coupling)
        axes[2, 0].semilogy(at, np.abs(change), "o", ms=4, mfc="none", color=colour, label=f"kinetic, {coupling}")
    axes[2, 0].semilogy(
        *_sizes(changes(tables, "coupled", "potential [J]")), ".", color=REFERENCE, label="potential, coupled"
    )
    axes[2, 0].axhline(SOURCE_CHANGE, color="black", lw=0.8, ls="--", label="bound of the source")
    for ax, label, title in zip(
        axes[:, 0],
        ("kinetic energy [kJ]", "TMN-ETM - EEM [J]", "change [J]"),
        ("Kinetic energy of the rope", "Difference of the meshes", "Size of the energy change at each transformation"),
        strict=True,
    ):
        ax.set_ylabel(label)
        ax.set_title(title)
        ax.legend(loc="upper left" if ax is axes[0, 0] else "best")
    axes[2, 0].set_ylim(bottom=1e-12)  # room for the legend
    axes[2, 0].legend(loc="lower left", ncols=2)
    axes[2, 0].set_xlabel("time [s]")
    return made


def _sizes(pair: tuple[NDArray[np.float64], NDArray[np.float64]]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return pair[0], np.abs(pair[1])


def numbers(tables: Tables) -> dict[str, Any]:
    """Counts and sums of the transformations' changes of energy."""
    found = []
    for coupling in COUPLINGS:
        at, kinetic = changes(tables, coupling)
        potential = changes(tables, coupling, "potential [J]")[1]
        sums = {"kinetic": kinetic.sum(), "potential": potential.sum()}
        found.append({"coupling": coupling, "count": at.size, "median": np.median(np.abs(kinetic)), **sums})
    return {"windings": found}


SECTION = Section(
    key="energies",
    title="Kinetic energy",
    pictures=[Picture("energies", "Kinetic energy, its difference between the meshes, and its changes", draw)],
    claims=claims,
    numbers=numbers,
    data=["transformations", *(f"winding-{coupling}" for coupling in COUPLINGS)],
)
