"""Slip safety of the head ropes on the sheave in each part of a trip, with its required value."""

from typing import NamedTuple

import numpy as np

from hoist_demo.cosimulation.run_state import Result
from hoist_demo.design.statics import AT_REST, MOVING
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.recording.incidents import ALIKE, IN_SPITE, jams, slack_ropes, tension_ratios
from hoist_demo.recording.time_series import Recording

_GENTLER = f"accelerate more gently (winding.acceleration), or {ALIKE}"
_SOFTER = f"brake more gently (winding.emergency_deceleration, the hoist's brake), or {ALIKE}"


class SlipSafety(NamedTuple):
    """Smallest slip safety in a part of a trip, beside the required one."""

    when: str
    safety: float
    t: float  # s
    required: float
    rule: str  # origin of the requirement
    cure: str

    @property
    def text(self) -> str:
        """Return the number, with words where its digits would be those of what is asked for."""
        number = f"{self.safety:.2f}"
        return (
            f"just below {self.required:g}"
            if not self.enough and float(number) == self.required
            else number
        )

    @property
    def enough(self) -> bool:
        """True if the required safety is reached."""
        return self.safety >= self.required


def slip_safeties(result: Result, hoist: Hoist) -> list[SlipSafety]:
    """Judge the hold at rest, in normal winding, and from the first event that is no part of that.

    [] if not recorded.

    At rest counts the static ratio, without swing: where the trip begins, and where it ends without
    such an event.
    """
    recording, winding = result.recording, result.winding
    if not recording.has("drive.tension_ratio", "drive.static_tension_ratio"):
        return []
    time, ratio = recording.time, tension_ratios(recording, hoist.tension_ratio_limit)
    static = recording["drive.static_tension_ratio"]
    until, event = _normal_until(recording, winding)
    usual, softer = "usual [assumed]", ALIKE if winding.emergency_at is None else _SOFTER
    arrived = (time == time[-1]) & (result.completed and not event)
    parts = [
        ("at rest", static, (time == time[0]) | arrived, AT_REST, usual, ALIKE),
        ("in normal winding", ratio, time <= until, MOVING, usual, _GENTLER),
        (f"from {event} on", ratio, time > until, 1.0, "below it they slip", softer),
    ]
    safeties = []
    for when, ratios, rows, required, rule, remedy in parts:
        if bool(rows.any()):
            k = int(np.argmax(np.where(rows, ratios, 0.0)))
            safety = hoist.slip_safety(float(ratios[k]))
            cure = IN_SPITE if safety < 1.0 and hoist.lining is None else remedy
            safeties.append(SlipSafety(when, safety, float(time[k]), required, rule, cure))
    return safeties


def slip_warnings(result: Result, hoist: Hoist) -> list[str]:
    """List where the head ropes hold less well than is asked, and what cures that."""
    return [
        f"slip safety {one.when} is {one.text}, not {one.required:g}: {one.cure}"
        for one in slip_safeties(result, hoist)
        if not one.enough
    ]


def _normal_until(recording: Recording, winding: Winding) -> tuple[float, str]:
    """Return time [s] and name of the first event that is no part of normal winding.

    Or the record's end.
    """
    events = [(jam.t, "the jam") for jam in jams(recording)]
    events += [(slack.t, "slack head ropes") for slack in slack_ropes(recording)]
    if winding.emergency_at is not None:
        events.append((float(recording.time[0]) + winding.emergency_at, "the emergency stop"))
    return min(events, default=(float(recording.time[-1]), ""))
