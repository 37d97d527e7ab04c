"""The verdict on a run: its most important numbers with bound, time and place.

Terminal, Markdown and HTML show its rows, which the modules ``*_verdict`` declare. Rows whose signals
were not recorded are left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Arrival, Hoist
from hoist_demo.recording.incidents import incidents
from hoist_demo.recording.nearness import RopePair
from hoist_demo.recording.passages import PASSED, passages
from hoist_demo.recording.ropes import rope_signals
from hoist_demo.recording.time_series import Recording
from hoist_demo.report.contact_verdict import between_ropes, guards, strikes
from hoist_demo.report.hoist_verdict import (
    cycle_time,
    emergency_stops,
    head_ropes,
    pulls,
    slip_rows,
)
from hoist_demo.report.rope_record import RopeRecord, rope_text, swinging
from hoist_demo.report.rope_verdict import clearances, errors, rows_of_ropes, swings, swivels
from hoist_demo.report.verdict_remarks import run_remarks
from hoist_demo.report.verdict_row import VerdictRow
from rope_model import BODIES


@dataclass(frozen=True)
class Verdict:
    """Outcome in words, rows, and remarks on what to do or to be warned of."""

    summary: str
    rows: tuple[VerdictRow, ...] = ()
    remarks: tuple[str, ...] = ()
    when: float | None = None  # s, of the first touch of a body, else of the largest swing
    good: bool = False  # wound to the end, no bound broken, nothing remarked


def judge(
    result: Result,
    hoist: Hoist,
    data: Sequence[RopeData],
    warnings: Sequence[str] = (),
    pairs: Sequence[RopePair] = (),
    arrival: Arrival | None = None,
) -> Verdict:
    """Judge a run with its ropes and pairs of them; ``warnings`` are those of ropes and host."""
    recording = result.recording
    arrival = arrival or Arrival()
    ropes: list[RopeRecord] = []
    rows: list[VerdictRow] = []
    if recording.signals:
        ropes = [RopeRecord(rope_signals(recording, one.name), one) for one in data]
        rows = _rows(result, hoist, ropes, pairs, arrival)
    words = outcome(result.completed, recording, [one.name for one in data])
    if result.cause:
        words += f": {result.cause}"
    words = f"{words[0].upper()}{words[1:]}. "
    if any(PASSED in passages(rope.recording) for rope in ropes):
        words += "Results after it passed describe no real rope. "
    words += bounds_in_words(rows, completed=result.completed)
    remarks = (*run_remarks(result, hoist, ropes, arrival.window), *warnings)
    return Verdict(
        words,
        rows=tuple(rows),
        remarks=remarks,
        when=instant_to_show(ropes, pairs),
        good=result.completed and not broken(rows) and not remarks,
    )


def broken(rows: Sequence[VerdictRow]) -> list[VerdictRow]:
    """Return the rows whose bound does not hold."""
    return [row for row in rows if row.holds is False]


def bounds_in_words(rows: Sequence[VerdictRow], *, completed: bool) -> str:
    """Return a sentence that names every row whose bound does not hold, or says that all hold.

    "" without rows.
    """
    if names := [row.quantity for row in broken(rows)]:
        return f"Not kept: {', '.join(names)}."
    if not rows:
        return ""
    until = "" if completed else " until then"
    return f"All {sum(row.holds is True for row in rows)} bounds are kept{until}."


def outcome(completed: bool, recording: Recording, names: Sequence[str] = ("",)) -> str:
    """Return the outcome and the events of a run, in words; ``names`` are those of its ropes."""
    text = "completed" if completed else "stopped"
    sentences = [passages(rope_signals(recording, name), rope_text(name)) for name in names]
    if any(sentences):
        text += f", but {', and '.join(filter(None, sentences))}"
    for name in filter(None, names):
        text += _broken(recording, name)
    return text + incidents(recording)


def _broken(recording: Recording, name: str) -> str:
    """Describe the break of one of several ropes as the end of a sentence; "" for none."""
    times = rope_signals(recording, name).time
    if len(times) == len(recording.time):
        return ""
    return (
        f"; rope {name} broke by t = {recording.time[len(times)]:.4g} s; its loop, torques and "
        "clearances are those before"
    )


def _rows(
    result: Result,
    hoist: Hoist,
    ropes: Sequence[RopeRecord],
    pairs: Sequence[RopePair],
    arrival: Arrival,
) -> list[VerdictRow]:
    return [
        *pulls(result.recording, hoist, ropes),
        *head_ropes(result.recording, hoist),
        *emergency_stops(result, hoist),
        *cycle_time(result, arrival),
        *rows_of_ropes(ropes, swings),
        *rows_of_ropes(ropes, clearances),
        *between_ropes(pairs, ropes),
        *slip_rows(result, hoist),
        strikes(ropes, pairs),
        guards(result.recording, ropes[0]),
        *rows_of_ropes(ropes, swivels),
        *rows_of_ropes(ropes, errors),
    ]


def instant_to_show(ropes: Sequence[RopeRecord], pairs: Sequence[RopePair]) -> float | None:
    """Return the time of the first touch, else of the largest swing [s]."""
    nearest = [pair.nearest for pair in pairs if pair.nearest is not None]
    touches = [near.t for near in nearest if near.clearance <= 0.0]
    for rope in ropes:
        for kind in BODIES:
            if rope.last(f"nearest.{kind}.clearance") <= 0.0:
                touches.append(rope.last(f"nearest.{kind}.touched_at"))
    if touches:
        return min(touches)
    largest = max(
        swinging(ropes), key=lambda one: float(np.nanmax(one["loop.sideways"])), default=None
    )
    if largest is None:
        return None
    return float(largest.time[np.nanargmax(largest["loop.sideways"])])
