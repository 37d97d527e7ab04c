"""Both codes on their meshes: a history where it is largest, and its largest differences (two minutes)."""

from collections.abc import Iterator

import numpy as np
from tqdm import tqdm

from evidence.discrete_rod.cases import Case, Comparison, cases
from evidence.tables import Measures, Tables, records, table

COLUMNS = (
    *("case", "quantity", "our mesh, coarse", "our mesh, fine"),
    *("rod's mesh, coarse", "rod's mesh, middle", "rod's mesh, fine"),
    *("ours, coarse", "ours, fine", "rod, coarse", "rod, middle", "rod, fine", "rod, limit"),
    *("difference, coarse", "difference, fine", "accepted", "rod's order"),
)


def _row(case: Case, name: str, c: Comparison) -> tuple[object, ...]:
    at = np.unravel_index(int(np.argmax(np.abs(c.limit))), c.limit.shape)
    values = (float(x[at]) for x in (*c.ours, *c.rod, c.limit))
    return (
        case.name,
        name,
        *case.ours_on,
        *case.rod_on,
        *values,
        *c.differences,
        c.acceptance,
        c.order,
    )


def tables() -> Tables:
    """Compare every quantity of every case."""
    found = [
        _row(case, name, c)
        for case in tqdm(cases(), leave=False)
        for name, c in case.compare().items()
    ]
    return {"comparisons": table(COLUMNS, found)}


def missed(recorded: Tables) -> Iterator[str]:
    """Yield the quantities that differ by more than the convergence of both codes accepts."""
    for r in records(recorded["comparisons"]):
        if not r["difference, fine"] <= r["accepted"]:
            yield f"{r['case']}: {r['quantity']}"


MEASURES: Measures = {"comparisons": tables}
