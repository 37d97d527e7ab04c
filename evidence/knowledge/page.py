"""What docs/identify.md says, from the recorded data."""

from __future__ import annotations

from evidence.knowledge.coverage import inside
from evidence.rendering import number, render
from evidence.tables import Tables


def page(tables: Tables) -> str:
    """The whole page."""
    example, facts = tables["example"], tables["facts"]
    names = [str(name).replace("_", " ") for name in example["property"]]
    rows = [
        (name, *(number(example[column][k], ".4g") for column in ("low", "high", "true", "found", "from", "to")))
        for k, name in enumerate(names)
    ]
    candidates = tables["candidates"]
    left = [(str(c), f"{1e3 * e:.3g} mm") for c, e in zip(candidates["measurement"], candidates["error"], strict=True)]
    found, more = inside(tables["coverage"]), tables["samples"]
    covered = [
        (
            name.replace("_", " "),
            f"{hits} of {told}",
            number(reach),
            f"{more['inside'][k]:.0f} of {more['told'][k]:.0f}",
        )
        for k, (name, told, hits, reach) in enumerate(found)
    ]
    return render(
        "knowledge/identify.md.j2",
        {
            "example": rows,
            "candidates": left,
            "covered": covered,
            "sets": int(max(tables["coverage"]["set"])),
            "more": int(max(more["told"])),
            "all_told": sum(told for _, told, _, _ in found),
            "all_hits": sum(hits for _, _, hits, _ in found),
            **{str(name): float(value) for name, value in zip(facts["fact"], facts["value"], strict=True)},
        },
    )
