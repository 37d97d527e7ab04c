"""docs/assumed_data.md from docs/data/assumed_data."""

import numpy as np

from evidence.assumed_data.measure import SCENES
from evidence.rendering import number, render
from evidence.tables import Table, Tables, records, rows
from hoist_demo.parameters import ASSUMED_DATA
from hoist_demo.uncertainty.spread import QUANTILES

#: share of a spread below which a cause is not shown
SHOWN = 0.03


def page(tables: Tables) -> str:
    """Return the whole page."""
    results = tables["results"]
    t = tables["coverage"]
    wide = rows(results, measure=("loop_yaw", "left_swivel_torque"))
    factors = wide["high"] / wide["low"]
    low, _, high = QUANTILES
    judged, unseen, more = (
        rows(t, sets=name) for name in ("judged", "unseen", "without a hanging rope")
    )
    sums = {
        name: [int(x[column].sum()) for column in ("told", "inside", "exact")]
        for name, x in (("judged", judged), ("unseen", unseen))
    }
    data = {
        "assumed": ASSUMED_DATA,
        "scenes": {
            s: _spread(rows(results, scene=s), rows(tables["causes"], scene=s)) for s in SCENES
        },
        "low": 100 * low,
        "high": 100 * high,
        "least": factors.min(),
        "most": factors.max(),
        "covered": [
            _coverage(*x) for x in zip(records(judged), records(unseen), records(more), strict=True)
        ],
        "together": sums,
        "sets": int(judged["told"].max()),
        "more": int(more["told"].max()),
    }
    return render("assumed_data/assumed_data.md.j2", data)


def _coverage(
    judged: dict[str, float], unseen: dict[str, float], more: dict[str, float]
) -> tuple[str, ...]:
    inside, new, without = (f"{x['inside']:.0f} of {x['told']:.0f}" for x in (judged, unseen, more))
    exact, exact_new = (f"{x['exact']:.0f}" for x in (judged, unseen))
    name = str(judged["property"]).replace("_", " ")
    return name, inside, exact, new, exact_new, number(judged["reach"]), without


def _spread(results: Table, causes: Table) -> list[tuple[str, ...]]:
    """Return per measure its range, and the data that cause it, the largest first."""
    found = []
    for r in records(results):
        own = rows(causes, measure=r["measure"])
        order = [i for i in np.argsort(-own["share"]) if own["share"][i] > SHOWN]
        named = [
            f"{str(own['datum'][i]).replace('_', ' ')} {100 * own['share'][i]:.0f} %" for i in order
        ]
        unit = "" if r["unit"] == "1" else r["unit"].replace(".", " ")
        values = (number(r[column]) for column in ("low", "middle", "high"))
        found.append((f"`{r['measure']}`", unit, *values, ", ".join(named)))
    return found
