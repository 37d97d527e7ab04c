"""What docs/integrators.md says, computed from the tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from evidence.rendering import number, quantity, render
from evidence.tables import Tables, rows

from . import figures
from .measure import CHECK_PARTS, EARLIER, ERRORS, EVEN, MESH, NUMBERS, REFERENCE_PART, SEED, STEP, TODAY
from .reading import Verdict, kinds, reference_error, verdicts

FIGURES = {"chart": figures.draw}
#: aims: error over that of steps by places at no more work; error in a stop; work of even steps over another's
ERROR_AIM, STOP_AIM, GAIN_AIM = 1 / 3, 5e-3, 2.0
#: smaller errors of the end force are of no use: the mesh brings as much
USEFUL = 1e-4
#: s, the shortest of the steps in the page's table
SHOWN = 0.01


def page(tables: Tables) -> str:
    """The whole page."""
    t, scenes = tables["methods"], tables["scenes"]
    everywhere, (trips, stops) = verdicts(t, EARLIER), (verdicts(part, EARLIER) for part in kinds(t))
    finest = rows(t, method=EVEN, **{"step [s]": STEP / CHECK_PARTS[1]})
    data = {
        "seed": SEED,
        "numbers": NUMBERS,
        "lengths": (scenes["length [m]"].min(), scenes["length [m]"].max()),
        "step": STEP,
        "reference_step": STEP / REFERENCE_PART,
        "reference": dict(zip(ERRORS, reference_error(t), strict=True)),
        "finest": {"step": STEP / CHECK_PARTS[1], "error": finest["end force"].max()},
        "mesh": MESH,
        "lines": [_line(*x) for x in zip(trips, stops, everywhere, strict=True) if x[0].step >= SHOWN],
        "shown": SHOWN,
        "aims": {"error": ERROR_AIM, "stop": STOP_AIM, "gain": GAIN_AIM, "useful": USEFUL},
        "cheap": min((v for v in trips if v.cost <= 1 and not v.failures), key=lambda v: v.ratio),
        "stop": min((v for v in stops if v.worst < STOP_AIM), key=lambda v: v.cost),
        "fast": [
            max((v for v in found if v.errors["end force"] >= USEFUL), key=_gain) for found in (everywhere, stops)
        ],
        "default": [_by_name(found)[TODAY, 1e3 * STEP] for found in (trips, stops)],
        "limited": [_by_name(found)[TODAY, 1e3 * SHOWN] for found in (trips, stops)],
        "trips": _by_name(trips),
        "stops": _by_name(stops),
        "failing": [f"{v.name} with {quantity(v.step, 'ms', 'g')}" for v in everywhere if v.failures],
        "earlier": EARLIER,
        "even": EVEN,
    }
    return render("integrators/integrators.md.j2", data)


def _by_name(found: Sequence[Verdict]) -> dict[tuple[str, float], Verdict]:
    """By name and step in ms."""
    return {(v.name, round(1e3 * v.step, 3)): v for v in found}


def _gain(v: Verdict) -> float:
    return v.gain if np.isfinite(v.gain) else -np.inf


def _line(trip: Verdict, stop: Verdict, both: Verdict) -> tuple[str, ...]:
    """A line of the table of methods."""
    gain = number(both.gain, ".2g") if np.isfinite(both.gain) else ""
    forces = (quantity(x, "%", ".2g") for x in (trip.errors["end force"], stop.errors["end force"], stop.worst))
    horizontal, loop, moment = (both.errors[name] for name in ERRORS[1:])
    others = quantity(horizontal, "%", ".2g"), quantity(moment, "%", ".2g"), quantity(loop, "mm", ".2g")
    costs = (number(x, ".2g") for x in (trip.cost, stop.cost))
    return both.name, quantity(both.step, "ms", "g"), *forces, *others, *costs, gain
