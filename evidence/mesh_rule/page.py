"""What docs/mesh_rule.md says, computed from the tables: laws, the rule's constants against them, errors of trips."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from evidence.rendering import number, quantity, render
from evidence.tables import Table, Tables
from rope_model.simulation import mesh, mesh_fit

from . import figures, laws
from .judging import distribution, is_resolved, misses, swing
from .laws import Laws
from .rule import MANY, Shares, judges, longest, shares, slip
from .scenes import FIT, JUDGE, KINDS
from .trips import ASKED

FIGURES = {"laws": figures.draw}
#: m, the errors at which the rule is compared with the laws, and those of them of which the constants tell
ERRORS = (0.05, 0.02, 0.01, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4)
TELLING = (0.05, ASKED, 1e-3, 2e-4)


def page(tables: Tables) -> str:
    """The whole page."""
    found, ropes = laws.fit(tables), judges()
    by_error = {asked: shares(found, ropes, asked) for asked in ERRORS}
    shorter, longer = slip(tables["loop"])
    ends = off(tables["parts"], "ends", KINDS[0])
    data = {
        "laws": found,
        "resolved_layers": laws.RESOLVED,
        "fit_seed": FIT,
        "spreads": _spreads(found),
        "judging_seed": JUDGE,
        "ropes": MANY,
        "shares": _shares(by_error),
        "mesh": mesh,
        "fit": mesh_fit,
        "worst_shares": [(e, {"loop": by_error[e].loop.max(), "cover": by_error[e].cover.max()}) for e in TELLING],
        "longest": longest(),
        "slip": {"shorter": shorter, "longer": longer},
        "asked": ASKED,
        "moment": by_error[ASKED].moment.max(),
        "ends": {"median": np.median(ends), "most": ends.max()},
        "steps": {
            name: np.median(off(tables["parts"], "steps", kind))
            for name, kind in zip(("smooth", "stopped"), KINDS, strict=True)
        },
        "judged": _distributions(tables["judge"]),
        "swings": [_swing(tables["judge"], kind) for kind in KINDS],
        "misses": _misses(tables["judge"]),
        "data": sorted(tables),
    }
    return render("mesh_rule/mesh_rule.md.j2", data)


def off(t: Table, what: str, kind: str) -> laws.Array:
    """How far the loop's place is off by one part of the mesh or by the steps, m."""
    return np.asarray(t["off [m]"][(t["what"] == what) & (t["trip"] == kind)])


def _spreads(found: Laws) -> list[dict[str, Any]]:
    """Factors between fit and measurement: root mean square, largest."""
    names = ("loop", "cover", "ends", "legs", "legs after a stop")
    return [
        {"name": name, "typical": math.exp(fit.spread), "worst": math.exp(fit.worst)}
        for name, fit in zip(names, found, strict=True)
    ]


def _shares(by_error: Mapping[float, Shares]) -> list[tuple[str, ...]]:
    """What the rule's lengths take of what is asked: median, worst."""
    return [
        (
            quantity(asked, "mm", "g"),
            *(f"{number(np.median(part), '.2g')}, {number(part.max(), '.2g')}" for part in (of.loop, of.cover)),
            f"{quantity(np.median(of.moment), '%', '.2g')}, {quantity(of.moment.max(), '%', '.2g')}",
        )
        for asked, of in by_error.items()
    ]


def _distributions(t: Table) -> list[tuple[str, ...]]:
    """Achieved over asked, by what was asked and by the trip."""
    rows = []
    for asked in sorted(set(t["asked [m]"][is_resolved(t)].tolist()), reverse=True):
        for kind in KINDS:
            d = distribution(t, kind, asked)
            ratios = (number(x, ".2g") for x in (d.median, d.most, d.worst))
            within, elements = quantity(d.within, "%", ".0f"), number(d.elements, ".0f")
            rows.append((quantity(asked, "mm", "g"), kind, str(d.number), *ratios, within, elements))
    return rows


def _swing(t: Table, kind: str) -> dict[str, Any]:
    median, most = swing(t, kind)
    return {"kind": kind, "median": median, "most": most}


def _misses(t: Table) -> list[tuple[str, ...]]:
    """Runs beyond ASKED."""
    rows = []
    for i in misses(t, ASKED):
        length = t["length [m]"][i]
        size = quantity(length, "m", ".0f"), number(length / t["w [m]"][i], ".0f")
        errors = (quantity(t[name][i], "mm", ".2g") for name in ("achieved [m]", "at rest [m]"))
        rows.append((*size, str(t["trip"][i]), quantity(t["speed [m/s]"][i], "m/s", ".1f"), *errors))
    return rows
