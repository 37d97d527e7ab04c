"""The table of levels, on the page and in README."""

import math

from evidence.accuracy.reading import FORCE, LOOP, TWIST
from evidence.rendering import markdown, number, quantity
from evidence.tables import Tables, rows

HEAD = (
    "level",
    "for",
    "elements",
    "largest step",
    "RMS end-force error",
    "loop's lowest point",
    "twist angle",
)
MEANING = {
    "draft": "end forces in sweeps over many parameters; may leave torsion and yaw out",
    "standard": "studies and co-simulation; the default",
    "standard, 10 ms": "the same in a host that communicates every 10 ms",
    "reference": "to check the others with",
}


def levels(tables: Tables) -> str:
    """Errors of the coupled winding, real-time factors of both."""
    t = tables["points"]
    lines = []
    both = {c: rows(t, family="levels", coupling=c) for c in ("coupled", "uncoupled")}
    for i, name in enumerate(both["coupled"]["name"].tolist()):
        c = {column: values[i] for column, values in both["coupled"].items()}
        planar = rows(both["uncoupled"], name=name)["processor time [s/s]"]
        lines.append(
            (
                name,
                MEANING[name],
                number(c["elements"], "g"),
                quantity(min(c["largest step [s]"], c["communication step [s]"]), "ms", "g"),
                quantity(c[FORCE], "%", ".2g"),
                quantity(c[LOOP], "mm", ".2g"),
                quantity(c[TWIST], "mrad", ".2g") if math.isfinite(c[TWIST]) else "none computed",
                *(number(1 / cost) for cost in (c["processor time [s/s]"], *planar)),
            )
        )
    return markdown(lines, *HEAD, "times real time, coupled", "uncoupled")
