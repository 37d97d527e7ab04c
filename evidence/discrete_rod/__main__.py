"""Compare rope_model with the discrete rod and write docs/reference_solver.md and its data (two minutes)."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from tqdm import tqdm

from evidence.options import add_out
from evidence.pages import PAGES, publish
from evidence.tables import write

from .cases import cases
from .page import comparisons

PAGE = PAGES["reference_solver"]


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser("python -m evidence.discrete_rod", description=__doc__)
    add_out(parser)
    options = parser.parse_args(arguments)
    write({"comparisons": comparisons(tqdm(cases(), leave=False))}, options.out / "data" / PAGE.data)
    for path in publish(PAGE, options.out):
        print(path)


if __name__ == "__main__":
    main()
