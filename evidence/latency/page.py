"""What docs/latency.md says, computed from the tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.latency import COUNTED, FMU_STEP, READ, SETTLE, STOP
from benchmarks.rest import PUSH, RESTS, H
from evidence.machine import facts
from evidence.rendering import number, quantity, render
from evidence.tables import Table, Tables, rows

from .tables import CAUSES, SLOWEST

#: causes in words
WORDS = {
    "count.rejections": "a rejected step",
    "count.transformations": "a transformation",
    "count.swivel_events": "a swivel event",
}


def page(tables: Tables) -> str:
    """The whole page."""
    t = tables["steps"]
    inside, outside = rows(t, place="in process"), rows(t, place="FMU")
    same = rows(inside, **{"H [s]": FMU_STEP})
    causes = rows(tables["causes"], level="standard")
    medians = outside["own 50 % [s]"], same["own 50 % [s]"]
    data = {
        "settle": SETTLE,
        "stop": STOP,
        "step": FMU_STEP,
        "read": READ,
        "rounds": int(t["rounds"][0]),
        "levels": {level: _percentiles(rows(inside, level=level)) for level in dict.fromkeys(t["level"].tolist())},
        "fmu": _percentiles(outside),
        "fmu_part": float(np.min(medians[0] - medians[1])),
        "fmu_ratio": float(np.max(medians[0] / medians[1])),
        "late": _late(t),
        "slowest": SLOWEST,
        "causes": _causes(rows(causes, **{"H [s]": FMU_STEP})),
        "worst": _worst(causes),
        "memory": _memory(tables["memory"]),
        "taken": int(tables["memory"]["blocks while stepping"].sum()),
        "rest": _rest(tables["rest"]),
        "rests": RESTS,
        "rest_step": H,
        "push": PUSH,
        "machine": facts(tables["machine"]),
        "names": list(tables),
    }
    return render("latency/latency.md.j2", data)


def _us(x: float) -> str:
    return number(1e6 * x, ".3g")


def _lines(t: Table) -> list[dict[str, Any]]:
    return [dict(zip(t, line, strict=True)) for line in zip(*(column.tolist() for column in t.values()), strict=True)]


def _percentiles(t: Table) -> list[tuple[str, ...]]:
    """A line for each case."""
    named = ("50 % [s]", "90 % [s]", "99 % [s]", "99.9 % [s]", "largest [s]", "own 99.9 % [s]", "own largest [s]")
    return [
        (
            f"{r['scene']}, {r['trip']}",
            quantity(r["H [s]"], "ms", "g"),
            r["level"],
            number(r["elements"], ".0f"),
            *(_us(r[name]) for name in named),
            quantity(r["late"], "%", ".2g"),
            quantity(r["own late"], "%", ".2g"),
        )
        for r in _lines(t)
    ]


def _late(t: Table) -> dict[str, Any]:
    """Where a step took longer than the communication step, and how much of that the longest one took elsewhere."""
    cases = [f"{r['scene']}, {r['trip']}, {r['level']}, {r['place']}" for r in _lines(t)]
    late, own = (
        [
            f"{case} at {quantity(H, 'ms', 'g')}"
            for case, H, share in zip(cases, t["H [s]"], t[name], strict=True)
            if share
        ]
        for name in ("late", "own late")
    )
    return {"as_run": late, "own": own, "part": float(np.max(t["own largest [s]"] / t["H [s]"])), "cases": len(cases)}


def _causes(t: Table) -> list[dict[str, Any]]:
    """What happened in the slowest steps of each scene."""
    found = []
    for r in _lines(t):
        share = {name: r[f"{name}, slowest"] for name in CAUSES}
        often = (f"{quantity(share[name], '%', '.2g')} ({number(1e2 * r[f'{name}, all'], '.2g')})" for name in CAUSES)
        iterations = f"{number(r['count.newton, slowest'], '.2g')} ({number(r['count.newton, all'], '.2g')})"
        taken = (_us(r[name]) for name in ("iteration [s]", "transformation [s]"))
        name = f"{r['scene']}, {r['trip']}"
        row = name, *often, iterations, *taken, quantity(r["explained"], "%", ".2g")
        found.append({"row": row, "scene": name, "cause": cause(share)})
    return found


def cause(shares: Mapping[str, float]) -> str:
    """What most of the slowest steps have, in words."""
    name = max(shares, key=lambda name: shares[name])
    if shares[name] < 0.5:
        return "nothing that most of them have"
    return f"{WORDS[name]}, in {quantity(shares[name], '%', '.2g')} of them"


def _worst(t: Table) -> list[tuple[str, ...]]:
    """The slowest step of each case and what it did."""
    return [
        (
            f"{r['scene']}, {r['trip']}",
            quantity(r["H [s]"], "ms", "g"),
            _us(r["worst [s]"]),
            quantity(r["worst at [s]"], "s", ".2f"),
            *(number(r[f"worst {name}"], ".0f") for name in COUNTED),
        )
        for r in _lines(t)
    ]


def _memory(t: Table) -> list[tuple[str, ...]]:
    r = rows(t, trip="winding")
    return [
        (line["scene"], line["level"], number(line["elements"], ".0f"), f"{number(1e-3 * line['bytes'], '.3g')} kB",
         number(line["blocks"], ".0f"))
        for line in _lines(r)
    ]  # fmt: skip


def _rest(t: Table) -> dict[str, Any]:
    lines = [
        (
            r["what"],
            _us(r["first [s]"]),
            _us(r["last [s]"]),
            _us(r["last, flushed [s]"]),
            quantity(r["denormal operands"], "%", ".2g"),
            number(r["at the ends"], ".0f"),
            number(r["inside"], ".0f"),
        )
        for r in _lines(t)
    ]
    more = t["last [s]"] / t["last, flushed [s]"] - 1.0
    some, none = more[t["denormal operands"] > 0.0], more[t["denormal operands"] == 0.0]
    return {
        "rows": lines,
        "known": bool(some.size and none.size),
        "more": float(np.max(some, initial=0.0)),
        "without": float(np.max(none, initial=0.0)),
        "inside": int(t["inside"].sum()),
    }
