"""Numbers of docs/accuracy.md: fronts, savings, fidelities, and times of single steps."""

from typing import Any

import numpy as np

from evidence.accuracy import depth
from evidence.accuracy.front import cheapest, cost_at
from evidence.accuracy.levels import levels
from evidence.accuracy.measure import COST
from evidence.accuracy.reading import FORCE, LOOP, finest, limit
from evidence.latency.page import latencies
from evidence.promise.judging import ESTIMATES, completed, near, over_asked
from evidence.promise.scenes import JUDGE
from evidence.rendering import number, quantity, render
from evidence.tables import Table, Tables, records, rows

COUPLINGS = ("coupled", "uncoupled")
#: asked for in the tables: fraction of the largest force, m
FORCES = (1e-2, 1e-3, 1e-4)
PLACES = (0.1, 0.01, 0.001)
ASKED = [(FORCE, bound, f"{quantity(bound, '%', 'g')} end force") for bound in FORCES]
ASKED += [(LOOP, bound, f"{quantity(bound, 'mm', 'g')} loop") for bound in PLACES]
#: errors at which the codes are compared: relative end force, and m
LEVELS = {"force": (1e-3, 3e-4, 1e-4, 5e-5), "loop": (2e-2, 1e-2, 5e-3, 3e-3, 2e-3)}


def page(tables: Tables) -> str:
    """Return the whole page."""
    t = tables["points"]
    data = {
        "machine": dict(zip(*tables["machine"].values(), strict=True)),
        "levels": levels(tables),
        "promise": _promise(tables["promise/scenes"]),
        "own": [
            {"coupling": c, "force": limit(t, c, FORCE), "loop": limit(t, c, LOOP)}
            for c in COUPLINGS
        ],
        "finest": finest(t, "coupled"),
        "fastest": [
            (words, *(_fastest(t, c, error, bound) for c in COUPLINGS))
            for error, bound, words in ASKED
        ],
        "spacing": depth.FINEST,
        "depth": depth.reading(tables["depth"]),
        "exact": _against_complete(t, "uncoupled", ("spatial", "planar")),
        "approximate": _against_complete(t, "coupled", ("planar", "rigid")),
        "equal": equal_errors(tables["exudyn/winding"]),
        "latency": latencies(tables),
    }
    return render("accuracy/accuracy.md.j2", data)


def readme(tables: Tables) -> str:
    """Return what README says of accuracy."""
    form = "interpreted" if "portable" in tables["points"]["kernels"] else "compiled"
    found = {
        "promise": _promise(tables["promise/scenes"]),
        "equal": equal_errors(tables["exudyn/winding"]),
    }
    return render("accuracy/readme.md.j2", {"levels": levels(tables), "form": form, **found})


def _promise(scenes: Table) -> dict[str, Any]:
    """Return how far the accuracy that is asked for is kept."""
    t = completed(scenes)
    tight = over_asked(completed(scenes, "tight"), "tight")
    over = over_asked(t)
    of = {
        "number": len(over),
        "seed": JUDGE,
        "within": float(np.mean(over <= 1)),
        "worst": over.max(),
    }
    of |= {
        "kept": int(np.sum(over <= 1)),
        "tight": len(tight),
        "tight_kept": int(np.sum(tight <= 1)),
    }
    return {**of, "near": [near(t, estimate) for estimate in ESTIMATES]}


def _fastest(t: Table, coupling: str, error: str, bound: float) -> str:
    r = rows(t, family=("eem", "tmn", "levels"), coupling=coupling)
    i = cheapest(r[COST], r[error], bound)
    if i is None:
        return "none"
    kind = str(r["mesh"][i]).split(",")[0]
    step = min(r["largest step [s]"][i], r["communication step [s]"][i])
    return f"{kind} {r['elements'][i]:.0f}, {quantity(step, 'ms', 'g')}: {1 / r[COST][i]:.0f}"


def _against_complete(t: Table, coupling: str, names: tuple[str, ...]) -> list[dict[str, Any]]:
    """Return how much faster each fidelity is than the complete model, and its errors."""
    r = {point["name"]: point for point in records(rows(t, family="fidelities", coupling=coupling))}
    full = r["torsional"][COST]
    return [
        {"name": n, "ratio": full / r[n][COST], "force": r[n][FORCE], "loop": r[n][LOOP]}
        for n in names
    ]


def equal_errors(t: Table) -> dict[str, Any]:
    """Return the times of ours and of Exudyn at equal errors; neither is its own judge: the larger error counts."""
    found = []
    ratios = dict[str, list[float]]()
    ours = t["code"] == "ours"
    for metric, unit in (("force", ""), ("loop", "_m")):
        error = np.maximum(t[f"{metric}_error_vs_ours{unit}"], t[f"{metric}_error_vs_exudyn{unit}"])
        for level in LEVELS[metric]:
            a, b = (cost_at(t["cpu_s_per_s"][mine], error[mine], level) for mine in (ours, ~ours))
            what = (
                f"end force {quantity(level, '%', 'g')}"
                if metric == "force"
                else f"loop {quantity(level, 'mm', 'g')}"
            )
            found.append((what, f"{number(1 / a)}", f"{number(1 / b)}", number(b / a, ".0f")))
            ratios.setdefault(metric, []).append(b / a)
    return {"rows": found, **{name: (min(x), max(x)) for name, x in ratios.items()}}
