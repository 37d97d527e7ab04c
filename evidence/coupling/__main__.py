"""``python -m evidence.coupling [--draw]``: measure, write the tables, then draw and write everything from them."""

from __future__ import annotations

import argparse
from pathlib import Path

from evidence.drawing import draw_to
from evidence.tables import read, write

from .figures import FIGURES
from .page import page

DATA, IMAGES = Path("data") / "coupling", Path("images") / "coupling"


def publish(out: Path) -> list[Path]:
    """Figures and page from the data that is there."""
    tables = read(out / DATA)
    for name, draw in FIGURES.items():
        draw_to(out / IMAGES / f"{name}.png", draw, tables)
    (out / "coupling.md").write_text(page(tables), encoding="utf-8")
    return [out / "coupling.md", *(out / IMAGES / f"{name}.png" for name in FIGURES), *sorted((out / DATA).iterdir())]


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser("python -m evidence.coupling", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs"), metavar="DIR", help="where to (%(default)s)")
    parser.add_argument("--only", metavar="TABLE", help="measure one table anew and keep the rest; draw: none")
    options = parser.parse_args()
    if options.only != "draw":
        # the hoist and the rope are needed only here
        from .tables import measure

        write(measure(options.only), options.out / DATA)
    for path in publish(options.out):
        print(path)


if __name__ == "__main__":
    main()
