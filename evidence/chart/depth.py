"""What TMN-ETM saves over equal elements at the same error, over the depth of the shaft.

Every rope winds a long way, because what the legs' waves lag behind adds up, with the same time step for all meshes:
what differs is the mesh.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from tqdm import tqdm

from benchmarks.kinematic import scene_of, wind
from evidence.drawing import ACCENTS, COLOURS, figure
from evidence.rendering import number, quantity
from evidence.reproduction.costs import SOURCE_SAVED
from evidence.tables import Table, Tables, table
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model.parameters import Mesh

from .front import cost_at

TRIPS = (
    ("rope-120", Trip(travel=90.0, speed=8.0)),
    ("rope-240", Trip(travel=200.0, speed=10.0)),
    ("monopol-1000", Trip(travel=700.0, speed=8.0)),
    ("monopol-1000", Trip(travel=900.0, speed=16.0)),
)
SETTLE, STEP, SAMPLE = 3.0, 0.01, 4  # s, s, steps
ROUNDS = 3
COUPLINGS = ("uncoupled", "coupled")
LOOP_ERRORS = (5e-3, 2e-3, 1e-3)  # m, of TMN-ETM's meshes
EEM_LENGTHS = (0.6, 0.45, 0.35, 0.25)  # m
FINEST = 0.15  # m, of the reference's equal elements
COLUMNS = (
    *("rope", "length [m]", "travel [m]", "speed [m/s]", "coupling"),
    *("mesh", "loop_error [m]", "elements", "processor time [s/s]"),
)
ERRORS = ("force error", "loop error [m]")


@dataclass(frozen=True)
class Depth:
    """What is wound."""

    trips: Sequence[tuple[str, Trip]] = TRIPS
    loop_errors: Sequence[float] = LOOP_ERRORS
    eem_lengths: Sequence[float] = EEM_LENGTHS
    finest: float = FINEST
    rounds: int = ROUNDS


def quick() -> Depth:
    """A check that all is in place."""
    return Depth((("rope-120", Trip(travel=0.5, start_delay=0.0)),), (5e-3,), (0.9, 0.7), 0.5, 1)


def measure(what: Depth) -> Table:
    """Errors and times of all meshes; times are medians of rounds, of equal elements of one run."""
    rows: list[tuple[object, ...]] = []
    for (rope, trip), coupling in product(what.trips, COUPLINGS):
        scene = scene_of(rope, coupling)
        length = scene.rope.length
        equal = [Mesh("eem", elements=math.ceil(length / l)) for l in (what.finest, *what.eem_lengths)]
        fitted = [Mesh("auto", loop_error=e) for e in what.loop_errors]
        exact: tuple[np.ndarray, np.ndarray] | None = None
        for mesh in tqdm(
            [*equal, *fitted], desc=f"depth, {rope}, {trip.speed:g} m/s, {coupling}", unit="run", leave=False
        ):
            costs = []
            for _ in range(what.rounds if mesh.kind == "auto" else 1):
                run = wind(scene.with_(mesh=mesh), s_curve(trip), trip.travel, SETTLE, SAMPLE, interval=STEP)
                if not run.status.valid:
                    raise RuntimeError(f"{rope}, {coupling}, {mesh}: {run.status.message}")
                costs.append(run.cpu / run.simulated)
            force, bottom = np.array(run.force), np.array(run.bottom)
            if exact is None:
                exact = force, bottom
            errors = (
                float(np.sqrt(np.mean((force - exact[0]) ** 2)) / np.max(np.abs(exact[0]))),
                float(np.max(np.linalg.norm(bottom - exact[1], axis=1))),
            )
            elements = run.rope.state.partition.lengths.size
            kind, wanted = ("TMN-ETM", mesh.loop_error) if mesh.kind == "auto" else ("EEM", 0.0)
            what_ran = rope, length, trip.travel, trip.speed, coupling, kind, wanted, elements
            rows.append((*what_ran, float(np.median(costs)), *errors))
    return table((*COLUMNS, *ERRORS), rows)


@dataclass(frozen=True)
class Saving:
    """TMN-ETM against equal elements with the same error of the loop's place."""

    rope: str
    length: float  # m
    travel: float  # m
    speed: float  # m/s
    coupling: str
    elements: int
    wanted: float  # m, loop_error that the mesh is made for
    loop_error: float  # m
    force_error: float
    equal_elements: float  # with the same loop error
    saved: float  # % of the equal elements' time


def savings(t: Table) -> list[Saving]:
    """Every mesh of TMN-ETM that equal elements are known to reach; time interpolated in the logarithms."""
    found = []
    for i in np.flatnonzero(t["mesh"] == "TMN-ETM"):
        same = (t["rope"] == t["rope"][i]) & (t["coupling"] == t["coupling"][i]) & (t["mesh"] == "EEM")
        same &= (t["travel [m]"] == t["travel [m]"][i]) & (t["speed [m/s]"] == t["speed [m/s]"][i])
        same &= t["loop error [m]"] > 0  # not the reference itself
        error, bound = t["loop error [m]"][same], float(t["loop error [m]"][i])
        # where every equal mesh tried is better it is not priced
        time, elements = (
            float("nan") if bound > error.max() else cost_at(t[name][same], error, bound)
            for name in ("processor time [s/s]", "elements")
        )
        part = 100 * (1 - float(t["processor time [s/s]"][i]) / time)
        found.append(
            Saving(
                str(t["rope"][i]),
                float(t["length [m]"][i]),
                float(t["travel [m]"][i]),
                float(t["speed [m/s]"][i]),
                str(t["coupling"][i]),
                int(t["elements"][i]),
                float(t["loop_error [m]"][i]),
                bound,
                float(t["force error"][i]),
                elements,
                part,
            )
        )
    return found


def draw(tables: Tables) -> Figure:
    """% of the time saved over the length of the rope."""
    made, axes = figure(1, 2, 3.6, sharey=True)
    t = tables["depth"]
    all_saved = savings(t)
    wanted = sorted(set(t["loop_error [m]"][t["mesh"] == "TMN-ETM"].tolist()), reverse=True)
    colours = (COLOURS["left"], COLOURS["right"], ACCENTS[0])
    for ax, coupling in zip(axes[0], COUPLINGS, strict=True):
        for k, colour in zip(range(len(wanted)), colours, strict=False):
            mine = [s for s in all_saved if (s.coupling, s.wanted) == (coupling, wanted[k])]
            # a second trip of the same rope stands beside the line
            first = {s.length: s for s in reversed(mine)}
            line = [first[length] for length in sorted(first)]
            other = [s for s in mine if s is not first[s.length]]
            label = f"mesh for {1e3 * wanted[k]:g} mm"
            ax.plot([s.length for s in line], [s.saved for s in line], "o-", color=colour, ms=5, label=label)
            ax.plot([s.length for s in other], [s.saved for s in other], "o", color=colour, mfc="none", ms=5)
        ax.axhline(SOURCE_SAVED[coupling], color="black", lw=0.8, ls=":")
        ax.set_xscale("log")
        ticks = sorted({s.length for s in all_saved})
        ax.set_xticks(ticks, [f"{x:g}" for x in ticks], minor=False)
        ax.minorticks_off()
        ax.set_xlabel("length of the rope [m]")
        ax.set_title(f"{coupling}; dotted: stated by the source", loc="left", fontsize=10)
    axes[0, 0].set_ylabel("time saved at equal loop error [%]")
    axes[0, 0].legend(loc="lower right")
    return made


def reading(t: Table) -> dict[str, Any]:
    """Rows of the page's table, and where the savings that the source states are reached."""
    found = savings(t)
    return {"rows": [_row(s) for s in found], "sources": [_verdict_of(found, c) for c in COUPLINGS]}


def _row(s: Saving) -> tuple[str, ...]:
    known = bool(np.isfinite(s.saved))
    return (
        f"{s.rope}, {quantity(s.length, 'm', 'g')}",
        trip_of(s),
        s.coupling,
        str(s.elements),
        quantity(s.loop_error, "mm", ".2g"),
        quantity(s.force_error, "%", ".2g"),
        number(s.equal_elements, ".0f") if known else "more than tried",
        f"{s.saved:.1f} %" if known else "",
        f"{100 * (1 - s.elements / s.equal_elements):.1f} %" if known else "",
    )


def trip_of(s: Saving) -> str:
    """The way and its speed."""
    return f"{quantity(s.travel, 'm', 'g')} at {quantity(s.speed, 'm/s', 'g')}"


def _verdict_of(found: Sequence[Saving], coupling: str) -> dict[str, Any]:
    """Where at least the source's part of the time is saved, and the most that is, by the rope's length."""
    asked = SOURCE_SAVED[coupling]
    mine = [s for s in found if s.coupling == coupling and np.isfinite(s.saved)]
    most = {s.length: max(x.saved for x in mine if x.length == s.length) for s in mine}
    where = dict.fromkeys(
        f"{s.rope}, {trip_of(s)}, at {quantity(s.loop_error, 'mm', '.2g')}" for s in mine if s.saved >= asked
    )
    return {
        "coupling": coupling,
        "asked": asked,
        "where": list(where),
        "most": [(part, length) for length, part in most.items()],
    }
