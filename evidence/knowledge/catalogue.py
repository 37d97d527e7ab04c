"""The tables of docs/howto/rope_data.md, from the catalogue itself."""

from __future__ import annotations

from evidence.rendering import folded, markdown, number
from rope_model import BEARINGS, CONSTRUCTIONS, Datum
from rope_model.catalogue import PROPERTIES


def catalogue() -> str:
    """Return ropes, bearings, and the source of every range."""
    ropes = []
    for name, construction in CONSTRUCTIONS.items():
        factors = construction.factors()
        ropes.append((f"`{name}`", construction.description, *(_range(factors[key]) for key in PROPERTIES)))
    head = [f"{name} / d^{kind.power}" if kind.power else name for name, kind in PROPERTIES.items()]
    bearings = [(f"`{name}`", *(_range(datum) for datum in data.values())) for name, data in BEARINGS.items()]
    sources = [(name, key, datum.status, datum.source) for name, key, datum in _all()]
    return "\n\n".join(
        (
            markdown(ropes, "construction", "", *(text.replace("_", " ") for text in head)),
            markdown(bearings, "bearing of the swivel", "running friction", "starting over running"),
            folded(markdown(sources, "of", "datum", "status", "source"), "Status and source of every range"),
        )
    )


def _range(datum: Datum) -> str:
    return f"{number(datum.low)} to {number(datum.high)}"


def _all() -> list[tuple[str, str, Datum]]:
    """Every source once, with the first entry that has it standing for all that share it."""
    found = dict[tuple[str, str, str], list[str]]()
    data = dict[tuple[str, str, str], Datum]()
    entries = {name: construction.factors() for name, construction in CONSTRUCTIONS.items()} | BEARINGS
    for name, facts in entries.items():
        for key, datum in facts.items():
            place = (key, str(datum.status), datum.source)
            found.setdefault(place, []).append(f"`{name}`")
            data[place] = datum
    return [(", ".join(names), place[0].replace("_", " "), data[place]) for place, names in found.items()]
