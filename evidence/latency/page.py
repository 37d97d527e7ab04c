"""Times of single communication steps, from docs/data/latency."""

from typing import Any

import numpy as np

from evidence.latency.measure import BOUNDS, ROUNDS, SETTLE, STOP
from evidence.rendering import number, quantity
from evidence.tables import Tables, records, rows


def latencies(tables: Tables) -> dict[str, Any]:
    """Return the section's tables."""
    t = rows(tables["latency/steps"], place="FMU", level="standard")
    shown = ("50 % [s]", "99.9 % [s]", "largest [s]", "own largest [s]")
    lines = [
        (
            f"{r['scene']}, {r['trip']}",
            quantity(r["H [s]"], "ms", "g"),
            *(number(1e6 * r[name]) for name in shown),
        )
        for r in records(t)
    ]
    largest = {
        h: float(np.max(t["own largest [s]"][t["H [s]"] == h]))
        for h in sorted({*t["H [s]"]}, reverse=True)
    }
    bounds = {h: (BOUNDS[h], largest[h]) for h in largest}
    of = {"settle": SETTLE, "stop": STOP, "rounds": ROUNDS, "late": float(t["late"].max())}
    return {**of, "rows": lines, "bounds": bounds, "steps": int(t["steps"].sum())}
