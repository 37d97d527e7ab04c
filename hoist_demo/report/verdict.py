"""The verdict on a run: what a hoist engineer asks first, each number beside its bound, when and where.

Terminal, Markdown and HTML show the rows that are declared here. Rows whose signals were not recorded are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.recording.fidelity import remark
from hoist_demo.recording.incidents import GUARD_CODES, guard_trip, told, told_of_jams, told_of_slip
from hoist_demo.recording.passages import BODIES, FAR, PASSED, outcome_of, passages
from hoist_demo.recording.time_series import Recording
from hoist_demo.report.html.page import number
from hoist_demo.study.slip import holds, slip_warnings

HALF_TURN = 0.5  #: Turns of the legs about each other at which a loop has turned over.

NOT_ASKED = "none asked"

_HANGS = "above 0: a rope only pulls"

#: Signals whose largest size counts, in words, with unit and the guard whose bound it is.
_SWINGS = (
    ("loop.sideways", "sideways swing of the loop", "m", "window"),
    ("loop.rise", "rise of the loop", "m", "rise"),
    ("loop.turns", "turns of the legs about each other", "", "turns"),
)


@dataclass(frozen=True)
class Judged:
    """One row: a quantity, its value, its bound and whether that holds; None where nothing is asked."""

    quantity: str
    value: str
    bound: str = NOT_ASKED
    holds: bool | None = None
    where: str = ""

    @property
    def cells(self) -> tuple[str, ...]:
        """Texts in the order of COLUMNS."""
        return self.quantity, self.value, self.bound, {None: "", True: "yes", False: "NO"}[self.holds], self.where


COLUMNS = ("", "value", "bound", "kept", "when and where")


@dataclass(frozen=True)
class Verdict:
    """Outcome in words, rows, and remarks on what to do or to be warned of."""

    words: str
    rows: tuple[Judged, ...] = ()
    remarks: tuple[str, ...] = ()
    when: float | None = None  # s, of the first touch of a body, else of the largest swing
    good: bool = False  # wound to the end, no bound broken, nothing remarked


@dataclass(frozen=True)
class _Run:
    """What the rows read."""

    recording: Recording
    hoist: Hoist
    rope: RopeData

    def asked(self, name: str) -> float:
        """Number of a parameter of the rope, 0 where it has none."""
        value = self.rope.parameters.get(name, 0.0)
        return float(value) if isinstance(value, int | float) else 0.0

    def last(self, name: str) -> float:
        """Value at the end of the record; NaN where it was not computed."""
        return float(self.recording[name][-1]) if name in self.recording else math.nan

    def known(self, *names: str) -> bool:
        """Return True if all these signals have numbers."""
        return self.recording.has(*names) and all(bool(np.isfinite(self.recording[name]).any()) for name in names)

    def at(self, row: int) -> str:
        return f"t = {self.recording.time[row]:.2f} s"

    @cached_property
    def length_error(self) -> float:
        """Estimated error of the loop's place [m]."""
        return self.last("status.loop_error")


def judge(result: Result, hoist: Hoist, rope: RopeData, *said: str) -> Verdict:
    """Judge a run; `said` are warnings that rope and host gave."""
    recording = result.recording
    run = _Run(recording, hoist, rope)
    rows = tuple(_rows(run, result.winding)) if recording.signals else ()
    broken = [row for row in rows if row.holds is False]
    words = outcome(result.completed, recording) + (f": {result.cause}" if result.cause else "")
    words = f"{words[0].upper()}{words[1:]}. "
    words += "Results after it passed describe no real rope. " if PASSED in passages(recording) else ""
    if broken:
        words += f"Not kept: {', '.join(row.quantity for row in broken)}."
    elif rows:
        until = "" if result.completed else " until then"
        words += f"All {sum(row.holds is True for row in rows)} bounds are kept{until}."
    remarks = (*warnings(result, hoist), *said)
    when = _what_matters(run) if recording.signals else None
    return Verdict(words, rows, remarks, when, result.completed and not broken and not remarks)


def outcome(completed: bool, recording: Recording) -> str:
    """Return the outcome and the events of a run, in words."""
    return outcome_of(completed, passages(recording)) + incidents(recording)


def incidents(recording: Recording) -> str:
    """Guards that tripped, conveyances that jammed, head ropes that went slack or slipped: the end of a sentence."""
    return told(recording) + told_of_jams(recording) + told_of_slip(recording)


def warnings(result: Result, hoist: Hoist) -> list[str]:
    """List the warnings that readers of the numbers need: of coupling, head ropes' hold, and the rope's fidelity."""
    slipping = slip_warnings(result.recording, hoist, result.winding)
    texts = result.warning, *slipping, remark(result.recording)
    return [text for text in texts if text]


def _what_matters(run: _Run) -> float | None:
    if touched := [t for kind in BODIES if (t := run.last(f"nearest.{kind}.touched_at")) > 0.0]:
        return min(touched)
    swing = run.recording["loop.sideways"] if run.known("loop.sideways") else None
    return None if swing is None else float(run.recording.time[np.nanargmax(swing)])


def _rows(run: _Run, winding: Winding) -> Iterator[Judged]:
    yield from _pulls(run)
    yield from _swings(run)
    yield from _clearances(run)
    for hold in holds(run.recording, run.hoist, winding):
        text, bound = f"{hold.safety:.2f}", f"at least {hold.asked:g}: {hold.rule}"
        where = f"t = {hold.t:.2f} s"
        yield Judged(f"slip safety {hold.when}", text, bound, hold.enough, where)
    struck = passages(run.recording)
    yield Judged("strikes", "struck" if struck else "none", "none", not struck)
    set_guards = [cause for cause in GUARD_CODES.values() if run.asked(f"guard.{cause}") > 0.0]
    trip = guard_trip(run.recording)
    text = f"{trip.cause} tripped" if trip else "none tripped" if set_guards else "none set"
    where = f"t = {trip.t:.2f} s" if trip else ""
    yield Judged("guards", text, ", ".join(set_guards) or NOT_ASKED, trip is None if set_guards else None, where)
    yield from _swivels(run)
    yield from _errors(run)


def _pulls(run: _Run) -> Iterator[Judged]:
    """Pull of all balance ropes on each conveyance, with the digits that the estimated error of the forces leaves."""
    count = run.hoist.tail_rope_number
    whose = "the rope" if count == 1 else f"all {count} ropes"
    kilo = 1e-3 * count
    sizes = [np.nanmax(np.abs(run.recording[f"{end}.fy"])) for end in ("left", "right") if f"{end}.fy" in run.recording]
    error = kilo * max(sizes, default=0.0) * run.last("status.end_force_error")
    for end in ("left", "right"):
        if run.known(f"{end}.fy"):
            pull = -kilo * run.recording[f"{end}.fy"]
            low, high = int(np.nanargmin(pull)), int(np.nanargmax(pull))
            text = f"{rounded(pull[low], error)} to {rounded(pull[high], error)} kN"
            where = f"{run.at(low)} and {run.recording.time[high]:.2f} s"
            yield Judged(f"pull of {whose} on the {end} conveyance", text, _HANGS, bool(pull[low] > -error), where)


def _swings(run: _Run) -> Iterator[Judged]:
    for name, words, unit, guard in _SWINGS:
        if not run.known(name):
            continue
        values, bound = np.abs(run.recording[name]), run.asked(f"guard.{guard}")
        if guard == "window" and float(run.rope.parameters.get("guard.window_y", -FAR)) > -FAR:
            bound = 0.0  # it watches the legs instead
        row = int(np.nanargmax(values))
        largest = float(values[row])
        text = f"{rounded(largest, run.length_error)} m" if unit else number(largest, 2)
        asked = f"below {bound:g}{unit and ' '}{unit}, its guard's" if bound > 0.0 else NOT_ASKED
        kept = largest < bound if bound > 0.0 else None
        if name == "loop.turns" and not 0.0 < bound < HALF_TURN:
            asked, kept = f"below {HALF_TURN:g}: turned over", largest < HALF_TURN
        where = run.at(row)
        if name == "loop.sideways" and run.known("loop.x", "loop.z"):
            x, z = (rounded(float(run.recording[f"loop.{c}"][row]), run.length_error) for c in "xz")
            where += f", x = {x} m, z = {z} m"
        yield Judged(words, text, asked, kept, where)


def _clearances(run: _Run) -> Iterator[Judged]:
    if run.known("loop.clearance"):
        row = int(np.nanargmin(run.recording["loop.clearance"]))
        clear = float(run.recording["loop.clearance"][row])
        text = f"{rounded(clear, run.length_error)} m"
        yield Judged("clearance between the legs", text, "above 0", clear > 0.0, run.at(row))
    bound = run.asked("guard.clearance")
    for kind, words in BODIES.items():
        near = f"nearest.{kind}"
        if not run.known(f"{near}.clearance"):
            continue
        clear, t, s, y = (run.last(f"{near}.{key}") for key in ("clearance", "time", "s", "y"))
        where = f"t = {t:.2f} s, y = {y:.2f} m, {s:.1f} m along the rope"
        asked = f"above {bound:g} m, its guard's" if bound > 0.0 else "above 0"
        yield Judged(f"clearance from {words}", f"{rounded(clear, run.length_error)} m", asked, clear > bound, where)


def _swivels(run: _Run) -> Iterator[Judged]:
    told = {}
    for end in ("left", "right"):
        if run.known(name := f"{end}.swivel.slipping"):
            slipped = float(np.sum(np.diff(run.recording.time) * (run.recording[name][:-1] > 0.0)))
            told[end] = "locked" if end in run.rope.locked else f"{slipped:.2f} s" if slipped else "none"
    if told:
        text = ", ".join(f"{end} {word}" for end, word in told.items())
        yield Judged("slip of the swivels", "both locked" if [*told.values()] == ["locked"] * 2 else text)


def _errors(run: _Run) -> Iterator[Judged]:
    """Return the estimates of the rope's own error, beside the accuracy that was asked of it."""
    for name, words, unit, factor, asked in (
        ("status.end_force_error", "estimated error of the end forces", "% of the largest", 100.0, "end_force"),
        ("status.loop_error", "estimated error of the loop's place", "mm", 1e3, "loop"),
    ):
        if run.known(name):
            bound, found = run.asked(f"accuracy.{asked}"), run.last(name)
            text = f"{number(factor * found, 2)} {unit}"
            if bound > 0.0:
                yield Judged(words, text, f"{number(factor * bound, 2)} {unit.split()[0]} asked", found <= bound)
            else:
                yield Judged(words, text)


def rounded(value: float, error: float) -> str:
    """Return a number with the decimals that its error allows, three at most; an unknown error leaves three digits."""
    if not error > 0.0:
        return number(value, 3)
    places = min(3, max(0, round(-math.log10(error))))
    return f"{round(value, places) + 0.0:.{places}f}"
