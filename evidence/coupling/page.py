"""What docs/coupling.md says, computed from the tables: errors, orders, costs, stability and energy of the schemes."""

from __future__ import annotations

from typing import Any

import numpy as np

from evidence.machine import facts
from evidence.rendering import number, quantity, render
from evidence.tables import Table, Tables, rows
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.cosimulation.schemes.stability import MARGIN
from hoist_demo.parameters import Coupling

from .reading import PROMISED, correct_predictions, order, order_on_hoist, theory


def page(tables: Tables) -> str:
    """The whole page."""
    data = {
        "default": Coupling().scheme,
        "margin": MARGIN,
        "cases": _cases(tables["cases"]),
        "orders": [_order(tables, name) for name in SCHEMES],
        "costs": _costs(tables["schemes"]),
        "machine": facts(tables["machine"]),
        "stability": _stability(tables["stability"]),
        "energy": _energy(tables["energy"]),
        "names": list(tables),
    }
    return render("coupling/coupling.md.j2", data)


def _cases(t: Table) -> dict[str, Any]:
    """The default scheme on every case."""
    lines = [
        (
            name,
            number(ratio, ".2f"),
            quantity(travel, "m", "g"),
            number(growth, ".3f"),
            quantity(rms, "%", ".2g"),
            quantity(largest, "%", ".2g"),
            "yes" if rms < PROMISED else "**no**",
        )
        for name, ratio, travel, growth, rms, largest in _columns(
            t, "case", "ropes over conveyance", "travel [m]", "predicted growth", "force error", "largest error"
        )
    ]
    accurate, stable = all(t["force error"] < PROMISED), all(t["predicted growth"] < MARGIN)
    return {"rows": lines, "accurate": accurate, "stable": stable}


def _columns(t: Table, *names: str) -> Any:
    return zip(*(t[name].tolist() for name in names), strict=True)


def _order(tables: Tables, name: str) -> tuple[str, ...]:
    """Orders of a scheme in theory, on two masses and on the hoist, and its error."""
    at = rows(tables["schemes"], scheme=name)
    error = at["force error"][np.isclose(at["H [s]"], 0.01)][0]
    exact, hoist = order(tables["oscillator"], name, 0.01, 0.005), order_on_hoist(tables["schemes"], name)
    return name, str(theory(name)), number(exact, ".2f"), number(hoist, ".2f"), quantity(error, "%", ".2g")


def _costs(schemes: Table) -> list[tuple[str, ...]]:
    """Error, exchanges and time of every scheme at 10 ms."""
    t = rows(schemes, **{"H [s]": 0.01})
    base = float(t["cost [s/s]"][t["scheme"] == Coupling().scheme][0])
    return [
        (name, quantity(error, "%", ".2g"), number(exchanges), number(cost / base, ".2f"))
        for name, error, exchanges, cost in _columns(t, "scheme", "force error", "exchanges per step", "cost [s/s]")
    ]


def _stability(t: Table) -> dict[str, Any]:
    """How many points of the map are stable, and how many happened as predicted."""
    lines = []
    for name in dict.fromkeys(t["scheme"].tolist()):
        r = rows(t, scheme=name)
        told, n = correct_predictions(r, MARGIN)
        lines.append((name, f"{int(np.sum(r['stable']))} of {n}", f"{told} of {n}"))
    agree, count = correct_predictions(t, MARGIN)
    return {"rows": lines, "agree": agree, "count": count}


def _energy(t: Table) -> dict[str, Any]:
    """Step control at several bounds."""
    lines = [
        (
            quantity(bound, "W", "g"),
            quantity(power, "W"),
            number(exchanges, ".0f"),
            number(extra, ".0f"),
            quantity(error, "%", ".2g"),
        )
        for bound, power, exchanges, extra, error in _columns(
            t, "bound [W]", "power [W]", "exchanges", "extra exchanges", "force error"
        )
    ]
    return {"rows": lines, "kept": bool(np.all(t["power [W]"] <= t["bound [W]"]))}
