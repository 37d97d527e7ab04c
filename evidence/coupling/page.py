"""Tables of the coupling schemes, from docs/data/coupling."""

import math

import numpy as np

from evidence.rendering import number, quantity
from evidence.tables import Table, records, rows
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.parameters import Coupling

#: order in H that theory gives for smooth motion, by the end of a scheme's name
ORDERS = {
    "0": 1,
    "1": 2,
    "2": 3,
    "preserving": 1,
    "impulse": 1,
    "controlled": 2,
    **dict.fromkeys(("jacobian", "aitken", "secant"), 4),
}


def theory(scheme: str) -> int:
    """Return the order in H of a scheme."""
    return ORDERS[scheme.rpartition("-")[2]]


def order(t: Table, scheme: str) -> float:
    """Return the observed order; of iterative schemes at long steps, where the reference's tolerance does not show."""
    longer, shorter = (0.04, 0.02) if scheme.startswith("iterative") else (0.02, 0.005)
    r = rows(t, scheme=scheme)
    a, b = (float(r["force error"][np.isclose(r["H [s]"], H)][0]) for H in (longer, shorter))
    return math.log(a / b) / math.log(longer / shorter) if math.isfinite(a / b) else math.nan


def schemes(t: Table) -> list[tuple[str, ...]]:
    """Return orders, errors and costs of all schemes."""
    at = {r["scheme"]: r for r in records(rows(t, **{"H [s]": 0.01}))}
    base = at[Coupling().scheme]["cost [s/s]"]
    return [
        (
            name,
            str(theory(name)),
            number(order(t, name), ".2f"),
            quantity(at[name]["force error"], "%", ".2g"),
            number(at[name]["exchanges per step"]),
            number(at[name]["cost [s/s]"] / base, ".2f"),
        )
        for name in SCHEMES
    ]


def cases(t: Table) -> list[tuple[str, ...]]:
    """Return the errors of the default scheme on every case."""
    return [
        (
            r["case"],
            number(r["ropes over conveyance"], ".2f"),
            quantity(r["travel [m]"], "m", "g"),
            number(r["predicted growth"], ".3f"),
            *(quantity(r[name], "%", ".2g") for name in ("force error", "largest error")),
        )
        for r in records(t)
    ]
