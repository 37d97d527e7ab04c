"""The source's evaluation with figures, data and verdicts: ``make reproduce``.

Runs everything (some ten minutes, progress on stderr) and writes docs/reproduction.md, its figures and its CSV files.
``python -m evidence.reproduction release`` runs only what is named, of MEASURES, and keeps the other files.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

from evidence.pages import PAGES, publish
from evidence.rendering import DOCS
from evidence.tables import Tables, read, write

from . import costs, frequencies, release, timestep, windings
from .page import SECTIONS

DATA = DOCS / "data" / "reproduction"
MEASURES: dict[str, Callable[[], Tables]] = {
    "frequencies": frequencies.measure,
    "windings": windings.measure,
    "costs": costs.measure,
    "timestep": timestep.measure,
    "release": release.measure,
}


def main() -> None:
    """Measure what is asked for; then draw, and write the page, from the files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="name", help=f"{', '.join(MEASURES)} (all)")
    names = parser.parse_args().names or list(MEASURES)
    if unknown := set(names) - set(MEASURES):
        parser.error(f"there is no {', '.join(sorted(unknown))}; choose of {', '.join(MEASURES)}")
    for name in names:
        write(MEASURES[name](), DATA)
    publish(PAGES["reproduction"])
    tables = read(DATA)
    for section in SECTIONS:
        for claim in section.claims(tables):
            print(claim.verdict)


if __name__ == "__main__":
    main()
