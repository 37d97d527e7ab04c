"""Compare methods of time integration and write docs/integrators.md, its figure and data: ``make integrators``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from tqdm import tqdm

from evidence.options import add_out
from evidence.pages import PAGES, publish
from evidence.tables import write

from .measure import measure, scenes

PAGE = PAGES["integrators"]


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence.integrators", description=__doc__)
    add_out(parser)
    parser.add_argument("--scenes", type=int, metavar="N", help="the first ones only")
    options = parser.parse_args(arguments)
    tables = measure(tqdm(scenes()[: options.scenes], desc="integrators", unit="scene", leave=False))
    write(tables, options.out / "data" / PAGE.data)
    for path in publish(PAGE, options.out):
        print(path)


if __name__ == "__main__":
    main()
