"""What the 240 m rope does when its swivels are released: shapes, twist, swivel, swing."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure
from numpy.typing import NDArray

from evidence.claims import above, below
from evidence.drawing import COLOURS, REFERENCE, figure, mark_instants
from evidence.rendering import number
from evidence.tables import Tables

from .release import END, INSTANTS, RELEASE, SWIVEL
from .section import Claim, Picture, Section
from .windings import SIDES

Array = NDArray[np.float64]

#: s, stated in the source: instants of stick-slip switching
SOURCE_SWITCHING = 20.0, 20.8
#: s, the torsional wave's way along the 240 m rope: what we call near
NEAR = 240.0 / 1202.0
SOON = 30.0  # s, ten after the release
KINDS = "released", "locked"
WINDOW = 19.5, 24.0  # s, of the swivel's figure


def after(tables: Tables, name: str, until: float = END) -> Array:
    """A column of the table of the loop, from the release on."""
    t = tables["release-loop"]
    column: Array = t[name][(t["t [s]"] > RELEASE) & (t["t [s]"] <= until)]
    return column


def change(tables: Tables, quantity: str, until: float = END) -> float:
    """RMS over time and both observation points of released minus locked, after the release."""
    seen = {kind: [after(tables, f"{kind} {s} {quantity}", until) for s in SIDES] for kind in KINDS}
    differences = np.subtract(seen["released"], seen["locked"])
    return float(np.sqrt(np.mean(np.square(differences))))


def in_plane_change(tables: Tables, until: float = END) -> float:
    """``change`` in plane over the RMS of the motion with locked swivels about its mean, %."""
    locked = [after(tables, f"locked {s} in plane [m]", until) for s in SIDES]
    motion = [x - x.mean() for x in locked]
    return 100 * change(tables, "in plane [m]", until) / float(np.sqrt(np.mean(np.square(motion))))


def reach(tables: Tables, kind: str) -> tuple[float, float]:
    """How far the loop's lowest point goes to either side of the plane after the release, m."""
    z = after(tables, f"{kind} bottom z [m]")
    return float(z.max()), float(-z.min())


def instants(tables: Tables, side: str, what: str = "") -> Array:
    """When a swivel changes its phase, s."""
    t = tables["release-events"]
    chosen = (t["side"] == side) & (np.char.find(t["what"].astype(str), what) >= 0)
    times: Array = t["t [s]"][chosen]
    return times


def jump(tables: Tables, quantity: str) -> float:
    """Median change over the sample that holds a switching of the right swivel, over the mean of the others.

    Most of these may be 0.
    """
    t = tables["release-swivel"]
    time = t["t [s]"]
    size = np.abs(np.diff(t[quantity]))
    inside = (time[1:] > RELEASE - 0.005) & (time[1:] < WINDOW[1])
    switching = np.zeros(size.size, dtype=bool)
    for instant in instants(tables, "right"):
        # the release lies on a sample, whose values are still those before it
        switching[min(int(np.searchsorted(time, instant, side="right")) - 1, size.size - 1)] = True
    return float(np.median(size[inside & switching])) / float(np.mean(size[inside & ~switching]))


def claims(tables: Tables) -> list[Claim]:
    """What the source says of the release."""
    first = instants(tables, "right")[0]
    stick = instants(tables, "right", "sticks")[0]
    ratio = change(tables, "out of plane [m]") / change(tables, "in plane [m]")
    ranges = [np.ptp([after(tables, f"{kind} {s} theta [rad]") for s in SIDES], axis=1) for kind in KINDS]
    torsional = float((ranges[0] / ranges[1]).min())
    turn = float(np.max(np.abs(after(tables, "released yaw [rad]") - after(tables, "locked yaw [rad]"))))
    return [
        Claim(
            "in-plane motion changes little on release",
            below("RMS change over RMS motion in plane", in_plane_change(tables), 10.0, "%"),
            f"the change grows while the loop turns (by {np.degrees(turn):.0f} degrees against the locked one): it is "
            f"{in_plane_change(tables, SOON):.1f} % up to {SOON:g} s; the bound and the length of the run are ours, "
            f"and the RMS change out of plane is {ratio:.0f} times larger",
        ),
        Claim(
            "out-of-plane motion is violent after the release",
            above("RMS change out of plane over that in plane", ratio, 3.0),
        ),
        Claim(
            "torsional motion is violent after the release",
            above("smallest range of theta over that with locked swivels", torsional, 1.5),
        ),
        Claim(
            "the loop swings from side to side",
            above("lowest point, reach to the side it reaches less", min(reach(tables, "released")), 0.1, "m"),
        ),
        Claim(
            "stick-slip switching near 20 s",
            below("first switching of the right swivel, away by", abs(first - SOURCE_SWITCHING[0]), NEAR, "s"),
        ),
        Claim(
            "stick-slip switching near 20.8 s",
            below("first sticking of the right swivel, away by", abs(stick - SOURCE_SWITCHING[1]), NEAR, "s"),
        ),
        *(
            Claim(
                f"switching is visible as jumps in {words}",
                above("median change across a switching over the mean of others", jump(tables, quantity), 10.0),
                "between switchings torsional waves change the swivel's acceleration, too",
            )
            for words, quantity in (("friction torque", SWIVEL[3]), ("angular acceleration", SWIVEL[0]))
        ),
    ]


def _shades(count: int) -> list[tuple[float, ...]]:
    return [colormaps["viridis"](x) for x in np.linspace(0.0, 0.9, count)]


def draw_shapes(tables: Tables) -> Figure:
    """Three projections."""
    made, axes = figure(1, 3, 4.8)
    t = tables["release-shapes"]
    for instant, colour in zip(INSTANTS, _shades(len(INSTANTS)), strict=True):
        mine = t["t [s]"] == instant
        x, y, z = (t[f"{axis} [m]"][mine] for axis in "xyz")
        style = {"color": colour, "ls": "--" if instant < RELEASE else "-", "lw": 1.2, "label": f"{instant:g} s"}
        for ax, (a, b) in zip(axes[0], ((x, y), (z, y), (x, z)), strict=True):
            ax.plot(a, b, **style)
    names = (
        ("in plane x [m]", "height y [m]"),
        ("out of plane z [m]", "height y [m]"),
        ("in plane x [m]", "out of plane z [m]"),
    )
    for ax, labels, title in zip(axes[0], names, ("From the front", "From the side", "From above"), strict=True):
        ax.set(xlabel=labels[0], ylabel=labels[1], title=title)
    made.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=8)
    made.suptitle(
        "Shapes before (dashed) and after the release; the axes have different scales", x=0.01, ha="left", fontsize=11
    )
    return made


def draw_swivel(tables: Tables) -> Figure:
    """The right swivel over time."""
    made, axes = figure(4, 1, 7.6, sharex=True)
    t = tables["release-swivel"]
    seen = (t["t [s]"] >= WINDOW[0]) & (t["t [s]"] <= WINDOW[1])
    titles = ("Angular acceleration", "Rate", "Angle against the conveyance", "Torque on the rope")
    for ax, quantity, title in zip(axes[:, 0], SWIVEL, titles, strict=False):
        ax.plot(t["t [s]"][seen], t[quantity][seen], color=COLOURS["right"], label="right swivel")
        times = instants(tables, "right")
        mark_instants(ax, times[times < WINDOW[1]], "switches between stick and slip")
        ax.set(ylabel=quantity.split()[-1] if "]" not in quantity else "[" + quantity.split(" [")[1], title=title)
    limit = t[SWIVEL[4]][seen]
    for sign in (-1, 1):
        axes[3, 0].plot(
            t["t [s]"][seen], sign * limit, color=REFERENCE, lw=0.9, ls="--", label="static limit" if sign > 0 else None
        )
    axes[3, 0].set_ylim(-1.2, 1.6)
    axes[3, 0].annotate(
        f"{t[SWIVEL[3]][seen].max():.1f} N m while locked",
        (19.98, 1.45),
        (20.25, 1.25),
        arrowprops={"arrowstyle": "->", "lw": 0.8},
    )
    axes[3, 0].set_xlabel("time [s]")
    made.legend(*axes[3, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    made.suptitle(
        "Right swivel: slips at the release, turns to and fro, sticks, and slips again", x=0.01, ha="left", fontsize=11
    )
    return made


def draw_swing(tables: Tables) -> Figure:
    """Swing of the loop in and out of plane, released against locked."""
    made, axes = figure(3, 2, 7.2, sharex=True)
    t = tables["release-loop"]
    legs = [f"{side} {plane} [m]" for plane in ("in plane", "out of plane") for side in SIDES]
    panels = (*legs, "bottom z [m]", "yaw [rad]")
    words = [f"{side.capitalize()} leg, {plane}" for plane in ("in plane", "out of plane") for side in SIDES]
    titles = (*words, "Lowest point, out of plane", "Yaw of the loop")
    for ax, quantity, title in zip(axes.flat, panels, titles, strict=True):
        ax.plot(t["t [s]"], t[f"locked {quantity}"], color=REFERENCE, lw=1.6, label="swivels locked")
        ax.plot(t["t [s]"], t[f"released {quantity}"], color=COLOURS["left"], label="swivels released at 20 s")
        mark_instants(ax, [RELEASE])
        ax.set(ylabel=quantity[quantity.index("[") :], title=title)
    for ax in axes[2]:
        ax.set_xlabel("time [s]")
    made.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    made.suptitle(
        "Releasing the swivels changes the motion in plane little and the motion out of plane much",
        x=0.01,
        ha="left",
        fontsize=11,
    )
    return made


def numbers(tables: Tables) -> dict[str, Any]:
    """Torque before the release, reaches after it, and switchings."""
    t = tables["release-events"]
    legs = [after(tables, f"released {s} out of plane [m]") for s in SIDES]
    time, limit, torque = (tables["release-swivel"][name][0] for name in ("t [s]", SWIVEL[4], SWIVEL[3]))
    return {
        "end": END,
        "time": time,
        "limit": limit,
        "torque": torque,
        **{kind: reach(tables, kind) for kind in KINDS},
        "together": 100 * np.mean(legs[0] * legs[1] > 0),
        "events": [
            (number(at, ".4g"), side, what) for at, side, what in zip(t["t [s]"], t["side"], t["what"], strict=True)
        ],
    }


SECTION = Section(
    key="swing",
    title="Release of the swivels of the 240 m rope",
    pictures=[
        Picture("release-shapes", "Rope shapes in three projections before and after the release", draw_shapes),
        Picture("release-swivel", "Acceleration, rate, angle and torque of the right swivel over time", draw_swivel),
        Picture("release-swing", "Motion of the loop in and out of plane with released and locked swivels", draw_swing),
    ],
    claims=claims,
    numbers=numbers,
    data=["release-swivel", "release-loop", "release-events", "release-shapes"],
)
