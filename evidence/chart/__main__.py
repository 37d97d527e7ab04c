"""Wind the 120 m rope with many meshes, steps and models, and chart error over processor time; some ten minutes.

Writes chart.md, images/chart and data/chart in --out, and the table of levels in the README beside it.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from evidence.options import add_out

from .command import run

DOCS, QUICK = Path("docs"), Path("out") / "chart"


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence.chart", description=__doc__)
    add_out(parser, None, f"{DOCS}; with --quick {QUICK}")
    parser.add_argument("--quick", action="store_true", help="a few points on 1 m of travel: a check, not a result")
    parser.add_argument("--only", metavar="FAMILY", help="measure one family, or depth, anew and keep the rest")
    options = parser.parse_args(arguments)
    for path in run(options.out or (QUICK if options.quick else DOCS), options.only, options.quick):
        print(path)


if __name__ == "__main__":
    main()
