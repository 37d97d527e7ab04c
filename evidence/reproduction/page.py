"""docs/reproduction.md from the tables."""

from __future__ import annotations

from collections.abc import Sequence

from evidence.tables import Tables
from hoist_demo.parameters import ASSUMED_DATA

from .section import Claim, Section

IMAGES, DATA = "images/reproduction", "data/reproduction"

HEAD = f"""# The source's evaluation, run anew

This page is written by `make reproduce`; edit the generator, `evidence/reproduction`, and not the page. It follows
the source's evaluation figure by figure. The source's tables are not available: what it states in words or numbers is
compared, not its curves. Only the lengths, Qb and Qc, the travel and speed, the release time and the observation
points are the source's. {ASSUMED_DATA}

Each claim is decided by one number, computed from the CSV files in docs/{DATA}, the same that the
figures are drawn from. Where the source gives words ("little", "a few") and no number, the bound is ours.
"""


def page(sections: Sequence[Section], tables: Tables) -> str:
    """The page, claims first."""
    claims = [section.claims(tables) for section in sections]
    parts = [HEAD, _summary(claims)]
    parts += [_section(k, s, c, tables) for k, (s, c) in enumerate(zip(sections, claims, strict=True), start=1)]
    return "\n".join(parts)


def _summary(claims: Sequence[Sequence[Claim]]) -> str:
    rows = ["| section | the source states | ours | number | asked | reproduced |", "|---|---|---|---|---|---|"]
    for k, group in enumerate(claims, start=1):
        rows += [
            f"| {k} | {c.source} | {c.measured.what} | {c.number} | {c.bound} | {'yes' if c.holds else '**no**'} |"
            for c in group
        ]
    every = [c for group in claims for c in group]
    lines = [f"{sum(c.holds for c in every)} of {len(every)} claims are reproduced.", "", *rows, ""]
    missed = [
        f"- {c.source}: {c.number}, because {c.because or 'of a cause we have not found'}."
        for c in every
        if not c.holds
    ]
    return "\n".join([*lines, "What is not reproduced, and why:", "", *missed, ""] if missed else lines)


def _section(number: int, section: Section, claims: Sequence[Claim], tables: Tables) -> str:
    pictures = "\n\n".join(f"![{p.alt}]({IMAGES}/{p.name}.png)" for p in section.pictures)
    verdicts = "\n".join(f"- {c.verdict}." for c in claims)
    data = ", ".join(f"[{name}.csv]({DATA}/{name}.csv)" for name in section.data)
    return (
        f"## {number}. {section.title}\n\n{section.scene}\n\n{pictures}\n\n{verdicts}\n\n{section.reading(tables)}\n\n"
        f"Data: {data}.\n"
    )
