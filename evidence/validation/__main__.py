"""Hold the model against measurement, theory and CableDyn, write docs/validation.md.  Exits with 1 where one misses.

Some three minutes; needs ``pip install balance-rope[validation]``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from evidence.options import add_out
from evidence.pages import PAGES, publish
from evidence.tables import write

from .measure import measure
from .row import from_table

PAGE = PAGES["validation"]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence.validation", description=__doc__)
    add_out(parser)
    options = parser.parse_args(arguments)
    tables = measure()
    found = from_table(tables["rows"])
    for row in found:
        print(f"{'MISSES' if row.misses else 'shown ' if row.shown else 'holds '} {row.id} {row.what} {row.value:.3g}")
    write(tables, options.out / "data" / PAGE.data)
    for path in publish(PAGE, options.out):
        print(path)
    return int(any(row.misses for row in found))


if __name__ == "__main__":
    sys.exit(main())
