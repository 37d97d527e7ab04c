"""Measure the schemes and write docs/coupling.md with figures and data: ``make coupling``."""

from __future__ import annotations

import argparse

from evidence.pages import PAGES, publish
from evidence.rendering import DOCS
from evidence.tables import write

from .tables import TABLES, measure


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser("python -m evidence.coupling", description=__doc__)
    parser.add_argument("--only", choices=TABLES, metavar="TABLE", help="measure one table anew and keep the rest")
    write(measure(parser.parse_args().only), DOCS / "data" / "coupling")
    for path in publish(PAGES["coupling"]):
        print(path)


if __name__ == "__main__":
    main()
