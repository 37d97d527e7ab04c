"""Peak and impulse of a brush against step, mesh and stiffness: python -m evidence.contact.brushes; a minute.

Writes docs/data/contact/brushes.csv, which docs/contact.md shows.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence

from evidence.options import add_out
from evidence.rendering import DOCS, number
from evidence.tables import Table, read, table, write
from rope_model.shaft_parameters import Contact

from .brushed import Brushed, brushed

STIFFNESS = Contact().stiffness
#: elements, 0 for the fitted mesh; step (s); stiffness (N/m^2)
CASES = (
    *((0, step, STIFFNESS) for step in (10e-3, 5e-3, 2e-3)),
    *((480, step, STIFFNESS) for step in (10e-3, 5e-3, 2e-3)),
    *((elements, 5e-3, STIFFNESS) for elements in (120, 240, 960)),
    *((elements, 5e-3, STIFFNESS * times) for times in (0.25, 4.0) for elements in (0, 240, 480)),
)
COLUMNS = ("elements", "step", "stiffness", "peak", "impulse", "told")


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence.contact.brushes", description=__doc__)
    add_out(parser)
    options = parser.parse_args(arguments)
    rows: list[tuple[float, ...]] = []
    for elements, step, stiffness in CASES:
        x: Brushed = brushed(elements, step, stiffness)
        rows.append((float(elements), step, stiffness, x.peak, x.impulse, x.told))
        print(*map(number, rows[-1]), flush=True)
    write({"brushes": table(COLUMNS, rows)}, options.out / "data" / "contact")
    return 0


def brushes_table() -> Table:
    """The recorded one."""
    return read(DOCS / "data" / "contact")["brushes"]


def orders(t: Table) -> dict[str, float]:
    """Of peak and impulse in the elements' length (120, 240, 480 against 960) and in the step (10, 5 against 2 ms)."""
    rows = list(zip(*(t[name] for name in COLUMNS), strict=True))

    def value(elements: float, step: float, column: int) -> float:
        return next(float(r[column]) for r in rows if (r[0], r[1], r[2]) == (elements, step, STIFFNESS))

    def order(coarse: float, fine: float, exact: float) -> float:
        return math.log2(abs(coarse - exact) / abs(fine - exact))

    found = {}
    for name, column in (("peak", 3), ("impulse", 4)):
        found[f"{name}, length"] = order(*(value(n, 5e-3, column) for n in (120.0, 240.0, 960.0)))
        found[f"{name}, step"] = order(*(value(480.0, h, column) for h in (10e-3, 5e-3, 2e-3)))
    return found


if __name__ == "__main__":
    raise SystemExit(main())
