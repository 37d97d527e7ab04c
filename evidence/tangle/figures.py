"""How far the loop turns, and how hard the rope strikes the head ropes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from evidence.drawing import ACCENTS, COLOURS, REFERENCE, figure
from evidence.tables import Tables, rows

from .scenes import MESHES, SEIZED, TRIP_TIME, VARIANTS

_COLOURS = (COLOURS["left"], COLOURS["right"], *ACCENTS)


def course(tables: Tables) -> Figure:
    """Turns of the variants, and the force on the head ropes on meshes of all kinds."""
    made, axes = figure(1, 2, 4.2)
    t = tables["course"]
    for variant, colour in zip(VARIANTS, _COLOURS, strict=False):
        mine = rows(t, variant=variant.name)
        axes[0, 0].plot(mine["time [s]"], mine["turns"], color=colour, label=variant.name)
    for mesh, colour in zip(MESHES, _COLOURS, strict=False):
        mine = rows(t, variant=mesh.name)
        # the impulse so far: blows that follow each other are not told apart
        impulse = np.cumsum(mine["head_ropes, mean [N]"]) * (mine["time [s]"][1] - mine["time [s]"][0])
        axes[0, 1].plot(
            mine["time [s]"], 1e-3 * impulse, color=colour, label="default mesh" if mesh is SEIZED else mesh.name
        )
    axes[0, 0].axvline(TRIP_TIME, color=REFERENCE, lw=0.8)
    axes[0, 0].axhline(0.5, color=REFERENCE, lw=0.8)
    axes[0, 0].set(xlabel="time, s", ylabel="turns", title="One side about the other; the trip ends at the line")
    axes[0, 1].set(
        xlabel="time, s", ylabel="impulse, kN s", title="Of the rope on the head ropes, seized", xlim=(85, 110)
    )
    for ax in axes[0]:
        ax.legend(fontsize="small")
    return made


FIGURES: dict[str, Callable[[Tables], Figure]] = {"course": course}
