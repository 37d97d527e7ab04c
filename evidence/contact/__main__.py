"""Check contact against what is exact and write docs/contact.md; three minutes.  Exits with 1 where a check misses."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from evidence.options import add_out
from evidence.pages import PAGES, publish
from evidence.tables import write

from .brushes import brushes_table
from .checks import checks, elastica_table
from .page import as_table
from .plectoneme import plectoneme_table
from .slack_rod import slack_table

PAGE = PAGES["contact"]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence.contact", description=__doc__)
    add_out(parser)
    options = parser.parse_args(arguments)
    found = list(checks())
    for case, m in found:
        print(f"{'holds ' if m.holds else 'MISSES'} {case}: {m.what} {m.value:.3g} {m.relation} {m.bound:g}")
    write(
        {
            "checks": as_table(found),
            "slack": slack_table(),
            "elastica": elastica_table(),
            "plectoneme": plectoneme_table(),
            "brushes": brushes_table(),
        },
        options.out / "data" / PAGE.data,
    )
    for path in publish(PAGE, options.out):
        print(path)
    return int(not all(m.holds for _, m in found))


if __name__ == "__main__":
    sys.exit(main())
