"""Wind trips with the motions that tables and sensors send; write the table in docs/howto/motion.md.

Five minutes on two cores.  Exits with 1 where a target is missed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from evidence.options import add_out
from evidence.pages import BLOCKS, fill
from evidence.tables import table, write

from .block import claims
from .wind import COLUMNS, TRIPS, rows

BLOCK = BLOCKS["signals"]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line; 1 where a target is missed."""
    parser = argparse.ArgumentParser("python -m evidence.signals", description=__doc__)
    add_out(parser)
    options = parser.parse_args(arguments)
    jobs = [(trip, step) for trip in TRIPS for step in trip.steps]
    with ProcessPoolExecutor() as pool:
        found = [x for part in pool.map(_rows, jobs) for x in part]
    tables = {"signals": table(COLUMNS, found)}
    write(tables, options.out / "data" / BLOCK.data)
    print(fill(BLOCK, options.out))
    missed = [claim for claim in claims(tables) if not claim.holds]
    for claim in missed:
        print(f"missed: {claim.what} is {claim.value:.3g}, wanted {claim.relation} {claim.bound:.3g}", file=sys.stderr)
    return int(bool(missed))


def _rows(job: tuple[Any, float]) -> list[tuple[Any, ...]]:
    return list(rows(*job))


if __name__ == "__main__":
    sys.exit(main())
