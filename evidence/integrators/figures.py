"""The page's figure: error of the end force against work, both over those of steps by places, medians over scenes."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from evidence.drawing import ACCENTS, COLOURS, REFERENCE, figure
from evidence.rendering import quantity
from evidence.tables import Tables

from .measure import EARLIER, EVEN, RICHARDSON, STEP, TODAY
from .reading import Verdict, kinds, verdicts

_CURVES = {
    EVEN: (COLOURS["left"], "o-"),
    RICHARDSON: (ACCENTS[2], "^-"),
    "Bathe, rho 0.8": (ACCENTS[0], "s-"),
    "BDF2": (ACCENTS[3], "x-"),
    "SDIRK 2": (ACCENTS[1], "v-"),
    "ESDIRK 3": (COLOURS["right"], "d--"),
    "ESDIRK 4": (COLOURS["right"], "d-"),
}
_WORK = (1, 2, 4, 8, 16)


def draw(tables: Tables) -> Figure:
    """Trips without a stop, and stops."""
    made, axes = figure(1, 2, 5.2, sharey=True)
    for ax, t, title in zip(axes[0], kinds(tables["methods"]), ("without a stop", "emergency stops"), strict=True):
        _curves(ax, verdicts(t, EARLIER))
        ax.set_xticks(_WORK, map(str, _WORK))
        ax.minorticks_off()
        ax.set(title=title.capitalize(), xlabel="work over that of steps by places")
    axes[0, 0].set_ylabel("error of the end force, RMS over the largest")
    made.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return made


def _curves(ax: Axes, found: list[Verdict]) -> None:
    for name, (colour, style) in _CURVES.items():
        _curve(ax, [v for v in found if v.name == name], style, label=name, color=colour)
    asked = [v for v in found if v.name.startswith("control, ")]
    for part, style in ((1, "*-"), (2, "*:")):
        mine = [v for v in asked if v.step == STEP / part]
        _curve(ax, mine, style, label=f"control, up to {quantity(STEP / part, 'ms', 'g')}", color="black", ms=9)
    _curve(
        ax, [v for v in asked if (v.name, v.step) == (TODAY, STEP)], "o", label="default", ms=15, mfc="none", color="k"
    )
    _curve(ax, [v for v in found if v.name == EARLIER], "P", label=EARLIER, color=REFERENCE, ms=9)


def _curve(ax: Axes, found: list[Verdict], style: str, **options: object) -> None:
    shown = {"ms": 4, **options}
    ax.loglog([v.cost for v in found], [v.errors["end force"] for v in found], style, **shown)
