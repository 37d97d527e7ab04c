"""Conveyances that caught in their guides, and head ropes that went slack: when, and how it went on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hoist_demo.recording.time_series import Recording

SIDES = ("left", "right")


class Jam(NamedTuple):
    """A conveyance that caught in its guides."""

    side: str
    t: float  # s, of the first sample that shows it
    height: float  # m, of the suspension there
    way: float | None  # m, from there to where it first stood still; None: it went through
    deceleration: float  # m/s^2, largest change of speed, until then


class SlackRopes(NamedTuple):
    """The head ropes of one side, which were slack."""

    side: str
    t: float  # s, of the first sample that shows it
    duration: float  # s, in all
    length: float  # m, at most


def jams(recording: Recording) -> list[Jam]:
    """One per side at most, the earlier first."""
    found = []
    for side in SIDES:
        name = f"drive.jam_{side}"
        held = np.flatnonzero(recording[name]) if name in recording else np.array([], dtype=np.intp)
        if not held.size:
            continue
        k = int(held[0])
        y, vy, ay = (recording[f"conveyance.{side}.{quantity}"][k:] for quantity in ("y", "vy", "ay"))
        turned = np.flatnonzero(vy * vy[0] <= 0.0)
        stood = turned.size > 0 and recording[name][k + int(turned[0])] != 0.0
        last = int(turned[0]) if stood else int(held[-1]) - k
        way = abs(float(y[last] - y[0])) if stood else None
        found.append(Jam(side, float(recording.time[k]), float(y[0]), way, float(np.max(np.abs(ay[: last + 1])))))
    return sorted(found, key=_time)


def slack_ropes(recording: Recording) -> list[SlackRopes]:
    """One per side at most, the earlier first."""
    found = []
    for side in SIDES:
        name = f"drive.slack_{side}"
        if name in recording and bool(np.any(recording[name] > 0.0)):
            slack, time = recording[name], recording.time
            duration = float(np.sum(np.diff(time)[slack[:-1] > 0.0]))
            found.append(SlackRopes(side, float(time[np.argmax(slack > 0.0)]), duration, float(np.max(slack))))
    return sorted(found, key=_time)


def told_of_jams(recording: Recording) -> str:
    """All of them as the end of a sentence; "" for none."""
    told = [f"; the {jam.side} conveyance {_course(jam)} at t = {jam.t:.4g} s" for jam in jams(recording)]
    told += [
        f"; the head ropes of the {slack.side} conveyance were slack from t = {slack.t:.4g} s on, by "
        f"{slack.length:.3g} m at most"
        for slack in slack_ropes(recording)
    ]
    return "".join(told)


def _time(event: Jam | SlackRopes) -> float:
    return event.t


def _course(jam: Jam) -> str:
    return "jammed" if jam.way is not None else "was held by a narrow place of its guides, and went through,"
