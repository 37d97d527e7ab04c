"""Instants that a reader looks for: swivels slipping, mesh transformations, the emergency stop, the end of the trip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Winding
from hoist_demo.recording.incidents import guard_trip, jams, slack_ropes, slip
from hoist_demo.recording.time_series import Recording


@dataclass(frozen=True)
class Mark:
    """An instant with a name."""

    t: float  # s
    label: str


def marks(result: Result, winding: Winding) -> list[Mark]:
    """List faults, creep, the reference's arrival and the place where a run was stopped, in order of time."""
    times = result.recording.time
    # Host's reference counts from the start of the record
    start = float(times[0])
    found = [Mark(jam.t, f"{jam.side} conveyance jams") for jam in jams(result.recording)]
    found += [Mark(slack.t, f"{slack.side} head ropes slack") for slack in slack_ropes(result.recording)]
    if (slid := slip(result.recording)) is not None:
        found.append(Mark(slid.t, "head ropes slip"))
    if winding.creeps:
        found += [Mark(start + t, "creep") for t in result.trajectory.holds(winding.creep_speed)]
    if (trip := guard_trip(result.recording)) is not None:
        found.append(Mark(trip.t, f"guard: {trip.cause}"))
    if winding.emergency_at is not None:
        found.append(Mark(start + winding.emergency_at, "emergency stop"))
    found.append(Mark(start + result.trajectory.duration, "reference at rest"))
    # inside the record only
    found = sorted((mark for mark in found if start <= mark.t <= float(times[-1])), key=lambda mark: mark.t)
    return found if result.completed else [*found, Mark(float(times[-1]), "run stopped")]


def transformations(recording: Recording) -> list[float]:
    """First recorded instants [s] after a transformation of the mesh, in ascending order."""
    name = "count.transformations"
    if name not in recording:
        return []
    return [float(t) for t in recording.time[1:][np.diff(recording[name]) > 0.0]]


def slips(recording: Recording, end: str) -> list[tuple[float, float]]:
    """Intervals [s] during which the swivel of `end` slips, each recorded state holding until the next row."""
    name = f"{end}.swivel.slipping"
    if name not in recording:
        return []
    inside = np.concatenate([[False], recording[name] > 0.5, [False]])
    edges = np.flatnonzero(inside[1:] != inside[:-1])
    times, last = recording.time, len(recording.time) - 1
    return [(float(times[a]), float(times[min(b, last)])) for a, b in edges.reshape(-1, 2)]
