"""The source's evaluation with figures, data and verdicts: ``make reproduce``.

Runs everything (some ten minutes, progress on stderr) and writes docs/reproduction.md, its figures and its CSV files.
``python -m evidence.reproduction release`` runs only what is named, of MEASURES; ``draw`` runs nothing and makes
figures and page again from the CSV files as they are.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from evidence.drawing import draw_to
from evidence.tables import Tables, read, write

from . import costs, displacements, energies, frequencies, release, stresses, swing, timestep, windings
from .page import DATA, IMAGES, page
from .section import Section

DOCS = Path(__file__).resolve().parents[2] / "docs"
MEASURES: dict[str, Callable[[], Tables]] = {
    "frequencies": frequencies.measure,
    "windings": windings.measure,
    "costs": costs.measure,
    "timestep": timestep.measure,
    "release": release.measure,
}
SECTIONS: tuple[Section, ...] = tuple(
    module.SECTION for module in (frequencies, displacements, stresses, energies, costs, swing)
)


def main() -> None:
    """Measure what is asked for; then draw, and write the page, from the files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="name", help=f"{', '.join(MEASURES)} or draw (all)")
    names = parser.parse_args().names or list(MEASURES)
    if unknown := set(names) - {*MEASURES, "draw"}:
        parser.error(f"there is no {', '.join(sorted(unknown))}; choose of {', '.join(MEASURES)}, draw")
    for name in names:
        if name != "draw":
            write(MEASURES[name](), DOCS / DATA)
    tables = read(DOCS / DATA)
    for picture in (p for section in SECTIONS for p in section.pictures):
        draw_to(DOCS / IMAGES / f"{picture.name}.png", picture.draw, tables)
    (DOCS / "reproduction.md").write_text(page(SECTIONS, tables), encoding="utf-8")
    for section in SECTIONS:
        for claim in section.claims(tables):
            print(claim.verdict)


if __name__ == "__main__":
    main()
