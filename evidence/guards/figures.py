"""False trips against missed ones, for each guard over all its thresholds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from evidence.drawing import ACCENTS, COLOURS, REFERENCE, figure
from evidence.tables import Tables

from .judging import EARLY, PEAK, guard
from .scenes import JUDGE, SET
from .wind import LEAD, QUANTITIES

_COLOURS = dict(zip(QUANTITIES, (COLOURS["left"], COLOURS["right"], *ACCENTS), strict=False))


def trips(tables: Tables) -> Figure:
    """Two panels: trips before the rope touches, and so long before that a hoist can stop."""
    made, axes = figure(1, 2, 4.2)
    panels = (PEAK, "Trips by the time it fouls"), (EARLY, f"Trips {LEAD:g} s before it fouls")
    for ax, (when, title) in zip(axes[0], panels, strict=True):
        for quantity in QUANTITIES:
            found = guard(tables["windings"], quantity, (SET, JUDGE), when)
            over = np.concatenate(([-np.inf], np.unique(np.concatenate((found.healthy, found.fouled)))))
            missed, false = ([100 * share(x) for x in over] for share in (found.missed, found.false))
            ax.plot(missed, false, color=_COLOURS[quantity], label=quantity)
        ax.plot([0, 100], [100, 0], color=REFERENCE, lw=0.8)
        ax.set(xlabel="missed, % of the foulings", ylabel="false, % of the healthy windings", title=title)
    axes[0, 0].legend()
    return made


FIGURES: dict[str, Callable[[Tables], Figure]] = {"trips": trips}
