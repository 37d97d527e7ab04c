"""What docs/validation.md says, from the recorded data."""

from __future__ import annotations

from typing import Any

from evidence.rendering import number, render
from evidence.tables import Table, Tables, rows

from .chains import FOLD
from .row import Row, from_table
from .wires import GAPS, STEP


def page(tables: Tables) -> str:
    """The whole page."""
    found = from_table(tables["rows"])
    gaps = [f"ours, ends {1e3 * gap:.0f} mm apart" for gap in GAPS]
    data: dict[str, Any] = {
        "step": STEP,
        "fold": FOLD,
        "rows": [_cells(row) for row in found],
        "wires": _wires(tables["wires"]),
        "wire_head": ("wire", "EI, 1e-3 N m²", "GJ, 1e-3 N m²", "measured, deg", *gaps),
        "pulls": [tuple(number(x) for x in cells) for cells in zip(*tables["pulls"].values(), strict=True)],
        "twisted": [
            (number(twist), str(code), *(number(x, ".6g") for x in numbers))
            for twist, code, *numbers in zip(*tables["twisted"].values(), strict=True)
        ],
        "missed": [row.id for row in found if row.misses],
        "files": sorted(tables),
    }
    return render("validation/validation.md.j2", data)


def _cells(row: Row) -> tuple[str, ...]:
    unit = "" if row.unit == "1" else f" {row.unit}"
    bound = "none" if row.shown else f"< {number(row.bound)}{unit}"
    verdict = "shown" if row.shown else "misses" if row.misses else "holds"
    test = f"`{row.test}`"
    return row.id, row.kind, row.reference, f"{row.what} {number(row.value)}{unit}", bound, verdict, test


def _wires(t: Table) -> list[tuple[str, ...]]:
    """Per wire and pair of stiffnesses: what was measured, and what is found with each gap."""
    pairs = dict.fromkeys(zip(*(t[name] for name in ("wire", "EI", "GJ", "least", "most")), strict=True))
    cells = []
    for wire, EI, GJ, least, most in pairs:
        found = rows(t, wire=str(wire), EI=float(EI), GJ=float(GJ))["found"]
        measured = f"{number(least)} to {number(most)}"
        cells.append((str(wire), number(1e3 * EI), number(1e3 * GJ), measured, *(number(x, ".0f") for x in found)))
    return cells
