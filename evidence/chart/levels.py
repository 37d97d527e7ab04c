"""README's table of the levels of accuracy."""

from __future__ import annotations

import math

from evidence.tables import Tables

from .reading import FORCE, LOOP, TWIST, rows

BEGIN, END = "<!-- levels -->", "<!-- /levels -->"
MEANING = {
    "draft": "end forces in sweeps over many parameters; may leave torsion and yaw out",
    "standard": "studies and co-simulation; the default",
    "standard, 10 ms": "the same in a host that communicates every 10 ms",
    "reference": "to check the others with",
}


def times(factor: float) -> str:
    """Three digits, never as a power of ten."""
    return f"{float(f'{factor:.3g}'):g}"


def levels(tables: Tables) -> str:
    """The table: errors of the coupled winding, real-time factors of both."""
    t = tables["points"]
    lines = [
        "| level | for | elements | largest step | RMS end-force error | loop's lowest point | twist angle "
        "| times real time, coupled | uncoupled |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    both = {c: rows(t, family="levels", coupling=c) for c in ("coupled", "uncoupled")}
    for i, name in enumerate(both["coupled"]["name"].tolist()):
        c = {column: values[i] for column, values in both["coupled"].items()}
        planar = rows(both["uncoupled"], name=name)["processor time [s/s]"]
        step = min(c["largest step [s]"], c["communication step [s]"])
        fast = [times(1 / cost) for cost in (c["processor time [s/s]"], *planar)]
        twist = f"{1e3 * c[TWIST]:.2g} mrad" if math.isfinite(c[TWIST]) else "none computed"
        lines.append(
            f"| {name} | {MEANING[name]} | {c['elements']:.0f} | {1e3 * step:g} ms | {100 * c[FORCE]:.2g} % "
            f"| {1e3 * c[LOOP]:.2g} mm | {twist} | {' | '.join(fast)} |"
        )
    return "\n".join(lines)


def block(tables: Tables) -> str:
    """What stands between the marks."""
    form = "compiled" if "compiled" in tables["points"]["kernels"] else "interpreted"
    return (
        f"{BEGIN}\n{levels(tables)}\n\nErrors and {form} real-time factors of the 90 m winding, in process, from "
        f"`make chart`; [docs/chart.md](docs/chart.md) shows what else was tried.\n{END}"
    )


def with_block(text: str, tables: Tables) -> str:
    """``text`` with a new table between its marks; unchanged without them."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    return before + block(tables) + after if begin and end else text
