"""Measure what docs/howto/rope_data.md quotes anew: ``python -m evidence.knowledge [identify uncertain]``."""

from __future__ import annotations

import argparse

from evidence.knowledge.coverage import COUNTED, MORE_SETS, SETS, UNSEEN, cover, example, inside, of_samples, plan
from evidence.knowledge.worked import measure
from evidence.rendering import DOCS
from evidence.tables import Tables, table, write


def main() -> None:
    """Measure and record."""
    parser = argparse.ArgumentParser("python -m evidence.knowledge", description=__doc__)
    parser.add_argument("parts", nargs="*", choices=("identify", "uncertain", []), default=[], help="which (both)")
    for name in parser.parse_args().parts or ("identify", "uncertain"):
        tables = _identify() if name == "identify" else measure()
        write(tables, DOCS / "data" / ("knowledge" if name == "identify" else "uncertain"))


def _identify() -> Tables:
    measured = plan()
    return {
        "coverage": cover(measured),
        "unseen": cover(measured, SETS, UNSEEN),
        "samples": table(COUNTED, inside(cover(of_samples(measured), MORE_SETS))),
        **example(measured),
    }


if __name__ == "__main__":
    main()
