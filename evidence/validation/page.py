"""docs/validation.md: one table of all rows, and the stories of those that disagree."""

import math
from collections.abc import Iterator
from typing import Any, Literal

import numpy as np

from evidence.rendering import render, with_unit
from evidence.tables import Table, Tables, rows
from evidence.validation.chains import FOLD
from evidence.validation.coupled import RUNS
from evidence.validation.row import Row, from_table
from evidence.validation.wires import STEP


def page(tables: Tables) -> str:
    """Return the whole page."""
    codes = [
        *_rod(tables["discrete_rod/comparisons"]),
        *_exudyn(tables["exudyn/frequencies"], tables["exudyn/winding"]),
    ]
    found = [*from_table(tables["rows"]), *codes, *_contact(tables["contact/checks"])]
    data: dict[str, Any] = {
        "step": STEP,
        "fold": FOLD,
        "runs": RUNS,
        "near": tables["poses"]["apart"].min(),
        "far": rows(tables["poses"], pose=(1, 2, 3))["apart"].max(),
        "rows": [_cells(row, above) for row, above in zip(found, [None, *found], strict=False)],
        "held": sum(not row.shown and not row.misses for row in found),
        "stated": sum(not row.shown for row in found),
        "missed": [row.id for row in found if row.misses],
    }
    return render("validation/validation.md.j2", data)


def _cells(row: Row, above: Row | None) -> tuple[str, ...]:
    """Return the row; a reference that is that of the row above is not repeated."""
    bound = "none" if row.shown else f"< {with_unit(row.bound, row.unit)}"
    verdict = ", **missed**" if row.misses and not row.shown else ""
    return (
        row.id,
        row.kind,
        "" if above and above.reference == row.reference else row.reference,
        f"{row.what} {with_unit(row.value, row.unit)}",
        f"{bound}{verdict}",
        "" if row.test == "make validate" else f"`{row.test}`",
    )


def _rod(t: Table) -> Iterator[Row]:
    """The discrete rod: differences over what the convergence of the two codes accepts."""
    for k, case in enumerate(dict.fromkeys(t["case"].tolist()), 1):
        r = rows(t, case=case)
        what = f"quantities: {len(r['case'])}; largest deviation / bound:"
        value = float(np.max(r["difference, fine"] / r["accepted"]))
        yield Row(f"R-{k}", "code", f"discrete rod: {case}", what, value, "1", 1.0, "make validate")


def _exudyn(f: Table, w: Table) -> Iterator[Row]:
    """Exudyn: differences of its finest runs from ours."""
    values = np.array([f[name] for name in f if name.endswith("_Hz")]).T
    ours = np.char.startswith(f["code"], "ours")
    off = max(
        np.abs(values[i] / values[ours & (f["height_m"] == f["height_m"][i])] - 1).max()
        for i in range(ours.size)
    )
    source = "Exudyn: 120 m, no coupling"
    test = "make validate"
    what = "in-plane frequencies, ends 0 and 80 m apart in height: deviation"
    yield Row("X-1", "code", source, what, float(off), "1", 2e-3, test)
    finest = (w["code"] == "ours") & (w["force_error_vs_ours"] == 0)
    source = f"{source}, wound by 90 m, the finest run of each code"
    force, loop = (
        float(w[name][finest][0]) for name in ("force_error_vs_exudyn", "loop_error_vs_exudyn_m")
    )
    yield Row("X-2", "code", source, "end forces: deviation", force, "1", math.nan, test)
    yield Row("X-3", "code", source, "loop's lowest point: deviation", loop, "m", math.nan, test)


def _contact(t: Table) -> Iterator[Row]:
    """Contact: of each case the check that comes nearest to its bound."""
    for k, case in enumerate(dict.fromkeys(t["case"].tolist()), 1):
        r = rows(t, case=case)
        over = [_part(*x) for x in zip(r["value"], r["relation"], r["bound"], strict=True)]
        what = f"checks: {len(r['case'])}; largest value / bound:"
        kind: Literal["code", "theory"] = (
            "code" if any("the chain's" in x for x in r["what"]) else "theory"
        )
        yield Row(f"K-{k}", kind, f"contact: {case}", what, max(over), "1", 1.0, "make contact")


def _part(value: float, relation: str, bound: float) -> float:
    """Return how much of its acceptance a check uses; above 1 it misses."""
    if relation == "<":
        return value / bound
    return bound / value if value > 0 else math.inf
