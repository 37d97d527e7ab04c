"""Prints rope_model beside the discrete rod and puts the tables into docs/reference_solver.md (two minutes)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from tqdm import tqdm

from .cases import Case, Comparison, cases

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference_solver.md"
BEGIN, END = "<!-- tables -->", "<!-- /tables -->"


def row(name: str, c: Comparison) -> str:
    """Values, of a history where it is largest, and differences, of a history the largest."""
    at = np.unravel_index(int(np.argmax(np.abs(c.limit))), c.limit.shape)
    values = [f"{x[at]:.6g}" for x in (*c.ours, *c.rod, c.limit)]
    differences = [f"{x:.1e}" for x in (*c.differences, c.acceptance)]
    verdict = "yes" if c.differences[-1] <= c.acceptance else "NO"
    return f"| {' | '.join([name, *values, *differences, f'{c.order:.2f}', verdict])} |"


def table(case: Case) -> str:
    """A case in Markdown."""
    head = ["", *(f"ours, {n}" for n in case.ours_on), *(f"rod, {n}" for n in case.rod_on), "rod, limit"]
    head += [f"difference, {n}" for n in case.ours_on] + ["accepted", "rod's order", "agrees"]
    rows = [row(name, c) for name, c in case.compare().items()]
    return "\n".join([f"**{case.name}**", "", f"| {' | '.join(head)} |", "|---" * len(head) + "|", *rows, ""])


def main() -> None:
    """All cases."""
    text = "\n".join(table(case) for case in tqdm(cases(), leave=False))
    print(text)
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    PAGE.write_text(f"{before}{BEGIN}\n{text}{END}{rest.partition(END)[2]}", encoding="utf-8")


if __name__ == "__main__":
    main()
