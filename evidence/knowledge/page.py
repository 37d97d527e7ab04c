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
    seen, unseen, more = inside(tables["coverage"]), inside(tables["unseen"]), tables["samples"]
    covered = [
        (
            name.replace("_", " "),
            f"{hits} of {told}",
            str(lucky),
            f"{hits_unseen} of {told_unseen}",
            str(lucky_unseen),
            number(reach),
            f"{more['inside'][k]:.0f} of {more['told'][k]:.0f}",
        )
        for k, ((name, told, hits, lucky, reach), (_, told_unseen, hits_unseen, lucky_unseen, _)) in enumerate(
            zip(seen, unseen, strict=True)
        )
    ]
    together = {
        name: tuple(sum(int(row[column]) for row in rows) for column in (2, 1, 3))
        for name, rows in (("seen", seen), ("unseen", unseen))
    }
    return render(
        "knowledge/identify.md.j2",
        {
            "example": rows,
            "candidates": left,
            "covered": covered,
            "sets": int(max(tables["coverage"]["set"])),
            "more": int(max(more["told"])),
            "together": together,
            **{str(name): float(value) for name, value in zip(facts["fact"], facts["value"], strict=True)},
        },
    )
