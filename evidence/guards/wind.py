"""A winding up to its first fouling, and how far each quantity that a guard can watch has gone by then.

A fouling is a rope that touches a body of the shaft, or a loop that is half a turn about the legs' own axis.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.kinematic import ends_at
from hoist_demo.control.trajectory import s_curve
from rope_model import BODIES, GUARD_CAUSES, balance_rope

from .scenes import Sample

#: s: recorded after the trip, communication step, and how often the quantities are looked at
SETTLE, INTERVAL, EVERY = 10.0, 0.02, 0.1
HALF_A_TURN = 0.5
#: s: what a hoist needs to stop, about
LEAD = 3.0
QUANTITIES = GUARD_CAUSES
CLEARANCE = QUANTITIES.index("clearance")
COLUMNS = (
    *("seed", "scene", "length [m]", "coupling", "swivels", "stop", "divider", "speed [m/s]"),
    *("outcome", "body", "fouled at [s]"),
    *(f"{name}, at rest" for name in QUANTITIES),
    *(f"{name}, peak" for name in QUANTITIES),
    *(f"{name}, peak {LEAD:g} s before" for name in QUANTITIES),
    "failure",
)
_SIGNALS = (
    *("loop.rise", "loop.sideways", "loop.turns", "left.swivel.torque", "right.swivel.torque"),
    *(f"clearance.{kind}" for kind in BODIES),
)


def record(sample: Sample) -> tuple[NDArray[np.float64], str]:
    """Rows of time and _SIGNALS up to the first fouling or the end, and why the rope could not go on."""
    trip, rope = s_curve(sample.trip), balance_rope(sample.scene)
    status = rope.initialize(0.0, *ends_at(trip, sample.trip.travel, 0.0))
    if not status.valid:
        return np.zeros((0, 1 + len(_SIGNALS))), status.message
    read, rows, often = rope.reader(_SIGNALS), [], round(EVERY / INTERVAL)
    rows.append(np.append(0.0, read()))
    for k in range(1, round((trip.duration + SETTLE) / INTERVAL) + 1):
        if _fouled(rows[-1]):
            break
        status = rope.advance_to(k * INTERVAL, *ends_at(trip, sample.trip.travel, k * INTERVAL))
        if not status.valid:
            return np.array(rows), status.message
        if k % often == 0:
            rows.append(np.append(k * INTERVAL, read()))
    return np.array(rows), ""


def judge(sample: Sample) -> tuple[Any, ...]:
    """A row of COLUMNS."""
    rows, failure = record(sample)
    rope, scene = sample.scene.rope, sample.scene
    outcome, body, at = "failed", "", np.nan
    rest = peaks = before = (np.nan,) * len(QUANTITIES)
    if len(rows):
        fouled = _fouled(rows[-1])
        at = rows[-1, 0] if fouled else np.nan
        outcome = ("fouled at rest" if len(rows) == 1 else "fouled") if fouled else "failed" if failure else "healthy"
        body = _body(rows[-1]) if fouled else ""
        rest, peaks = _peaks(rows[:1]), _peaks(rows)
        early = rows[rows[:, 0] <= rows[-1, 0] - LEAD] if fouled else rows
        before = _peaks(early) if len(early) else rest
    return (
        *(sample.seed, sample.number, rope.length, sample.coupling, "seized" if sample.is_seized else "turning"),
        *(sample.trip.emergency_at is not None, scene.shaft.divider_1.size > 0, s_curve(sample.trip).peak_speed),
        *(outcome, body, at, *rest, *peaks, *before, failure),
    )


def _fouled(row: NDArray[np.float64]) -> bool:
    return bool(row[6:].min() <= 0.0 or abs(row[3]) >= HALF_A_TURN)


def _body(row: NDArray[np.float64]) -> str:
    kind = int(np.argmin(row[6:]))
    return tuple(BODIES)[kind] if row[6 + kind] <= 0.0 else "itself, half a turn"


def _peaks(rows: NDArray[np.float64]) -> tuple[float, ...]:
    """Of rise, window, clearance (the least), turns and torque."""
    largest = np.abs(rows).max(axis=0)
    found = rows[:, 1].max(), largest[2], rows[:, 6:].min(), largest[3], largest[4:6].max()
    return tuple(map(float, found))
