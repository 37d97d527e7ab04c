"""docs/reproduction.md from the tables: the claims of all sections, and what each section's numbers are."""

from __future__ import annotations

from evidence.rendering import render
from evidence.tables import Tables
from hoist_demo.parameters import ASSUMED_DATA

from . import costs, displacements, energies, frequencies, stresses, swing
from .section import Section

SECTIONS: tuple[Section, ...] = tuple(
    module.SECTION for module in (frequencies, displacements, stresses, energies, costs, swing)
)
FIGURES = {picture.name: picture.draw for section in SECTIONS for picture in section.pictures}


def page(tables: Tables) -> str:
    """The page, claims first."""
    claims = [section.claims(tables) for section in SECTIONS]
    data = {
        "assumed": ASSUMED_DATA,
        "summary": [
            (str(k), c.source, c.measured.what, c.number, c.bound, "yes" if c.holds else "**no**")
            for k, group in enumerate(claims, start=1)
            for c in group
        ],
        "kept": sum(c.holds for group in claims for c in group),
        "missed": [c for group in claims for c in group if not c.holds],
        "sections": [
            {
                "key": section.key,
                "title": section.title,
                "pictures": section.pictures,
                "claims": group,
                "numbers": section.numbers(tables),
                "data": section.data,
            }
            for section, group in zip(SECTIONS, claims, strict=True)
        ],
    }
    return render("reproduction/reproduction.md.j2", data)
