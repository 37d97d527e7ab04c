"""Rows of the verdict on each rope: its swings, clearances, swivels and errors."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.parameters import SIDES
from hoist_demo.report.formatting import number, rounded
from hoist_demo.report.rope_record import RopeRecord
from hoist_demo.report.verdict_row import NO_BOUND, VerdictRow
from rope_model import BODIES, FAR

HALF_TURN = 0.5  #: Turns of the legs about each other at which a loop has turned over.


class _Swing(NamedTuple):
    """Signal of the loop whose largest size counts."""

    signal: str
    label: str
    unit: str
    guard: str  # guard with the bound of the signal


_SWINGS = (
    _Swing("loop.sideways", "sideways swing of the loop", "m", "window"),
    _Swing("loop.rise", "rise of the loop", "m", "rise"),
    _Swing("loop.turns", "turns of the legs about each other", "", "turns"),
)


class _ErrorEstimate(NamedTuple):
    """Estimate of the rope's own error, with the unit of its text."""

    signal: str
    label: str
    unit: str
    factor: float  # of the unit
    accuracy: str  # parameter with the bound of the error


_ERROR_ESTIMATES = (
    _ErrorEstimate(
        "status.end_force_error",
        "estimated error of the end forces",
        unit="% of the largest",
        factor=100.0,
        accuracy="end_force",
    ),
    _ErrorEstimate(
        "status.loop_error",
        "estimated error of the loop's place",
        unit="mm",
        factor=1e3,
        accuracy="loop",
    ),
)


def rows_of_ropes(
    ropes: Sequence[RopeRecord], rows_of: Callable[[RopeRecord], Iterator[VerdictRow]]
) -> list[VerdictRow]:
    """Return the rows of all ropes, comparable ones side by side."""
    by_quantity: dict[str, list[tuple[RopeData, VerdictRow]]] = {}
    for rope in ropes:
        for row in rows_of(rope):
            by_quantity.setdefault(row.quantity, []).append((rope.data, row))
    shown: dict[VerdictRow, None] = {}  # each row once
    for quantity, rows in by_quantity.items():
        equal = len(rows) == len(ropes) and len({row for _, row in rows}) == 1
        for data, row in rows:
            # rows that are the same for all ropes need no rope's name
            shown[row if equal else replace(row, quantity=data.with_name(quantity))] = None
    return list(shown)


def swings(rope: RopeRecord) -> Iterator[VerdictRow]:
    """Yield the largest swing, rise and turn of the loop, each with the bound of its guard."""
    for swing in _SWINGS:
        if not rope.has_numbers(swing.signal):
            continue
        values = rope.recording[swing.signal]
        if swing.guard != "rise":  # the fall of a loop is no rise
            values = np.abs(values)
        row = int(np.nanargmax(values))
        largest = float(values[row])
        text = number(largest, 2)
        if swing.unit:
            text = f"{rounded(largest, rope.loop_error)} {swing.unit}"
        bound = _bound_of_guard(rope, swing.guard)
        if swing.signal == "loop.turns" and not 0.0 < bound < HALF_TURN:
            bound = HALF_TURN
            bound_text = f"below {HALF_TURN:g}: turned over"
        elif bound > 0.0:
            bound_text = f"below {bound:g} {swing.unit}".rstrip() + ", its guard's"
        else:
            bound_text = NO_BOUND
        where = rope.at(row, swing.signal)
        if swing.signal == "loop.sideways" and rope.recording.has("loop.x", "loop.z"):
            where += _loop_place(rope, row)
        holds = largest < bound if bound > 0.0 else None
        yield VerdictRow(swing.label, text, bound_text, holds, where)


def _bound_of_guard(rope: RopeRecord, guard: str) -> float:
    """Return the bound of a guard of the loop; 0 for none.

    A guard with a height watches the legs instead, or counts the rise from there.
    """
    height = float(rope.data.parameters.get(f"guard.{guard}_y", -FAR))
    if height > -FAR:
        return 0.0
    return rope.parameter(f"guard.{guard}")


def _loop_place(rope: RopeRecord, row: int) -> str:
    """Return x and z of the loop in the shaft at a row, in words, as far as they are computed."""
    text = ""
    for axis, origin in zip("xz", rope.data.suspension.origin[::2], strict=True):
        place = float(rope.recording[f"loop.{axis}"][row]) + origin
        if math.isfinite(place):
            text += f", {axis} = {rounded(place, rope.loop_error)} m"
    return text


def clearances(rope: RopeRecord) -> Iterator[VerdictRow]:
    """Yield the smallest clearances, between the legs and from each kind of body."""
    if rope.has_numbers("loop.clearance"):
        row = int(np.nanargmin(rope.recording["loop.clearance"]))
        clearance = float(rope.recording["loop.clearance"][row])
        yield VerdictRow(
            "clearance between the legs",
            f"{rounded(clearance, rope.loop_error)} m",
            bound="above 0",
            holds=clearance > 0.0,
            where=rope.at(row, "loop.clearance"),
        )
    bound = rope.parameter("guard.clearance")
    for kind, label in BODIES.items():
        near = f"nearest.{kind}"
        if not rope.has_numbers(f"{near}.clearance"):
            continue
        clearance = rope.last(f"{near}.clearance")
        t = rope.last(f"{near}.time")
        y = rope.last(f"{near}.y")
        s = rope.last(f"{near}.s")
        yield VerdictRow(
            f"clearance from {label}",
            f"{rounded(clearance, rope.loop_error)} m",
            bound=f"above {bound:g} m, its guard's" if bound > 0.0 else "above 0",
            holds=clearance > bound,
            where=f"t = {t:.2f} s, y = {y:.2f} m, {s:.1f} m along the rope",
        )


def swivels(rope: RopeRecord) -> Iterator[VerdictRow]:
    """Yield for how long the swivels slipped."""
    texts: dict[str, str] = {}
    since = ""
    for end in SIDES:
        name = f"{end}.swivel.slipping"
        if rope.has_numbers(name):
            since = rope.since(name)
            texts[end] = _slip_text(rope, end)
    if [*texts.values()] == ["locked", "locked"]:
        yield VerdictRow("slip of the swivels", "both locked", where=since)
    elif texts:
        text = ", ".join(f"{end} {word}" for end, word in texts.items())
        yield VerdictRow("slip of the swivels", text, where=since)


def _slip_text(rope: RopeRecord, end: str) -> str:
    """Return for how long the swivel of an end slipped, in words."""
    if end in rope.data.locked:
        return "locked"
    slipping = rope.recording[f"{end}.swivel.slipping"][:-1] > 0.0
    slipped = float(np.sum(np.diff(rope.recording.time) * slipping))
    if slipped:
        return f"{slipped:.2f} s"
    return "none"


def errors(rope: RopeRecord) -> Iterator[VerdictRow]:
    """Yield the estimates of the rope's own error, beside the accuracy that was set."""
    for estimate in _ERROR_ESTIMATES:
        if not rope.has_numbers(estimate.signal):
            continue
        error = rope.last(estimate.signal)
        text = f"{number(estimate.factor * error, 2)} {estimate.unit}"
        bound = rope.parameter(f"accuracy.{estimate.accuracy}")
        if bound > 0.0:
            unit = estimate.unit.split()[0]
            bound_text = f"{number(estimate.factor * bound, 2)} {unit} asked"
            yield VerdictRow(estimate.label, text, bound_text, error <= bound)
        else:
            yield VerdictRow(estimate.label, text)
