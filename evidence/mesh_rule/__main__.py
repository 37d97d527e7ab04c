"""Measure what the constants of the 'auto' mesh rest on, fit, and write docs/mesh_rule.md; some eight minutes.

Prints the fits with their spread and, on the judging seed, achieved over asked errors.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from evidence.drawing import draw_to
from evidence.tables import read, write

from . import statics, trips
from .figures import draw
from .page import page, summary
from .scenes import FIT, JUDGE
from .scenes import draw as drawn

DOCS, DATA, IMAGE = Path("docs"), Path("data") / "mesh_rule", Path("images") / "mesh_rule.png"
#: what is measured, on how many ropes of which seed
TABLES = {
    "loop": (statics.loop, FIT, 16),
    "cover": (statics.cover, FIT, 16),
    "ends": (statics.ends, FIT, 16),
    "parts": (trips.parts, FIT, 16),
    "judge": (trips.judge, JUDGE, 16),
}


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence.mesh_rule", description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS, metavar="DIR", help="where to (%(default)s)")
    parser.add_argument("--only", choices=[*TABLES, "draw"], help="measure one table anew; draw: none")
    parser.add_argument("--ropes", type=int, metavar="N", help="fewer or more ropes than the page's")
    options = parser.parse_args(arguments)
    for name, (measure, seed, number) in TABLES.items():
        if options.only in (None, name):
            ropes = list(drawn(seed, options.ropes or number))
            write({name: measure(tqdm(ropes, desc=name, unit="rope", leave=False))}, options.out / DATA)
    tables = read(options.out / DATA)
    draw_to(options.out / IMAGE, draw, tables)
    (options.out / "mesh_rule.md").write_text(page(tables), encoding="utf-8")
    print(summary(tables))


if __name__ == "__main__":
    main()
