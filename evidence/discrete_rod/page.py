"""docs/reference_solver.md from its table: both codes on their meshes, the rod's limit, and what they differ by."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from evidence.rendering import number, render
from evidence.tables import Table, Tables, table

from .cases import Case, Comparison

OURS = ("our mesh, coarse", "our mesh, fine")
ROD = ("rod's mesh, coarse", "rod's mesh, middle", "rod's mesh, fine")
VALUES = ("ours, coarse", "ours, fine", "rod, coarse", "rod, middle", "rod, fine", "rod, limit")
DIFFERENCES = ("difference, coarse", "difference, fine", "accepted")
ORDER = "rod's order"


def comparisons(cases: Iterable[Case]) -> Table:
    """Every quantity of every case: a history where it is largest, and its largest differences."""
    rows = [
        (case.name, name, *case.ours_on, *case.rod_on, *_numbers(c))
        for case in cases
        for name, c in case.compare().items()
    ]
    return table(("case", "quantity", *OURS, *ROD, *VALUES, *DIFFERENCES, ORDER), rows)


def _numbers(c: Comparison) -> tuple[float, ...]:
    at = np.unravel_index(int(np.argmax(np.abs(c.limit))), c.limit.shape)
    return *(float(x[at]) for x in (*c.ours, *c.rod, c.limit)), *c.differences, c.acceptance, c.order


def page(tables: Tables) -> str:
    """The whole page."""
    t = tables["comparisons"]
    return render(
        "discrete_rod/reference_solver.md.j2", {"cases": [_case(t, name) for name in dict.fromkeys(t["case"].tolist())]}
    )


def _case(t: Table, name: str) -> dict[str, Any]:
    """A case's table; its heads name the meshes."""
    mine = np.flatnonzero(t["case"] == name)
    ours, rod = ([number(t[column][mine[0]], "g") for column in columns] for columns in (OURS, ROD))
    head = ["", *(f"ours, {n}" for n in ours), *(f"rod, {n}" for n in rod), "rod, limit"]
    head += [*(f"difference, {n}" for n in ours), "accepted", "rod's order", "agrees"]
    return {"name": name, "head": head, "rows": [_row(t, int(i)) for i in mine]}


def _row(t: Table, i: int) -> tuple[str, ...]:
    *_, finest, accepted = (t[column][i] for column in DIFFERENCES)
    return (
        str(t["quantity"][i]),
        *(number(t[column][i], ".6g") for column in VALUES),
        *(number(t[column][i], ".1e") for column in DIFFERENCES),
        number(t[ORDER][i], ".2f"),
        "yes" if finest <= accepted else "NO",
    )
