"""All entries, by chapter."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec

from .entry import Entry

#: modules with ENTRIES, in the order of the page, and their headings
CHAPTERS = {
    "discretisation": "Elements and meshes",
    "integration": "Time integration",
    "frames": "Frame of the cross-section",
    "swivel": "Swivels",
    "motion": "Large motions and slack rope",
    "coupling": "Co-simulation",
}


def chapters() -> dict[str, tuple[Entry, ...]]:
    """Entries by heading."""
    found: dict[str, tuple[Entry, ...]] = {}
    for name, heading in CHAPTERS.items():
        if find_spec(f"{__package__}.{name}") is not None:
            found[heading] = import_module(f"{__package__}.{name}").ENTRIES
    return found


def entries() -> tuple[Entry, ...]:
    """All of them, one after another."""
    return tuple(entry for part in chapters().values() for entry in part)
