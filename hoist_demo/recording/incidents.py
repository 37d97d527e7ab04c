"""Causes that stop a run or should have: guards, jams, slack head ropes and slip."""

from itertools import pairwise
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from hoist_demo.recording.time_series import Array, Recording
from rope_model import GUARD_CAUSES, SIDES


class JamEvent(NamedTuple):
    """A conveyance that caught in its guides."""

    side: str
    t: float  # s, of the first sample that shows it
    height: float  # m, of the suspension there
    # m, from there to where it first stood still; None: it went through
    stopping_distance: float | None
    deceleration: float  # m/s^2, largest change of speed, until then


class Stop(NamedTuple):
    """Emergency stop of one conveyance, and its way after it.

    It swings, or the sheave does not hold it.
    """

    side: str
    stopping_distance: float  # m, its own, until it first stands still
    time: float | None  # s, until then; None: it never does
    drift: float = 0.0  # m, farthest from there later, positive upwards
    # by the head ropes on the sheave, from where these first stand to the end of the record
    held: bool = True
    speed: float = 0.0  # m/s, at the end of the record
    farthest: float = 0.0  # m, from where the stop began


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
        if name not in recording or not recording[name].any():
            continue
        held = np.flatnonzero(recording[name])
        k = int(held[0])
        y = recording[f"conveyance.{side}.y"][k:]
        vy = recording[f"conveyance.{side}.vy"][k:]
        ay = recording[f"conveyance.{side}.ay"][k:]
        distance = None
        last = _first_stand(vy)
        if last is not None and recording[name][k + last] != 0.0:
            distance = abs(float(y[last] - y[0]))
        else:
            last = int(held[-1]) - k
        events.append(
            JamEvent(
                side,
                t=float(recording.time[k]),
                height=float(y[0]),
                stopping_distance=distance,
                deceleration=float(np.max(np.abs(ay[: last + 1]))),
            )
        )
    return sorted(events, key=attrgetter("t"))


#: Speed below which a conveyance or a sheave that is stopped counts as standing still [m/s,
#: assumed].
STILL = 0.05
#: Time within which a sheave that brake or motor holds turns back [s, assumed]; conveyances may
#: swing on.
RECOIL = 2.0


#: Part by which a tension ratio of ropes that slid is set above the limit.
ABOVE_LIMIT = 1e-9
#: Difference of two instants that rounding explains [s].
TIME_ROUNDING = 1e-6


def _first_stand(speeds: Array, still: float = 0.0) -> int | None:
    """Return the first sample at which what moved at first has at most this speed [m/s].

    None where it goes on.
    """
    slow = np.flatnonzero(speeds * np.sign(speeds[0]) <= still)
    if slow.size:
        return int(slow[0])
    return None


def stops(recording: Recording, begin: float | None, radius: float) -> list[Stop]:
    """Return the emergency stop of each conveyance, ``begin`` [s] after the start of the record.

    Whether it is held is judged by the head ropes on the sheave of this radius [m]: a conveyance
    swings on them, in a deep shaft for longer than any brake lets them run.
    """
    if begin is None or not recording.has(
        "drive.rate", "conveyance.left.vy", "conveyance.right.vy"
    ):
        return []
    k = int(np.searchsorted(recording.time - recording.time[0], begin))
    t = recording.time[k:]
    if not t.size:
        return []
    held = _holds(t, _rope_speed(recording, radius)[k:])
    conveyances = []
    for side in SIDES:
        y = recording[f"conveyance.{side}.y"][k:]
        vy = recording[f"conveyance.{side}.vy"][k:]
        way = np.abs(y - y[0])
        stand = _first_stand(vy, STILL)
        last = t.size - 1 if stand is None else stand
        conveyances.append(
            Stop(
                side,
                stopping_distance=float(np.max(way[: last + 1])),
                time=None if stand is None else float(t[last] - t[0]),
                drift=max((y[last:] - y[last]).tolist(), key=abs),
                held=held and stand is not None,
                speed=float(vy[-1]),
                farthest=float(np.max(way)),
            )
        )
    return conveyances


def _rope_speed(recording: Recording, radius: float) -> Array:
    """Return the speed of the head ropes on the sheave [m/s]: of its rim, and of their slip."""
    rim = radius * recording["drive.rate"]
    if "drive.slip_speed" in recording:
        return np.asarray(rim + recording["drive.slip_speed"])
    return np.asarray(rim)


def _holds(time: Array, speeds: Array) -> bool:
    """Return True if stopped ropes come to stand, and then run neither for long nor at the end."""
    stand = _first_stand(speeds, STILL)
    if stand is None:
        return False
    sense = np.where(np.abs(speeds[stand:]) > STILL, np.sign(speeds[stand:]), 0.0)
    if sense[-1] != 0.0:
        return False
    turns = [0, *(np.flatnonzero(np.diff(sense)) + 1).tolist()]
    return not any(
        sense[i] != 0.0 and time[stand + j] - time[stand + i] > RECOIL for i, j in pairwise(turns)
    )


def slack_ropes(recording: Recording) -> list[SlackRopes]:
    """Return the slack head ropes, one entry per side at most, the earlier first."""
    sides = []
    for side in SIDES:
        name = f"drive.slack_{side}"
        if name in recording and bool(np.any(recording[name] > 0.0)):
            slack = recording[name]
            time = recording.time
            sides.append(
                SlackRopes(
                    side,
                    t=float(time[np.argmax(slack > 0.0)]),
                    duration=float(np.sum(np.diff(time)[slack[:-1] > 0.0])),
                    length=float(np.max(slack)),
                )
            )
    return sorted(sides, key=attrgetter("t"))


SLIP_SIGNALS = frozenset({"drive.slip", "drive.slip_speed"})  #: Signals from which slip follows.
BALANCE_SIDES = "make the two sides more alike in weight"  #: What gives friction more room.

#: Words on head ropes that hold where friction alone would not.
IN_SPITE = (
    "the model lets them hold, so nothing after that instant is a prediction. Let them slip "
    "(hoist.lining.sliding = 0.8), brake or accelerate more gently "
    f"(winding.emergency_deceleration, winding.acceleration), or {BALANCE_SIDES}"
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
    position = recording["drive.slip"]
    time = recording.time
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


def tension_ratios(recording: Recording, limit: float) -> Array:
    """Return the ratios of the head ropes' tensions [-].

    Where the ropes slid since the last sample, the ratio is just above the limit.
    """
    ratio = recording["drive.tension_ratio"].copy()
    if recording.has(*SLIP_SIGNALS):
        slid = np.flatnonzero(np.diff(recording["drive.slip"])) + 1
        ratio[slid] = np.maximum(ratio[slid], limit * (1.0 + ABOVE_LIMIT))
    return ratio


#: Outputs of the rope's guards.
GUARD_SIGNALS = frozenset({"guard.tripped", "guard.cause", "guard.time"})
GUARD_CODES = dict(enumerate(GUARD_CAUSES, start=1))  #: What ``guard.cause`` stands for.


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
    if not recording.has(*GUARD_SIGNALS):
        return None
    tripped = recording["guard.tripped"]
    if not tripped.size or tripped[-1] < 0.5:
        return None
    return GuardTrip(float(recording["guard.time"][-1]), int(recording["guard.cause"][-1]))


def incidents(recording: Recording) -> str:
    """Describe guards that tripped, jams, slack head ropes and slip: the end of a sentence."""
    sentences = []
    trip = guard_trip(recording)
    if trip is not None:
        sentences.append(f"its guard tripped at t = {trip.t:.4g} s ({trip.cause})")
    for jam in jams(recording):
        course = "jammed"
        if jam.stopping_distance is None:
            course = "was held by a narrow place of its guides, and went through,"
        sentences.append(f"the {jam.side} conveyance {course} at t = {jam.t:.4g} s")
    for slack in slack_ropes(recording):
        sentences.append(
            f"the head ropes of the {slack.side} conveyance were slack from t = {slack.t:.4g} s "
            f"on, by {slack.length:.3g} m at most"
        )
    of_run = slip(recording)
    if of_run is not None:
        sentence = (
            f"the head ropes slipped {of_run.slid_distance:.3g} m on the sheave from t = "
            f"{of_run.t:.4g} s on, at up to {of_run.speed:.3g} m/s"
        )
        if of_run.last:
            sentence += f", and still slip at {abs(of_run.last):.3g} m/s when it ends"
        sentences.append(sentence)
    return "".join(f"; {text}" for text in sentences)


def circuit_stop(recording: Recording, at: float) -> str:
    """Describe a stop that the safety circuit began ``at`` [s] after the start of the record."""
    t = float(recording.time[0]) + at
    trip = guard_trip(recording)
    text = f"emergency stop at t = {t:.4g} s"
    if trip is not None and trip.t <= t + TIME_ROUNDING:
        return text
    return f"{text}: head ropes pulled less than hoist.slack_tension"
