"""Run all entries, by chapter; takes some minutes."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from tqdm import tqdm

from evidence.claims import Measurement
from evidence.stability import discretisation, frames, motion, swivel
from evidence.stability.entry import Entry
from evidence.tables import Tables, table

CHAPTERS: dict[str, tuple[Entry, ...]] = {
    "Elements and meshes": discretisation.ENTRIES,
    "Frame of the cross-section": frames.ENTRIES,
    "Swivels": swivel.ENTRIES,
    "Time integration in large motions": motion.ENTRIES,
}
CLAIMS = ("scene", "side", "what", "value", "unit", "relation", "bound")


def tables() -> Tables:
    """Measure the claims of every entry, and the curves that the page draws."""
    claims, curves = [], {}
    for entry in tqdm([e for part in CHAPTERS.values() for e in part], unit="entry", leave=False):
        found = entry.measure()
        for side, group in found.sides.items():
            claims += [(entry.key, side, m.what, m.value, m.unit, m.relation, m.bound) for m in group]
        if found.curves is not None:
            curves[entry.key] = found.curves
    return {"claims": table(CLAIMS, claims), **curves}


def missed(recorded: Tables) -> Iterator[str]:
    """Yield the claims that do not hold."""
    for scene, side, *claim in zip(*(recorded["claims"][name].tolist() for name in CLAIMS), strict=True):
        if not Measurement(*claim).holds:
            yield f"{scene}, {side}: {claim[0]}"


MEASURES: dict[str, Callable[[], Tables]] = {"entries": tables}
