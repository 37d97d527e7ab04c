"""Wind seeded scenes in a shaft up to their first fouling and write docs/guards.md; some minutes on two processes."""

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

from . import jam
from .scenes import JUDGE, SET, draw
from .wind import COLUMNS, judge

PAGE = PAGES["guards"]
SCENES, PROCESSES = 200, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence.guards", description=__doc__)
    add_out(parser)
    parser.add_argument("--scenes", type=int, default=SCENES, metavar="N", help=f"of each seed ({SCENES})")
    options = parser.parse_args(arguments)
    samples = [sample for seed in (SET, JUDGE) for sample in draw(seed, options.scenes)]
    with ProcessPoolExecutor(min(PROCESSES, os.cpu_count() or 1)) as pool:
        rows = list(tqdm(pool.map(judge, samples), desc="guards", unit="winding", total=len(samples), leave=False))
    tables = {"windings": table(COLUMNS, rows), "jam": table(jam.COLUMNS, jam.wind_jam())}
    write(tables, options.out / "data" / PAGE.data)
    for path in publish(PAGE, options.out):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
