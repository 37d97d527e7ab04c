"""One trip of a variant, the rest after it, and what the rope strikes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.kinematic import ends_at
from hoist_demo.control.trajectory import s_curve
from rope_model import BalanceRope, balance_rope

from .scenes import TRIP, Variant

#: s: recorded, communication step, and what a force is averaged over
END, INTERVAL, MEAN = 110.0, 0.01, 0.1
#: a row of the course is the mean of so many
EVERY = 10
BEYOND = ("lining", "conveyance", "head_ropes", "divider")
COLUMNS = (
    *("variant", "elements", "guard at [s]", "turns at rest", "turned by [turns]", "yawed by [rad]", "crossings"),
    *(f"{kind}, {what}" for kind in BEYOND for what in ("first at [s]", "largest [N]", "mean [N]")),
    *("nearest lining [m]", "nearest conveyance [m]", "nearest head_ropes [m]", "residual / work"),
)
COURSE = ("variant", "time [s]", "turns", "yaw [rad]", *(f"{kind}, mean [N]" for kind in BEYOND))
_SIGNALS = ("loop.turns", "loop.yaw", *(f"contact.{kind}" for kind in BEYOND))


@dataclass(frozen=True)
class Trip:
    """A row of COLUMNS, and rows of COURSE."""

    row: tuple[Any, ...]
    course: list[tuple[Any, ...]]


def wind(variant: Variant) -> Trip:
    """The trip, the hoist taking no notice of a guard: that of the page trips when it stands already."""
    trip, rope = s_curve(TRIP), balance_rope(variant.scene)
    status = rope.initialize(0.0, *ends_at(trip, TRIP.travel, 0.0))
    read, found = rope.reader(_SIGNALS), []
    for k in range(1, round(END / INTERVAL) + 1):
        if not status.valid:
            raise RuntimeError(f"{variant.name}: {status.message}")
        status = rope.advance_to(k * INTERVAL, *ends_at(trip, TRIP.travel, k * INTERVAL))
        found.append(np.append(k * INTERVAL, read()))
    rows = np.array(found)
    course = rows.reshape(-1, EVERY, rows.shape[1]).mean(axis=1)
    return Trip(_row(variant, rope, rows), [(variant.name, *row) for row in course.tolist()])


def _row(variant: Variant, rope: BalanceRope, rows: NDArray[np.float64]) -> tuple[Any, ...]:
    signals, window = rope.signals(), np.full(round(MEAN / INTERVAL), INTERVAL / MEAN)
    blows: list[float] = []
    for k, kind in enumerate(BEYOND):
        force = rows[:, 3 + k]
        first = rows[np.argmax(force > 0), 0] if force.any() else np.nan
        touched = signals[f"nearest.{kind}.touched_at"] if force.any() else np.nan
        blows += [touched or first, force.max(), np.convolve(force, window, "valid").max()]
    tripped = signals["guard.time"] if signals["guard.tripped"] else np.nan
    return (
        *(variant.name, rope.elements, tripped, abs(rows[0, 1]), np.abs(rows[:, 1]).max(), np.abs(rows[:, 2]).max()),
        signals["loop.crossings"],
        *blows,
        *(signals[f"nearest.{kind}.clearance"] for kind in BEYOND[:3]),
        signals["energy.residual"] / signals["energy.work_ends"],
    )
