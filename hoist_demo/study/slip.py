"""Warnings about the head ropes' hold on the sheave."""

from __future__ import annotations

import numpy as np

from hoist_demo.design.statics import AT_REST, MOVING
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.recording.incidents import ALIKE, held_in_spite, jams, slack_ropes
from hoist_demo.recording.time_series import Array, Recording

_GENTLER = f"accelerate more gently (winding.acceleration), or {ALIKE}"


def slip_warning(recording: Recording, hoist: Hoist, winding: Winding) -> str:
    """Return the warning that real head ropes slip, or have little friction left; "" for none."""
    if "drive.tension_ratio" not in recording:
        return ""
    ratio = recording["drive.tension_ratio"]
    margin = _margin_warning(recording.time, ratio, _normal_until(recording, winding), hoist)
    return (held_in_spite(recording, hoist.tension_ratio_limit) if hoist.lining is None else "") or margin


def _normal_until(recording: Recording, winding: Winding) -> float:
    """Time [s] of the first event that is no part of normal winding, or of the record's end."""
    events = [jam.t for jam in jams(recording)] + [slack.t for slack in slack_ropes(recording)]
    if winding.emergency_at is not None:
        events.append(float(recording.time[0]) + winding.emergency_at)
    return min(events, default=float(recording.time[-1]))


def _margin_warning(time: Array, ratio: Array, until: float, hoist: Hoist) -> str:
    """Return the warning that less friction is left than the rules ask for; the first sample is at rest."""
    largest = int(np.argmax(np.where(time <= until, ratio, 0.0)))
    for asked, k, words, cure in ((AT_REST, 0, "at rest", ALIKE), (MOVING, largest, "in normal winding", _GENTLER)):
        safety = hoist.slip_safety(float(ratio[k]))
        if safety < asked:
            return (
                f"the head ropes' slip safety {words} is {safety:.5g} at t = {time[k]:.5g} s (tension ratio "
                f"{ratio[k]:.5g}, limit {hoist.tension_ratio_limit:.5g}), and {asked:g} is "
                f"usually asked for: {cure}"
            )
    return ""
