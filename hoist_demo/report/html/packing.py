"""Numbers as short text, and pictures of what was recorded along the rope.

Numbers are quantised to 16 or 8 bits, or are 32-bit floats, in base64. A packed array {"kind",
"lo", "hi", "data"} stands for lo + (hi - lo) q / top with integers q from 0 to top; the code above
top is NaN. assets/common.js holds the inverse.
"""

import base64
import math

import numpy as np

from hoist_demo.recording.time_series import Array, Recording

Packed = dict[str, str | float]
#: Largest integer that stands for a number, per kind; the next one is NaN.
CODES = {"u8": 254, "u16": 65534}
_LITTLE_ENDIAN = {"u8": "<u1", "u16": "<u2"}  #: Types of the packed integers.


def pack(values: Array, kind: str = "u16") -> Packed:
    """Values of any shape, flattened row by row.

    The error is half a quantum, (hi - lo) / top / 2.
    """
    flat = np.asarray(values, dtype=np.float64).ravel()
    finite = np.isfinite(flat)
    lo = 0.0
    hi = 0.0
    if finite.any():
        lo = float(np.min(flat[finite]))
        hi = float(np.max(flat[finite]))
    top = CODES[kind]
    codes = np.full(flat.shape, top + 1, dtype=np.float64)
    codes[finite] = 0.0
    if hi > lo:
        codes[finite] = np.rint((flat[finite] - lo) * (top / (hi - lo)))
    raw = codes.astype(_LITTLE_ENDIAN[kind]).tobytes()
    return {"kind": kind, "lo": lo, "hi": hi, "data": base64.b64encode(raw).decode("ascii")}


def pack_to(values: Array, resolution: float) -> Packed:
    """Pack as 16-bit integers if these resolve ``resolution``, else as 32-bit floats."""
    flat = np.asarray(values, dtype=np.float64).ravel()
    finite = flat[np.isfinite(flat)]
    if finite.size == 0 or float(np.ptp(finite)) <= resolution * CODES["u16"]:
        return pack(flat)
    raw = flat.astype("<f4").tobytes()
    return {"kind": "f32", "lo": 0.0, "hi": 0.0, "data": base64.b64encode(raw).decode("ascii")}


def thin(values: Array, limit: int) -> Array:
    """Thin to at most ``limit`` values (1-D), the lowest and highest of each interval, in order.

    Fewer stay.
    """
    if len(values) <= limit:
        return values
    width = interval(len(values), limit)
    count = math.ceil(len(values) / width)
    intervals = np.full((count, width), np.nan)
    intervals.ravel()[: len(values)] = values
    missing = np.isnan(intervals)
    lowest = np.where(missing, np.inf, intervals).argmin(axis=1)
    highest = np.where(missing, -np.inf, intervals).argmax(axis=1)
    places = np.sort(np.stack([lowest, highest], axis=1), axis=1)
    extremes: Array = np.take_along_axis(intervals, places, axis=1).ravel()
    return extremes


def thin_times(times: Array, limit: int) -> Array:
    """Return the instants of thin(): the first quarter and the third quarter of each interval."""
    if len(times) <= limit:
        return times
    width = interval(len(times), limit)
    starts = np.arange(0, len(times), width)[:, None]
    ends = np.minimum(starts + width, len(times)) - 1
    places = starts + np.array([0.25, 0.75]) * (ends - starts)
    return np.interp(places.ravel(), np.arange(len(times)), times)


def interval(count: int, limit: int) -> int:
    """Return the number of values that share a pair."""
    return math.ceil(count / (limit // 2))


def frames(count: int, limit: int) -> list[int]:
    """Return rows at even distances, at most ``limit``, the last one included."""
    stride = max(1, math.ceil((count - 1) / max(1, limit - 1)))
    rows = list(range(0, count, stride))
    if rows and rows[-1] < count - 1:
        rows.append(count - 1)
    return rows


#: Quantity, title, unit shown, and the factor that leads to it.
MAPS = (
    ("bending", "Bending stress along the rope", "MPa", 1e-6),
    ("torsion", "Torsional stress along the rope", "MPa", 1e-6),
    ("tension", "Tension along the rope", "kN", 1e-3),
)

MAX_COLUMNS = 240  #: Most instants in a picture.
ROPE_ROWS = 160  #: Places along the rope in a picture.
MISSING = (
    "The rope has no outputs {}, so these are not shown along it; export its FMU anew and wind "
    "again."
)


def along(recording: Recording, name: str) -> dict[str, object]:
    """Return pictures of quantities along a rope, and a note of those that were not recorded.

    ``name`` is that of one of several ropes.
    """
    rows = frames(len(recording.time), MAX_COLUMNS)
    curves = recording.shapes_at(rows)
    assert curves is not None
    # arc lengths of the points [m]
    positions = [
        np.append(0.0, np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1)))
        for curve in curves
    ]
    length = max(float(position[-1]) for position in positions)
    size = {
        "length": length,
        "rows": ROPE_ROWS,
        "columns": len(rows),
        "span": recording.time[[0, -1]].tolist(),
    }
    maps: list[dict[str, object]] = []
    missing: list[str] = []
    for quantity, title, unit, factor in MAPS:
        values = recording.along(quantity)
        if values is None:
            missing.append(f"shape.{quantity}")
            continue
        if bool(np.isnan(values).all()):  # the fidelity of the rope's model leaves it out
            continue
        picture = factor * over_length(values[rows], positions, length)
        entry = {
            "id": quantity,
            "title": f"{title}, {name}" if name else title,
            "unit": unit,
            "quiet": bool(np.ptp(picture) == 0.0),
            "values": pack(picture, "u8"),
        }
        maps.append(entry | size)
    note = ""
    if missing:
        note = MISSING.format(" and ".join(missing))
    return {"maps": maps, "note": note}


def over_length(values: Array, positions: list[Array], length: float) -> Array:
    """Return the largest value (frames, n) in each of ROPE_ROWS parts of the length.

    A loop may be within one part.
    """
    edges = np.linspace(0.0, length, ROPE_ROWS + 1)
    picture = np.full((ROPE_ROWS, len(values)), np.nan)
    for k, (column, position) in enumerate(zip(values, positions, strict=True)):
        if bool(np.isnan(column).all()):
            continue
        ends = np.interp(edges, position, column)
        picture[:, k] = np.maximum(ends[:-1], ends[1:])
        parts = np.minimum(np.searchsorted(edges, position, side="right") - 1, ROPE_ROWS - 1)
        np.maximum.at(picture[:, k], parts, column)
    return picture
