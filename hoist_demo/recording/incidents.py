"""Causes that stop a run or should have: guards, jams, slack head ropes and slip."""

from operator import attrgetter
from typing import NamedTuple

import numpy as np

from hoist_demo.recording.time_series import Array, Recording
from rope_model import GUARD_CAUSES

SIDES = ("left", "right")


class JamEvent(NamedTuple):
    """A conveyance that caught in its guides."""

    side: str
    t: float  # s, of the first sample that shows it
    height: float  # m, of the suspension there
    stopping_distance: float | None  # m, from there to where it first stood still; None: it went through
    deceleration: float  # m/s^2, largest change of speed, until then


class Stop(NamedTuple):
    """An emergency stop of one conveyance, until it first stands still."""

    side: str
    stopping_distance: float  # m, its own
    time: float | None  # s; None: it still moves at the end of the record


class SlackRopes(NamedTuple):
    """Head ropes of one side that were slack."""

    side: str
    t: float  # s, of the first sample that shows it
    duration: float  # s, in all
    length: float  # m, at most


def jams(recording: Recording) -> list[JamEvent]:
    """Return the jams, one per side at most, the earlier first."""
    events = []
    for side in SIDES:
        name = f"drive.jam_{side}"
        held = np.flatnonzero(recording[name]) if name in recording else np.array([], dtype=np.intp)
        if not held.size:
            continue
        k = int(held[0])
        y, vy, ay = (recording[f"conveyance.{side}.{quantity}"][k:] for quantity in ("y", "vy", "ay"))
        turned = _stands(vy)
        stood = turned is not None and recording[name][k + turned] != 0.0
        last = turned if turned is not None and stood else int(held[-1]) - k
        distance = abs(float(y[last] - y[0])) if stood else None
        hardest = float(np.max(np.abs(ay[: last + 1])))
        events.append(JamEvent(side, float(recording.time[k]), float(y[0]), distance, hardest))
    return sorted(events, key=attrgetter("t"))


def _stands(speeds: Array) -> int | None:
    """Return the first sample at which what moved at first stands still; None where it goes on."""
    turned = np.flatnonzero(speeds * speeds[0] <= 0.0)
    return int(turned[0]) if turned.size else None


def stops(recording: Recording, begin: float | None) -> list[Stop]:
    """Return the emergency stop of each conveyance, `begin` [s] after the start of the record."""
    if begin is None or not recording.has(*(f"conveyance.{side}.vy" for side in SIDES)):
        return []
    conveyances = []
    k = int(np.searchsorted(recording.time - recording.time[0], begin))
    for side in SIDES if k < len(recording.time) else ():
        y, vy = (recording[f"conveyance.{side}.{name}"][k:] for name in ("y", "vy"))
        last = _stands(vy)
        time = None if last is None else float(recording.time[k + last] - recording.time[k])
        conveyances.append(Stop(side, float(np.max(np.abs(y[: None if last is None else last + 1] - y[0]))), time))
    return conveyances


def slack_ropes(recording: Recording) -> list[SlackRopes]:
    """Return the slack head ropes, one entry per side at most, the earlier first."""
    sides = []
    for side in SIDES:
        name = f"drive.slack_{side}"
        if name in recording and bool(np.any(recording[name] > 0.0)):
            slack, time = recording[name], recording.time
            duration = float(np.sum(np.diff(time)[slack[:-1] > 0.0]))
            sides.append(SlackRopes(side, float(time[np.argmax(slack > 0.0)]), duration, float(np.max(slack))))
    return sorted(sides, key=attrgetter("t"))


SLIP_SIGNALS = frozenset({"drive.slip", "drive.slip_speed"})  #: Signals from which slip follows.
ALIKE = "make the two sides more alike in weight"  #: What gives friction more room.

#: Words on head ropes that hold where friction alone would not.
IN_SPITE = (
    "the model lets them hold, so nothing after that instant is a prediction. Let them slip (hoist.lining.sliding = "
    f"0.8), brake or accelerate more gently (winding.emergency_deceleration, winding.acceleration), or {ALIKE}"
)


class Slip(NamedTuple):
    """Slip of the head ropes over a whole run."""

    t: float  # s, of the last sample before they slid
    slid_distance: float  # m, to and fro
    net: float  # m, of the ropes on the sheave, positive as its rotation
    speed: float  # m/s, largest
    duration: float  # s, in all
    last: float  # m/s, at the end: 0 where they hold again


def slip(recording: Recording) -> Slip | None:
    """Return the slip of a run; None if the ropes held."""
    if not recording.has(*SLIP_SIGNALS):
        return None
    position, time = recording["drive.slip"], recording.time
    slid = np.flatnonzero(np.diff(position))
    if not slid.size:
        return None
    return Slip(
        t=float(time[slid[0]]),
        slid_distance=float(np.sum(np.abs(np.diff(position)))),
        net=float(position[-1] - position[0]),
        speed=float(np.max(np.abs(recording["drive.slip_speed"]))),
        duration=float(np.sum(np.diff(time)[slid])),
        last=float(recording["drive.slip_speed"][-1]),
    )


def largest_ratio(recording: Recording, limit: float) -> float:
    """Return the largest ratio of the head ropes' tensions [-], at least the limit if they slid between two samples."""
    largest = float(np.max(recording["drive.tension_ratio"]))
    return largest if slip(recording) is None else max(largest, limit)


GUARD_SIGNALS = frozenset({"guard.tripped", "guard.cause", "guard.time"})  #: Outputs of the rope's guards.
GUARD_CODES = dict(enumerate(GUARD_CAUSES, start=1))  #: What `guard.cause` stands for.


class GuardTrip(NamedTuple):
    """Time and cause of a guard's trip."""

    t: float  # s
    code: int

    @property
    def cause(self) -> str:
        """Word for the cause, one of GUARD_CODES."""
        return GUARD_CODES[self.code]


def guard_trip(recording: Recording) -> GuardTrip | None:
    """Return the guard's trip in a run; None if there was none."""
    if not recording.has(*GUARD_SIGNALS) or not recording["guard.tripped"].size or recording["guard.tripped"][-1] < 0.5:
        return None
    return GuardTrip(float(recording["guard.time"][-1]), int(recording["guard.cause"][-1]))


def incidents(recording: Recording) -> str:
    """Describe guards that tripped, jams, slack head ropes and slip: the end of a sentence."""
    sentences = []
    if (trip := guard_trip(recording)) is not None:
        sentences.append(f"its guard tripped at t = {trip.t:.4g} s ({trip.cause})")
    for jam in jams(recording):
        through = jam.stopping_distance is None
        course = "was held by a narrow place of its guides, and went through," if through else "jammed"
        sentences.append(f"the {jam.side} conveyance {course} at t = {jam.t:.4g} s")
    sentences += [
        f"the head ropes of the {slack.side} conveyance were slack from t = {slack.t:.4g} s on, by "
        f"{slack.length:.3g} m at most"
        for slack in slack_ropes(recording)
    ]
    if (slid := slip(recording)) is not None:
        still = f", and still slip at {abs(slid.last):.3g} m/s when it ends" if slid.last else ""
        sentences.append(
            f"the head ropes slipped {slid.slid_distance:.3g} m on the sheave from t = {slid.t:.4g} s on, at up to "
            f"{slid.speed:.3g} m/s{still}"
        )
    return "".join(f"; {text}" for text in sentences)
