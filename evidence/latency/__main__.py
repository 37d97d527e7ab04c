"""Measure the time of communication steps and write docs/latency.md, its figure and data: ``make latency``.

Some three minutes on a quiet machine, which benchmarks.latency says how to have.
"""

from __future__ import annotations

import argparse

from benchmarks.latency import ROUNDS
from evidence.options import add_out
from evidence.pages import PAGES, publish
from evidence.tables import write

from .tables import measure


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser("python -m evidence.latency", description=__doc__)
    parser.add_argument("--rounds", type=int, default=ROUNDS, metavar="N", help="times each run is made (%(default)s)")
    add_out(parser)
    options = parser.parse_args()
    write(measure(options.rounds), options.out / "data" / "latency")
    for path in publish(PAGES["latency"], options.out):
        print(path)


if __name__ == "__main__":
    main()
