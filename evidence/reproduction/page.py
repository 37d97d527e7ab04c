"""docs/reproduction.md from the tables: the claims of all sections, and two figures."""

from evidence.rendering import render, with_unit
from evidence.reproduction import costs, frequencies, release, winding_claims
from evidence.reproduction.claim import Claim, Section
from evidence.reproduction.windings import ROUNDS
from evidence.tables import Tables
from hoist_demo.parameters import ASSUMED_DATA

SECTIONS: tuple[Section, ...] = (
    frequencies.SECTION,
    *winding_claims.SECTIONS,
    costs.SECTION,
    release.SECTION,
)
FIGURES = {"frequencies": frequencies.draw, "release": release.draw}


def page(tables: Tables) -> str:
    """Return the page, claims first."""
    claims = [("" if k else s.title, c) for s in SECTIONS for k, c in enumerate(s.claims(tables))]
    reasons = dict.fromkeys(c.because for _, c in claims if not c.measured.holds)
    data = {
        "assumed": ASSUMED_DATA,
        "rounds": ROUNDS,
        "summary": [
            (
                title,
                c.source,
                c.measured.what,
                _value(c),
                _bound(c),
                "yes" if c.measured.holds else "**no**",
            )
            for title, c in claims
        ],
        "kept": sum(c.measured.holds for _, c in claims),
        "missed": [
            (
                [
                    f"{c.source} ({_value(c)})"
                    for _, c in claims
                    if c.because == why and not c.measured.holds
                ],
                why,
            )
            for why in reasons
        ],
        "data": [name for section in SECTIONS for name in section.data],
    }
    return render("reproduction/reproduction.md.j2", data)


def _value(c: Claim) -> str:
    return with_unit(c.measured.value, c.measured.unit)


def _bound(c: Claim) -> str:
    return f"{'below' if c.measured.relation == '<' else 'above'} {with_unit(c.measured.bound, c.measured.unit)}"
