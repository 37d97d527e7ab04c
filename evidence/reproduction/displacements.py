"""Lateral displacement and twist at the two observation points: EEM against TMN-ETM, uncoupled and coupled."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from evidence.claims import above, below
from evidence.drawing import COLOURS, REFERENCE, figure
from evidence.rendering import number
from evidence.tables import Tables

from .section import Claim, Picture, Section
from .windings import COUPLINGS, SIDES

Array = NDArray[np.float64]

QUANTITIES = ("out of plane [mm]", "in plane [mm]", "theta [mrad]")


def largest(tables: Tables, coupling: str, quantity: str, which: str) -> float:
    """Largest size over time and both points; ``which`` is a mesh or 'difference'."""
    t = tables[f"winding-{coupling}"]
    return float(np.max(np.abs([t[f"{which} {side} {quantity}"] for side in SIDES])))


def worst_difference(tables: Tables, quantities: tuple[str, ...]) -> float:
    """Largest difference between the meshes over the largest value, %; what is zero in both is left out."""
    pairs = [
        (largest(tables, coupling, quantity, "difference"), largest(tables, coupling, quantity, "EEM"))
        for coupling in COUPLINGS
        for quantity in quantities
    ]
    return 100 * max(difference / value for difference, value in pairs if value > 0)


def margin(tables: Tables) -> float:
    """Smallest displacement out of plane of either leg to its own side, mm; negative when they share a side."""
    t = tables["winding-coupled"]
    legs = [t[f"EEM {side} out of plane [mm]"] for side in SIDES]
    sense = np.sign(legs[0][0])
    return float(min(np.min(sense * legs[0]), np.min(-sense * legs[1])))


def claims(tables: Tables) -> list[Claim]:
    """What the source says of the displacements."""
    return [
        Claim(
            "left and right out-of-plane displacement keep opposite signs through the whole travel",
            above("smallest displacement of either leg to its own side", margin(tables), 0.0, "mm"),
        ),
        Claim(
            "TMN-ETM agrees with EEM in displacement",
            below("largest difference over largest displacement", worst_difference(tables, QUANTITIES[:2]), 1.0, "%"),
        ),
        Claim(
            "TMN-ETM agrees with EEM in twist",
            below("largest difference over largest theta", worst_difference(tables, QUANTITIES[2:]), 1.0, "%"),
        ),
    ]


def draw(tables: Tables) -> Figure:
    """Three quantities, uncoupled and coupled."""
    made, axes = figure(3, 2, 7.2, sharex=True, sharey="row")
    for k, coupling in enumerate(COUPLINGS):
        t = tables[f"winding-{coupling}"]
        for ax, quantity in zip(axes[:, k], QUANTITIES, strict=True):
            for side in SIDES:
                ax.plot(t["t [s]"], t[f"EEM {side} {quantity}"], color=REFERENCE, lw=3.5, alpha=0.55)
                ax.plot(
                    t["t [s]"], t[f"TMN-ETM {side} {quantity}"], color=COLOURS[side], lw=1.1, label=f"{side}, TMN-ETM"
                )
        axes[0, k].set_title(coupling)
        axes[2, k].set_xlabel("time [s]")
    for ax, quantity in zip(axes[:, 0], QUANTITIES, strict=True):
        ax.set_ylabel(quantity)
    axes[0, 0].plot([], [], color=REFERENCE, lw=3.5, alpha=0.55, label="EEM, 600 elements")
    made.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    made.suptitle(
        "Observation points 3 m above the lowest point: both meshes tell the same", x=0.01, ha="left", fontsize=11
    )
    return made


def numbers(tables: Tables) -> dict[str, Any]:
    """Largest values and differences."""
    rows = []
    for coupling in COUPLINGS:
        for quantity in QUANTITIES:
            name, unit = quantity.removesuffix("]").split(" [")
            value, difference = (largest(tables, coupling, quantity, which) for which in ("EEM", "difference"))
            rows.append((name, coupling, f"{number(value, '.4g')} {unit}", f"{number(difference, '.2g')} {unit}"))
    return {"largest": rows}


SECTION = Section(
    key="displacements",
    title="Displacement and twist at the observation points",
    pictures=[Picture("displacements", "Displacement and twist of both observation points with both meshes", draw)],
    claims=claims,
    numbers=numbers,
    data=[f"winding-{coupling}" for coupling in COUPLINGS],
)
