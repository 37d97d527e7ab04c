"""What docs/peer.md says, computed from the tables: differences of frequencies, times at equal error, and yaws.

Exudyn need not be there.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from evidence.rendering import number, quantity, render
from evidence.tables import Table, Tables

from .elements import ELEMENTS
from .precision import LEVELS, Metric, Point, cost_at, front, points

#: rows of the table ``checks``
PLANAR, SPATIAL = "planar beam without damping", "spatial beam without damping"
SYMBOLIC, PYTHON = "ends' motion symbolic", "ends' motion as Python functions"
#: the run that the functions of the ends are timed with, in the tables ``winding`` and ``options``
REPEATED, REPEATED_OPTION = "120, 10 ms", "10 ms, full Newton, radius 0.8"


def page(tables: Tables) -> str:
    """The whole page."""
    runs, checks = points(tables["winding"]), tables["checks"]
    setup = dict(zip(tables["setup"]["what"].tolist(), tables["setup"]["value"].tolist(), strict=True))
    data = {
        "version": setup["version of Exudyn"],
        "repeated": _repetitions(runs, tables, setup["element of the options"]),
        "frequencies": _frequencies(tables["frequencies"]),
        "references": _references(tables["winding"], setup),
        "damping": _errors(checks, PLANAR),
        "damping_in_space": _errors(checks, SPATIAL),
        "winding": [_winding(p) for p in sorted(runs, key=lambda p: (p.code, p.group))],
        "equal": _equal(runs),
        "options": _options(tables["options"], checks, setup),
        "space": [_space(tables["space"], case) for case in dict.fromkeys(tables["space"]["case"].tolist())],
        "yaw": _yaw(tables["yaw"]),
    }
    return render("peer/peer.md.j2", data)


def _repetitions(runs: list[Point], tables: Tables, element: str) -> dict[str, Any]:
    """The times of one run, wherever it was timed."""
    options = tables["options"]
    found = [_check(tables["checks"], SYMBOLIC, "cpu_s_per_s")]
    found += [p.cost for p in runs if (p.group, p.label) == (element, REPEATED)]
    found += options["cpu_s_per_s"][options["option"] == REPEATED_OPTION].tolist()
    return {"name": f"{element}, {REPEATED}", "count": len(found), "least": min(found), "most": max(found)}


def _check(checks: Table, what: str, column: str) -> float:
    return float(checks[column][checks["what"] == what][0])


def _errors(checks: Table, what: str) -> dict[str, float]:
    return {name: _check(checks, what, column) for name, column in (("force", "force_error"), ("loop", "loop_error_m"))}


def _frequencies(t: Table) -> dict[str, Any]:
    """Every code's frequencies, and their largest differences from ours."""
    modes = [name for name in t if name.endswith("_Hz")]
    f = np.array([t[name] for name in modes]).T
    rows, worst, where = [], {"reference": 0.0, "Exudyn": 0.0}, ""
    for i, code in enumerate(t["code"].tolist()):
        same = (t["height_m"] == t["height_m"][i]) & (t["plane"] == t["plane"][i])
        mine = f[same & np.char.startswith(t["code"], "ours")][0]
        ratio = f[i] / mine - 1
        off, plane, height = float(np.abs(ratio).max()), str(t["plane"][i]), quantity(t["height_m"][i], "m", "g")
        if not code.startswith("ours"):
            key = "reference" if code == "reference" else "Exudyn"
            if off > worst[key]:
                worst[key] = off
                if key == "reference":
                    in_words = "out of plane" if plane == "out" else "in plane"
                    where = f"f{int(np.argmax(np.abs(ratio))) + 1}, {in_words}, {height}"
        name = "printed reference" if code == "reference" else code
        rows.append((height, plane, name, *(number(x, ".5f") for x in f[i]), quantity(off, "%", ".3f")))
    head = "height difference", "plane", "", *(f"{name[:-3]} [Hz]" for name in modes), "largest difference from ours"
    return {"head": head, "rows": rows, "exudyn": worst["Exudyn"], "printed": worst["reference"], "where": where}


def _references(t: Table, setup: dict[str, str]) -> dict[str, Any]:
    """What the finest runs of both codes are, and how far they are apart."""
    mine = (t["code"] == "ours") & (t["variant"] == setup["our reference"])
    force, loop = (t[f"{name}_vs_exudyn{unit}"][mine][0] for name, unit in (("force_error", ""), ("loop_error", "_m")))
    element, rest = setup["Exudyn's reference"].split(", ", 1)
    exudyn = f"{ELEMENTS[element].label}, {rest}"
    return {"ours": setup["our reference"], "exudyn": exudyn, "force": force, "loop": loop}


def _winding(p: Point) -> tuple[str, ...]:
    name = ELEMENTS[p.group].label if p.group in ELEMENTS else f"ours, {p.group}"
    if p.failure:
        return name, p.label, "fails", "", "", ""
    return name, p.label, *_numbers(p), number(1 / p.cost, ".1f")


def _numbers(p: Point) -> tuple[str, str, str]:
    return number(p.force, ".1e"), number(1e3 * p.loop, ".2f"), number(p.cost, ".3f")


def _equal(runs: list[Point]) -> list[tuple[str, ...]]:
    """Times of both codes at equal errors."""
    fronts: dict[tuple[str, Metric], list[Point]] = {
        (code, metric): front([p for p in runs if p.code == code], metric)
        for code in ("ours", "Exudyn")
        for metric in LEVELS
    }
    rows = []
    for metric, levels in LEVELS.items():
        for level in levels:
            a, b = (cost_at(fronts[code, metric], metric, level) for code in ("ours", "Exudyn"))
            what = f"end force {level:.0e}" if metric == "force" else f"loop {quantity(level, 'mm', 'g')}"
            cells = (
                ("-" if math.isnan(x) else number(x, form)) for x, form in ((a, ".3f"), (b, ".3f"), (b / a, ".2f"))
            )
            rows.append((what, *cells))
    return rows


def _options(t: Table, checks: Table, setup: dict[str, str]) -> dict[str, Any]:
    """Exudyn's options, and what the form of the ends' motion costs."""
    rows = [
        (option, number(force, ".1e"), number(1e3 * loop, ".2f"), number(cost, ".3f"))
        for option, force, loop, cost in zip(
            *(t[name].tolist() for name in ("option", "force_error", "loop_error_m", "cpu_s_per_s")), strict=True
        )
    ]
    element, count = setup["element of the options"], setup["elements of the options"]
    times = {name: _check(checks, what, "cpu_s_per_s") for name, what in (("symbolic", SYMBOLIC), ("python", PYTHON))}
    return {"element": f"{ELEMENTS[element].label}, {count} elements", "rows": rows, **times}


def _space(t: Table, case: str) -> dict[str, Any]:
    """Runs in space, and the times at the error of the best run of either code that the other reaches too."""
    mine = t["case"] == case
    names = ("code", "code", "variant", "step_s", "cpu_s_per_s", "force_error", "loop_error_m", "failure")
    runs = [Point(*row) for row in zip(*(t[name][mine].tolist() for name in names), strict=True)]
    rows = []
    for p in runs:
        name = f"{'ours, ' if p.code == 'ours' else ''}{p.label}"
        rows.append((name, "fails", "", "") if p.failure else (name, *_numbers(p)))
    fronts = {code: front([p for p in runs[1:] if p.code == code], "loop") for code in ("ours", "Exudyn")}
    level = max(kept[-1].loop for kept in fronts.values())
    ours, exudyn = (cost_at(kept, "loop", level) for kept in fronts.values())
    return {"title": case, "rows": rows, "level": level, "ours": ours, "exudyn": exudyn}


def _yaw(t: Table) -> list[tuple[str, ...]]:
    """The twisted rope."""
    columns = (t[name].tolist() for name in ("code", "twist_rad", "torque_Nm", "yaw_deg", "left_z_m", "right_z_m"))
    return [
        (
            code,
            number(twist, ".2f"),
            number(torque, ".3f"),
            number(yaw, ".3f"),
            f"{number(left, '+.4f')}, {number(right, '+.4f')}",
        )
        for code, twist, torque, yaw, left, right in zip(*columns, strict=True)
    ]
