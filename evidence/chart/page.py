"""What docs/chart.md says, computed from the tables: fronts, savings, and what step, mesh and fidelity change."""

from __future__ import annotations

from typing import Any

import numpy as np

from evidence.machine import facts
from evidence.rendering import number, quantity, render
from evidence.reproduction.costs import SOURCE_SAVED
from evidence.tables import Table, Tables, rows

from . import depth
from .front import cheapest
from .levels import levels
from .measure import COST
from .reading import FORCE, LOOP, TWIST, elements_for, finest, limit, the, time_saving

COUPLINGS = ("coupled", "uncoupled")
#: asked for in the tables: fraction of the largest force, m
FORCES, PLACES = (1e-2, 1e-3, 1e-4), (0.1, 0.01, 0.001)
ASKED = [(FORCE, bound, f"{quantity(bound, '%', 'g')} end force") for bound in FORCES]
ASKED += [(LOOP, bound, f"{quantity(bound, 'mm', 'g')} loop") for bound in PLACES]
#: level -> bound of the end-force error, times real time
AIMS = {"draft": (0.03, 30), "standard": (0.005, 10), "standard, 10 ms": (0.005, 10)}


def page(tables: Tables) -> str:
    """The whole page."""
    t = tables["points"]
    compiled, interpreted = (
        rows(t, family=family, coupling="coupled", **wanted)[COST]
        for family, wanted in (("levels", {"name": "standard"}), ("kernels", {"kernels": "portable"}))
    )
    data = {
        "machine": facts(tables["machine"]),
        "levels": levels(tables),
        "aims": _aims(t),
        "references": [_reference(t, c) for c in COUPLINGS],
        "peer_drawn": "peer" in tables,
        "fastest": [(words, *(_fastest(t, c, error, bound) for c in COUPLINGS)) for error, bound, words in ASKED],
        "steps_and_sizes": _steps_and_sizes(t),
        "exact": _against_complete(t, "uncoupled", ("spatial", "planar")),
        "approximate": _against_complete(t, "coupled", ("planar", "rigid")),
        "interpreted": interpreted[0] / compiled[0] if interpreted.size else None,
        "tmn_against_eem": [
            (words, *(x for c in COUPLINGS for x in _tmn_against_eem(t, c, e, bound))) for e, bound, words in ASKED
        ],
        "stated": [_statement(t, c) for c in COUPLINGS],
        "finest": depth.FINEST,
        "depth": depth.reading(tables["depth"]),
        "solver": _solver(t),
    }
    return render("chart/chart.md.j2", data)


def _aims(t: Table) -> list[dict[str, Any]]:
    """What the levels are meant to reach, and what they reach."""
    found = []
    for name, (bound, factor) in AIMS.items():
        r = rows(t, family="levels", name=name, coupling="coupled")
        if r["name"].size:
            found.append(
                {"name": name, "bound": bound, "error": r[FORCE][0], "factor": factor, "speed": 1 / r[COST][0]}
            )
    return found


def _reference(t: Table, coupling: str) -> dict[str, Any]:
    """The reference solution, what coarser ones differ from it by, and its own error."""
    r = rows(t, family="reference", coupling=coupling)
    n, h = finest(t, coupling)
    differences = [
        (
            number(k, "g"),
            quantity(s, "ms", "g"),
            quantity(force, "%", ".2g"),
            quantity(loop, "mm", ".2g"),
            quantity(twist, "mrad", ".2g") if np.isfinite(twist) else "",
        )
        for k, s, force, loop, twist in zip(
            r["elements"], r["largest step [s]"], r[FORCE], r[LOOP], r[TWIST], strict=True
        )
        if (k, s) != (n, h)
    ]
    errors = {name: limit(t, coupling, error) for name, error in (("force", FORCE), ("loop", LOOP), ("twist", TWIST))}
    return {"coupling": coupling, "elements": n, "step": h, "differences": differences, **errors}


def _fastest(t: Table, coupling: str, error: str, bound: float) -> str:
    r = rows(t, family=("eem", "tmn", "levels"), coupling=coupling)
    i = cheapest(r[COST], r[error], bound)
    if i is None:
        return "none"
    kind = str(r["mesh"][i]).split(",")[0]
    step = min(r["largest step [s]"][i], r["communication step [s]"][i])
    return f"{kind} {r['elements'][i]:.0f}, {quantity(step, 'ms', 'g')}: {1 / r[COST][i]:.0f} x real time"


def _steps_and_sizes(t: Table) -> dict[str, Any] | None:
    """How much the step, and how much the mesh, changes each error; None where only one of either was run."""
    r = rows(t, family="tmn", coupling="coupled")
    chosen = np.char.find(r["name"].astype(str), " m, ") >= 0
    r = {name: column[chosen & ~np.char.startswith(r["name"].astype(str), "l = ")] for name, column in r.items()}
    steps, sizes = np.unique(r["largest step [s]"]), np.unique(r["elements"])
    if min(steps.size, sizes.size) < 2:
        return None
    middle = sizes[sizes.size // 2]
    at, short = r["elements"] == middle, r["largest step [s]"] == steps[0]
    errors = []
    for error, scale, unit in ((FORCE, 100.0, "%"), (LOOP, 1e3, "mm"), (TWIST, 1e3, "mrad")):
        by_step = scale * r[error][at][np.argsort(r["largest step [s]"][at])]
        by_mesh = scale * r[error][short][np.argsort(r["elements"][short])]
        ends = {"by_step": (by_step[0], by_step[-1]), "by_mesh": (by_mesh[0], by_mesh[-1])}
        errors.append({"name": error.split(" error")[0], "unit": unit, **ends})
    return {
        "steps": (steps[0], steps[-1]),
        "size": round(float(middle)),
        "sizes": (round(float(sizes[0])), round(float(sizes[-1]))),
        "errors": errors,
    }


def _against_complete(t: Table, coupling: str, names: tuple[str, ...]) -> list[dict[str, Any]]:
    """How much faster a fidelity is than the complete model, and its errors."""
    r = rows(t, family="fidelities", coupling=coupling)
    full = the(r, "torsional", COST)
    return [
        {"name": n, "ratio": full / the(r, n, COST), "force": the(r, n, FORCE), "loop": the(r, n, LOOP)}
        for n in names
        if n in r["name"]
    ]


def _tmn_against_eem(t: Table, coupling: str, error: str, bound: float) -> tuple[str, str, str]:
    """Elements of either mesh, and the time saved."""
    tmn, eem = (elements_for(t, family, coupling, error, bound) for family in ("tmn", "eem"))
    part = time_saving(t, coupling, error, bound)
    return tmn, eem, f"{part:.0f} %" if np.isfinite(part) else ""


def _statement(t: Table, coupling: str) -> dict[str, Any]:
    """The source's comparison: EEM 600 against the standard level, at the same largest step."""
    r = rows(t, family="levels", name="standard", coupling=coupling)
    eem = the(t, f"600, {1e3 * float(r['largest step [s]'][0]):g} ms", COST, family="eem", coupling=coupling)
    part = 100 * (1 - float(r[COST][0]) / eem)
    return {"coupling": coupling, "saved": part, "elements": r["elements"][0], "source": SOURCE_SAVED[coupling]}


def _solver(t: Table) -> list[dict[str, Any]]:
    """One number of the solver at a time: end-force error, error of the loop's place, real-time factor."""
    c, found = rows(t, coupling="coupled"), []
    for family, column, name in (
        ("tolerance", "tolerance", "the tolerance of the local error (largest step 40 ms)"),
        ("newton", "newton tolerance", "Newton's tolerance"),
        ("rho_inf", "rho_inf", "rho_inf"),
    ):
        r = rows(c, family=family)
        results = [
            f"{value:g}: {quantity(force, '%', '.2g')}, {quantity(loop, 'mm', '.2g')}, {number(1 / cost)} x"
            for value, force, loop, cost in zip(r[column], r[FORCE], r[LOOP], r[COST], strict=True)
        ]
        found.append({"name": name, "results": results})
    return found
