"""Head ropes that slid on the sheave: since when, how far, how fast."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hoist_demo.recording.time_series import Recording

SLIP_SIGNALS = frozenset({"drive.slip", "drive.slip_speed"})  #: Signals that tell it.

ALIKE = "make the two sides more alike in weight"  #: What gives friction more room.


class Slip(NamedTuple):
    """All that the head ropes slid in a run."""

    t: float  # s, of the last sample before they slid
    way: float  # m, to and fro
    net: float  # m, of the ropes on the sheave, positive as its rotation
    speed: float  # m/s, largest
    duration: float  # s, in all
    last: float  # m/s, at the end: 0 where they hold again


def slip(recording: Recording) -> Slip | None:
    """None where they held."""
    if not recording.has(*SLIP_SIGNALS):
        return None
    way, time = recording["drive.slip"], recording.time
    slid = np.flatnonzero(np.diff(way))
    if not slid.size:
        return None
    return Slip(
        t=float(time[slid[0]]),
        way=float(np.sum(np.abs(np.diff(way)))),
        net=float(way[-1] - way[0]),
        speed=float(np.max(np.abs(recording["drive.slip_speed"]))),
        duration=float(np.sum(np.diff(time)[slid])),
        last=float(recording["drive.slip_speed"][-1]),
    )


def largest_ratio(recording: Recording, limit: float) -> float:
    """Return the largest ratio of the head ropes' tensions [-], at least the limit if they slid between two samples."""
    largest = float(np.max(recording["drive.tension_ratio"]))
    return largest if slip(recording) is None else max(largest, limit)


def told_of_slip(recording: Recording) -> str:
    """Return the slip as the end of a sentence; "" if they held."""
    if (slid := slip(recording)) is None:
        return ""
    return (
        f"; the head ropes slipped {slid.way:.3g} m on the sheave from t = {slid.t:.4g} s on, at up to "
        f"{slid.speed:.3g} m/s" + (f", and still slip at {abs(slid.last):.3g} m/s when it ends" if slid.last else "")
    )


def held_in_spite(recording: Recording, limit: float) -> str:
    """Return when real head ropes would have slipped, if the model holds them at this tension ratio; "" for never."""
    if "drive.tension_ratio" not in recording:
        return ""
    ratio = recording["drive.tension_ratio"]
    beyond = ratio > limit
    if not bool(beyond.any()):
        return ""
    return (
        f"the head ropes would slip at t = {recording.time[beyond][0]:.5g} s (tension ratio up to {np.max(ratio):.5g}, "
        f"limit {limit:.5g}); the model lets them hold, so nothing after that instant is a prediction. Let them slip "
        "(hoist.lining.sliding = 0.8), brake or accelerate more gently (winding.emergency_deceleration, "
        f"winding.acceleration), or {ALIKE}"
    )
