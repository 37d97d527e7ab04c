"""Compare rope_model with the discrete rod and write docs/reference_solver.md and its data (two minutes)."""

from __future__ import annotations

from tqdm import tqdm

from evidence.pages import PAGES, publish
from evidence.rendering import DOCS
from evidence.tables import write

from .cases import cases
from .page import comparisons


def main() -> None:
    """All cases."""
    write({"comparisons": comparisons(tqdm(cases(), leave=False))}, DOCS / "data" / "reference_solver")
    publish(PAGES["reference_solver"])


if __name__ == "__main__":
    main()
