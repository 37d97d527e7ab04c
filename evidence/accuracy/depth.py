"""Time that TMN-ETM saves over equal elements at the same error, over the depth of the shaft.

Every rope winds a long way, because the lag of the legs' waves adds up, with the same time step for all meshes: only
the mesh differs.
"""

import math
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from tqdm import tqdm

from benchmarks.kinematic import Winding, scene_of, wind
from evidence.accuracy.front import cost_at
from evidence.errors import force_error, place_error
from evidence.reproduction.costs import SOURCE_SAVED
from evidence.tables import Table, Tables, table
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model.solver_parameters import Mesh

TRIPS = (
    ("rope-120", Trip(travel=90.0, speed=8.0)),
    ("rope-240", Trip(travel=200.0, speed=10.0)),
    ("monopol-1000", Trip(travel=700.0, speed=8.0)),
    ("monopol-1000", Trip(travel=900.0, speed=16.0)),
)
SETTLE = 3.0  # s
STEP = 0.01  # s
SAMPLE = 4  # steps
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


def tables() -> Tables:
    """Measure errors and times of all meshes; times are medians of rounds, of equal elements of one run."""
    rows: list[tuple[object, ...]] = []
    for (rope, trip), coupling in product(TRIPS, COUPLINGS):
        scene = scene_of(rope, coupling)
        length = scene.rope.length
        equal = [Mesh("eem", elements=math.ceil(length / l)) for l in (FINEST, *EEM_LENGTHS)]
        fitted = [Mesh("auto", loop_error=e) for e in LOOP_ERRORS]
        exact: Winding | None = None
        for mesh in tqdm(
            [*equal, *fitted], desc=f"depth, {rope}, {coupling}", unit="run", leave=False
        ):
            case = scene.with_(mesh=mesh), s_curve(trip), trip.travel, SETTLE, SAMPLE
            runs = [wind(*case, interval=STEP) for _ in range(ROUNDS if mesh.kind == "auto" else 1)]
            run = runs[0].completed(str(mesh))
            exact = exact or run
            kind, wanted = ("TMN-ETM", mesh.loop_error) if mesh.kind == "auto" else ("EEM", 0.0)
            what = rope, length, trip.travel, trip.speed, coupling, kind, wanted, run.rope.elements
            cost = float(np.median([x.cpu / x.simulated for x in runs]))
            rows.append(
                (
                    *what,
                    cost,
                    force_error(run.force, exact.force),
                    place_error(run.bottom, exact.bottom),
                )
            )
    return {"depth": table((*COLUMNS, *ERRORS), rows)}


class Saving(NamedTuple):
    """TMN-ETM against equal elements with the same error of the loop's place."""

    length: float  # m
    speed: float  # m/s
    coupling: str
    wanted: float  # m, loop_error that the mesh is made for
    saved: float  # % of the equal elements' time


def savings(t: Table) -> list[Saving]:
    """Return every mesh of TMN-ETM with the equal elements of its error; NaN where every one tried is better."""
    found = []
    for i in np.flatnonzero(t["mesh"] == "TMN-ETM"):
        same = (t["mesh"] == "EEM") & (t["loop error [m]"] > 0)  # not the reference itself
        for name in ("rope", "coupling", "travel [m]", "speed [m/s]"):
            same &= t[name] == t[name][i]
        error = t["loop error [m]"][same]
        bound = float(t["loop error [m]"][i])
        time = (
            math.nan
            if bound > error.max()
            else cost_at(t["processor time [s/s]"][same], error, bound)
        )
        saved = 100 * (1 - float(t["processor time [s/s]"][i]) / time)
        length, speed, wanted = (
            float(t[name][i]) for name in ("length [m]", "speed [m/s]", "loop_error [m]")
        )
        found.append(Saving(length, speed, str(t["coupling"][i]), wanted, saved))
    return found


def reading(t: Table) -> list[dict[str, Any]]:
    """Return, of either coupling, the most that is saved at each length, and the part that the source states."""
    told = []
    for coupling in COUPLINGS:
        mine = [s for s in savings(t) if s.coupling == coupling and np.isfinite(s.saved)]
        most = [
            (max(x.saved for x in mine if x.length == length), length)
            for length in dict.fromkeys(s.length for s in mine)
        ]
        told.append({"coupling": coupling, "asked": SOURCE_SAVED[coupling], "most": most})
    return told
