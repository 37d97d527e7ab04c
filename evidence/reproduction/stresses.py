"""Bending and torsional stress norm over time and arc length."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from evidence.claims import below
from evidence.drawing import figure
from evidence.rendering import number
from evidence.tables import Tables

from .section import Claim, Picture, Section
from .timestep import EVEN, TORSION, row
from .windings import CELLS, MESHES, STRESSES

#: % of the rope's length that still are a few areas; the bound is ours
FEW = 10.0


def stress_map(tables: Tables, kind: str, mesh: str) -> NDArray[np.float64]:
    """(time, arc length), MPa."""
    t = tables[f"stress-{kind}-{mesh}"]
    return np.array([x for name, x in t.items() if name != "t [s]"]).T


def above_half(tables: Tables, kind: str) -> float:
    """Largest share over time of the rope that carries more than half of the present maximum, %."""
    return float(tables["stress-places"][f"EEM {kind} above half [%]"].max())


def distance(tables: Tables) -> float:
    """Largest distance along the rope from the loop's lowest point to the largest bending stress, m."""
    t = tables["stress-places"]
    return float(np.max(np.abs(t["EEM bending largest at s [m]"] - t["EEM loop s [m]"])))


def mesh_difference(tables: Tables, kind: str) -> float:
    """Largest difference of the meshes' maxima over time, %."""
    t = tables["stress-places"]
    tmn, eem = (t[f"{mesh} {kind} largest [MPa]"] for mesh in MESHES)
    return 100 * float(np.max(np.abs(tmn / eem - 1)))


def evenness(tables: Tables) -> float:
    """Smallest over largest torsional stress on the rope at one instant, at the worst instant."""
    values = stress_map(tables, "torsion", "EEM")
    return float(np.min(values.min(axis=1) / values.max(axis=1)))


def _because(tables: Tables) -> str:
    t = tables["time-step"]
    worst, most = (t[name][row(t, "what", "TMN-ETM, 2.5 ms")] for name in TORSION)
    return (
        "in the running loop the stress has an error that falls with the square of the time step; at 2.5 ms 99 % of "
        f"the samples differ by less than {most:.1f} %, the worst by {worst:.1f} %"
    )


def claims(tables: Tables) -> list[Claim]:
    """What the source says of the stresses."""
    words = {"bending": "bending", "torsion": "torsional"}
    share = "largest share of the rope above half of the present maximum"
    even = (
        "nothing on a leg takes up torque, so the torque is nearly the same all along the rope: on the EEM mesh the "
        f"smallest torsional stress never falls below {evenness(tables):.2f} of the largest, and what is left of the "
        "unevenness is mostly the time step's"
    )
    return [
        Claim("only a few areas carry large bending stress", below(share, above_half(tables, "bending"), FEW, "%")),
        Claim(
            "only a few areas carry large torsional stress", below(share, above_half(tables, "torsion"), FEW, "%"), even
        ),
        Claim(
            "the areas follow the conveyances (bending)",
            below("largest distance along the rope from the loop's lowest point", distance(tables), 1.0, "m"),
        ),
        *(
            Claim(
                f"TMN-ETM agrees with EEM in the {words[kind]} stress norm",
                below("largest difference of the maxima", mesh_difference(tables, kind), 2.0, "%"),
                _because(tables),
            )
            for kind in STRESSES
        ),
    ]


def draw(tables: Tables) -> Figure:
    """Two meshes by two stresses."""
    made, axes = figure(2, 2, 6.8, sharex=True, sharey=True)
    places = tables["stress-places"]
    for pair, kind in zip(axes, STRESSES, strict=True):
        maps = [stress_map(tables, kind, mesh) for mesh in MESHES]
        top = max(m.max() for m in maps)
        for ax, mesh, values in zip(pair, MESHES, maps, strict=True):
            t = tables[f"stress-{kind}-{mesh}"]["t [s]"]
            picture = ax.pcolormesh(t, CELLS, values.T, vmin=0.0, vmax=top, cmap="magma_r", rasterized=True)
            line = {"color": "#1f5fa8", "lw": 0.9, "ls": (0, (6, 4))}
            ax.plot(places["t [s]"], places[f"{mesh} loop s [m]"], label="lowest point of the loop", **line)
            ax.set_title(f"{kind}, {mesh}")
            ax.grid(False)
        made.colorbar(picture, ax=pair, label=f"{kind} stress norm [MPa]")
        pair[0].set_ylabel("arc length from the left end [m]")
    axes[0, 0].legend(loc="upper left")
    for ax in axes[1]:
        ax.set_xlabel("time [s]")
    made.suptitle(
        "Bending sits in the loop and travels with it; torsion is shared by the whole rope",
        x=0.01,
        ha="left",
        fontsize=11,
    )
    return made


def numbers(tables: Tables) -> dict[str, Any]:
    """Maxima, the share of the rope above half of them, and how even the torsional stress is at either step."""
    t, even = tables["stress-places"], tables["evenness"]
    long, short = (even[EVEN][row(even, "run", f"TMN-ETM, {step}")] for step in ("10 ms", "2.5 ms"))
    rows = []
    for kind, mesh in product(STRESSES, MESHES):
        share = t[f"{mesh} {kind} above half [%]"]
        largest = f"{number(t[f'{mesh} {kind} largest [MPa]'].max())} MPa"
        rows.append((kind, mesh, largest, f"{np.median(share):.1f} %, {share.max():.1f} %"))
    return {"shares": rows, "even_long": long, "even_short": short, "twist": np.median(t["EEM twist above half [%]"])}


SECTION = Section(
    key="stresses",
    title="Stress over time and arc length",
    pictures=[Picture("stresses", "Bending and torsional stress norm over time and arc length for both meshes", draw)],
    claims=claims,
    numbers=numbers,
    data=["stress-places", "time-step", "evenness", *(f"stress-{kind}-{mesh}" for kind in STRESSES for mesh in MESHES)],
)
