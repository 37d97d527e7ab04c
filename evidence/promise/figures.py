"""Errors and estimates of the scenes against what was asked."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from evidence.drawing import ACCENTS, COLOURS, REFERENCE, figure
from evidence.promise.judging import ESTIMATES, NEAR, completed
from evidence.promise.wind import REQUESTS
from evidence.tables import Tables

_COLOURS = dict(zip(REQUESTS, (COLOURS["left"], ACCENTS[2], COLOURS["right"]), strict=True))
_LABELS = {"end force": "end force, RMS / largest", "loop": "place of the loop [m]"}


def distributions(tables: Tables) -> Figure:
    """Estimates against errors, of end force and loop, for each request."""
    made, axes = figure(1, 2, 3.6)
    for ax, (estimate, (found, told)) in zip(axes.flat, ESTIMATES.items(), strict=True):
        for asked, colour in _COLOURS.items():
            done = completed(tables["scenes"], asked)
            ax.loglog(done[found], done[told], ".", ms=4, color=colour, label=asked)
            limit = getattr(REQUESTS[asked], "end_force" if estimate == "end force" else "loop")
            ax.axvline(limit, color=colour, lw=0.5)
        line = np.array([tables["scenes"][found].min(), tables["scenes"][found].max()])
        for factor in (1.0 / NEAR, 1.0, NEAR):
            ax.loglog(line, factor * line, color=REFERENCE, lw=1.0 if factor == 1 else 0.5)
        ax.set(xlabel="error", ylabel="estimate", title=_LABELS[estimate])
        ax.legend()
    return made


FIGURES: dict[str, Callable[[Tables], Figure]] = {"distributions": distributions}
