"""Measure what the constants of the 'auto' mesh rest on, and write docs/mesh_rule.md with its figure; eight minutes."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from tqdm import tqdm

from evidence.options import add_out
from evidence.pages import PAGES, publish
from evidence.tables import write

from . import statics, trips
from .scenes import FIT, JUDGE, draw

PAGE = PAGES["mesh_rule"]
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
    add_out(parser)
    parser.add_argument("--only", choices=[*TABLES], help="measure one table anew")
    parser.add_argument("--ropes", type=int, metavar="N", help="fewer or more ropes than the page's")
    options = parser.parse_args(arguments)
    for name, (measure, seed, number) in TABLES.items():
        if options.only in (None, name):
            ropes = list(draw(seed, options.ropes or number))
            write({name: measure(tqdm(ropes, desc=name, unit="rope", leave=False))}, options.out / "data" / PAGE.data)
    for path in publish(PAGE, options.out):
        print(path)


if __name__ == "__main__":
    main()
