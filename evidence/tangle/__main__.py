"""Wind a rope of 690 m in its shaft, from free to seized swivels, and write docs/tangle.md; two minutes."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor

from tqdm import tqdm

from evidence.options import add_out
from evidence.pages import PAGES, publish
from evidence.tables import table, write

from .scenes import MESHES, VARIANTS
from .wind import COLUMNS, COURSE, wind

PAGE = PAGES["tangle"]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence.tangle", description=__doc__)
    add_out(parser)
    options = parser.parse_args(arguments)
    variants = (*VARIANTS, *MESHES[1:])
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        trips = list(tqdm(pool.map(wind, variants), desc="tangle", unit="trip", total=len(variants), leave=False))
    course = [row for trip in trips for row in trip.course]
    found = {"trips": table(COLUMNS, [trip.row for trip in trips]), "course": table(COURSE, course)}
    write(found, options.out / "data" / PAGE.data)
    for path in publish(PAGE, options.out):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
