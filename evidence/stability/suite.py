"""All entries, by chapter."""

from __future__ import annotations

from importlib import import_module

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
    return {heading: import_module(f"{__package__}.{name}").ENTRIES for name, heading in CHAPTERS.items()}


def entries() -> tuple[Entry, ...]:
    """All of them, one after another."""
    return tuple(entry for part in chapters().values() for entry in part)
