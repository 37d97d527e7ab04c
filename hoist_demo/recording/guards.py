"""The guard of the rope's loop that tripped in a run, and what the rope did after that."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hoist_demo.recording.passages import BODIES
from hoist_demo.recording.time_series import Array, Recording
from rope_model import GUARD_CAUSES

GUARD_SIGNALS = frozenset({"guard.tripped", "guard.cause", "guard.time"})  #: Outputs of the rope that tell it.

GUARD_CODES = dict(enumerate(GUARD_CAUSES, start=1))  #: What `guard.cause` stands for.

AFTER = 10.0  #: Time after a trip, or a jam, over which it is told what happened [s].


class GuardTrip(NamedTuple):
    """Time and cause of a guard's trip."""

    t: float  # s
    code: int

    @property
    def cause(self) -> str:
        """Cause in a word."""
        return GUARD_CODES[self.code]


def guard_trip(recording: Recording) -> GuardTrip | None:
    """The trip of a recorded run; None where there was none."""
    if not recording.has(*GUARD_SIGNALS) or not recording["guard.tripped"].size or recording["guard.tripped"][-1] < 0.5:
        return None
    return GuardTrip(float(recording["guard.time"][-1]), int(recording["guard.cause"][-1]))


def told(recording: Recording) -> str:
    """A run's trip as the end of a sentence; "" for none."""
    trip = guard_trip(recording)
    return "" if trip is None else f"; its guard tripped at t = {trip.t:.4g} s ({trip.cause})"


def after(t: float, recording: Recording) -> list[tuple[str, float, str]]:
    """Quantity, value and unit of what the rope did at the utmost in the seconds after an instant t [s]."""
    within = (recording.time >= t) & (recording.time <= t + AFTER)
    if not bool(within.any()):
        return []

    def largest(values: Array) -> float:
        return float(np.max(np.abs(values)))

    asked = (
        (("loop.rise",), "largest distance of the loop from its quasi-static height", "m", largest),
        (("loop.sideways",), "largest distance of the loop from midway between the ends", "m", largest),
        (("loop.turns",), "largest turns of the legs about each other", "", largest),
        (tuple(f"clearance.{kind}" for kind in BODIES), "smallest clearance from a body", "m", np.min),
        (("left.swivel.torque", "right.swivel.torque"), "largest torque at a swivel", "N m", largest),
        (("left.fy", "right.fy"), "largest pull on a conveyance", "N", lambda pull: np.max(-pull)),
    )
    found = []
    for names, quantity, unit, extreme in asked:
        rows = [recording[name][within] for name in names if name in recording]
        values = np.concatenate([row[np.isfinite(row)] for row in rows]) if rows else np.array([])
        if values.size:
            found.append((quantity, float(extreme(values)), unit))
    return found
