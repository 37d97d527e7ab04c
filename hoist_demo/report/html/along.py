"""Stress and tension over the rope's length and time, from what was recorded at its points."""

from __future__ import annotations

import numpy as np

from hoist_demo.recording.time_series import Array, Recording
from hoist_demo.report.html import packing

#: Quantity, title, unit shown, and the factor that leads to it.
MAPS = (
    ("bending", "Bending stress along the rope", "MPa", 1e-6),
    ("torsion", "Torsional stress along the rope", "MPa", 1e-6),
    ("tension", "Tension along the rope", "kN", 1e-3),
)

MOST_COLUMNS, ROPE_ROWS = 240, 160  #: Size of each picture.

MISSING = "The rope has no outputs {}, so these are not shown along it; export its FMU anew and wind again."


def along(recording: Recording) -> dict[str, object]:
    """Pictures of what was recorded along a rope whose curve is known, and a note of what was not."""
    rows = packing.frames(len(recording.time), MOST_COLUMNS)
    places = [arc_length(curve) for row in rows if (curve := recording.shape_at(row)) is not None]
    length = max(float(place[-1]) for place in places)
    maps, missing = [], []
    for name, title, unit, factor in MAPS:
        values = recording.along(name)
        if values is None:
            missing.append(f"shape.{name}")
            continue
        if bool(np.isnan(values).all()):  # the fidelity of the rope's model leaves it out
            continue
        picture = factor * over_length(values[rows], places, length)
        kept = {"id": name, "title": title, "unit": unit, "quiet": bool(np.ptp(picture) == 0.0)}
        maps.append(kept | {"values": packing.pack(picture, "u8")})
    note = MISSING.format(" and ".join(missing)) if missing else ""
    return {"length": length, "rows": ROPE_ROWS, "columns": len(rows), "maps": maps, "note": note}


def arc_length(curve: Array) -> Array:
    """Length along a curve of shape (n, 3) from its first point [m]."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])


def over_length(values: Array, places: list[Array], length: float) -> Array:
    """The largest of the values (frames, n) in each of ROPE_ROWS equal parts of the length, (ROPE_ROWS, frames).

    The largest, because the loop of a long rope is shorter than such a part. A frame without values has none.
    """
    edges = np.linspace(0.0, length, ROPE_ROWS + 1)
    picture = np.full((ROPE_ROWS, len(values)), np.nan)
    for k, (column, place) in enumerate(zip(values, places, strict=True)):
        if bool(np.isnan(column).all()):
            continue
        ends = np.interp(edges, place, column)
        picture[:, k] = np.maximum(ends[:-1], ends[1:])
        parts = np.minimum(np.searchsorted(edges, place, side="right") - 1, ROPE_ROWS - 1)
        np.maximum.at(picture[:, k], parts, column)
    return picture
