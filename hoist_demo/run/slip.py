"""Slip safety of the head ropes on the sheave in each part of a trip, with its required value."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cosimulation.run_state import Result
from hoist_demo.design.statics import AT_REST, MOVING
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.recording.incidents import (
    BALANCE_SIDES,
    IN_SPITE,
    jams,
    slack_ropes,
    tension_ratios,
)
from hoist_demo.recording.time_series import Array, Recording

_GENTLER = f"accelerate more gently (winding.acceleration), or {BALANCE_SIDES}"
_SOFTER = (
    f"brake more gently (winding.emergency_deceleration, the hoist's brake), or {BALANCE_SIDES}"
)


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
        if not self.sufficient and float(number) == self.required:
            return f"just below {self.required:g}"
        return number

    @property
    def sufficient(self) -> bool:
        """True if the required safety is reached."""
        return self.safety >= self.required


_USUAL = "usual [assumed]"


class _Part(NamedTuple):
    """Part of a trip whose slip safety is judged."""

    when: str
    ratios: Array  # of the tensions (rows,)
    rows: NDArray[np.bool_]  # True within the part
    required: float  # safety
    rule: str  # origin of the requirement
    cure: str


def slip_safeties(result: Result, hoist: Hoist) -> list[SlipSafety]:
    """Judge the hold at rest, in normal winding, and from the first event that is no part of that.

    [] if not recorded.

    At rest counts the static ratio, without swing: where the trip begins, and where it ends without
    such an event.
    """
    recording = result.recording
    winding = result.winding
    if not recording.has("drive.tension_ratio", "drive.static_tension_ratio"):
        return []
    time = recording.time
    ratio = tension_ratios(recording, hoist.tension_ratio_limit)
    until, event = _normal_until(recording, winding)
    arrived = (time == time[-1]) & (result.completed and not event)
    parts = [
        _Part(
            "at rest",
            ratios=recording["drive.static_tension_ratio"],
            rows=(time == time[0]) | arrived,
            required=AT_REST,
            rule=_USUAL,
            cure=BALANCE_SIDES,
        ),
        _Part(
            "in normal winding",
            ratios=ratio,
            rows=time <= until,
            required=MOVING,
            rule=_USUAL,
            cure=_GENTLER,
        ),
        _Part(
            f"from {event} on",
            ratios=ratio,
            rows=time > until,
            required=1.0,
            rule="below it they slip",
            cure=BALANCE_SIDES if winding.emergency_at is None else _SOFTER,
        ),
    ]
    safeties = []
    for part in parts:
        if bool(part.rows.any()):
            k = int(np.argmax(np.where(part.rows, part.ratios, 0.0)))
            safety = hoist.slip_safety(float(part.ratios[k]))
            slips = safety < 1.0 and hoist.lining is None
            cure = IN_SPITE if slips else part.cure
            safeties.append(
                SlipSafety(part.when, safety, float(time[k]), part.required, part.rule, cure)
            )
    return safeties


def slip_warnings(result: Result, hoist: Hoist) -> list[str]:
    """List where the head ropes hold less well than is asked, and what cures that."""
    return [
        f"slip safety {one.when} is {one.text}, not {one.required:g}: {one.cure}"
        for one in slip_safeties(result, hoist)
        if not one.sufficient
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
