"""What docs/validation.md says, from the recorded data."""

from __future__ import annotations

from typing import Any

from evidence.rendering import number, render
from evidence.tables import Table, Tables, rows

from .cabledyn_motion import MODES, TIME, WAY
from .chains import FOLD
from .row import Row, from_table
from .wires import GAPS, STEP

#: s, of the winding
SHOWN = (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0)


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
        "twisted": _by_code(tables["twisted"]),
        "frequencies": _frequencies(tables["frequencies"]),
        "winding": _by_code(rows(tables["winding"], time=SHOWN)),
        "mode_head": ("height, m", "code", *(f"{k + 1}" for k in range(MODES))),
        "way": WAY,
        "rise": TIME,
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


def _by_code(t: Table) -> list[tuple[str, ...]]:
    """What the rows' first six columns say."""
    return [
        (number(at), str(code), *(number(x, ".6g") for x in numbers))
        for at, code, *numbers in zip(*list(t.values())[:7], strict=True)
    ]


def _frequencies(t: Table) -> list[tuple[str, ...]]:
    """Per height and code: its modes."""
    found = []
    for height in dict.fromkeys(t["height"].tolist()):
        modes = rows(t, height=height)
        for code, name in (("ours", "ours"), ("cabledyn", "CableDyn")):
            found.append((number(height), name, *(number(f, ".6g") for f in modes[code])))
    return found


def _wires(t: Table) -> list[tuple[str, ...]]:
    """Per wire and pair of stiffnesses: what was measured, and what is found with each gap."""
    pairs = dict.fromkeys(zip(*(t[name] for name in ("wire", "EI", "GJ", "least", "most")), strict=True))
    cells = []
    for wire, EI, GJ, least, most in pairs:
        found = rows(t, wire=str(wire), EI=float(EI), GJ=float(GJ))["found"]
        measured = f"{number(least)} to {number(most)}"
        cells.append((str(wire), number(1e3 * EI), number(1e3 * GJ), measured, *(number(x, ".0f") for x in found)))
    return cells
