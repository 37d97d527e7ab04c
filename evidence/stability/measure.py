"""Run all entries, by chapter; takes some minutes."""

from tqdm import tqdm

from evidence.claims import as_table
from evidence.stability import discretisation, frames, motion, swivel
from evidence.stability.entry import Entry
from evidence.tables import Measures, Tables

CHAPTERS: dict[str, tuple[Entry, ...]] = {
    "Elements and meshes": discretisation.ENTRIES,
    "Frame of the cross-section": frames.ENTRIES,
    "Swivels": swivel.ENTRIES,
    "Time integration in large motions": motion.ENTRIES,
}


def tables() -> Tables:
    """Measure the claims of every entry, and the curves that the page draws."""
    found = []
    curves = {}
    for entry in tqdm([e for part in CHAPTERS.values() for e in part], unit="entry", leave=False):
        finding = entry.measure()
        for side in ("counterexample", "ours"):
            found += [((entry.key, side), m) for m in getattr(finding, side)]
        if finding.curves is not None:
            curves[entry.key] = finding.curves
    return {"claims": as_table(("scene", "side"), found), **curves}


MEASURES: Measures = {"entries": tables}
