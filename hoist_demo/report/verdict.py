"""The verdict on a run: its most important numbers with bound, time and place.

Terminal, Markdown and HTML show the rows that are declared here. Rows whose signals were not
recorded are left out.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import SIDES, Arrival, Hoist
from hoist_demo.recording.fidelity import remark
from hoist_demo.recording.incidents import GUARD_CODES, STILL, guard_trip, incidents, stops
from hoist_demo.recording.nearness import RopePair
from hoist_demo.recording.passages import PASSED, passages
from hoist_demo.recording.ropes import rope_signals
from hoist_demo.recording.time_series import Recording
from hoist_demo.report.html.page import number
from hoist_demo.study.metrics import trip_metrics
from hoist_demo.study.slip import slip_safeties, slip_warnings
from rope_model import BODIES, FAR

HALF_TURN = 0.5  #: Turns of the legs about each other at which a loop has turned over.
NO_BOUND = "none asked"
_STRIKES = "strikes"
_HANGS = "above 0: a rope only pulls"

#: Signals whose largest size counts, in words, with unit and the guard whose bound it is.
_SWINGS = (
    ("loop.sideways", "sideways swing of the loop", "m", "window"),
    ("loop.rise", "rise of the loop", "m", "rise"),
    ("loop.turns", "turns of the legs about each other", "", "turns"),
)


@dataclass(frozen=True)
class VerdictRow:
    """Row of the verdict: a quantity, its value, its bound and whether that holds.

    None without a bound.
    """

    quantity: str
    value: str
    bound: str = NO_BOUND
    holds: bool | None = None
    where: str = ""

    @property
    def cells(self) -> tuple[str, ...]:
        """Texts in the order of COLUMNS."""
        return (
            self.quantity,
            self.value,
            self.bound,
            {None: "", True: "yes", False: "NO"}[self.holds],
            self.where,
        )


_WHERE = "when and where: x, z from midway between the conveyances, y from the lower landing"
COLUMNS = ("", "value", "bound", "kept", _WHERE)


@dataclass(frozen=True)
class Verdict:
    """Outcome in words, rows, and remarks on what to do or to be warned of."""

    summary: str
    rows: tuple[VerdictRow, ...] = ()
    remarks: tuple[str, ...] = ()
    when: float | None = None  # s, of the first touch of a body, else of the largest swing
    good: bool = False  # wound to the end, no bound broken, nothing remarked


@dataclass(frozen=True)
class _Rope:
    """Recording and data of one rope."""

    recording: Recording  # record of its signals
    data: RopeData

    def parameter(self, name: str) -> float:
        """Return a number of the rope's parameters, 0 if it lacks it."""
        value = self.data.parameters.get(name, 0.0)
        return float(value) if isinstance(value, int | float) else 0.0

    def last(self, name: str) -> float:
        """Return the value at the end of the record; NaN if it was not computed."""
        return float(self.recording[name][-1]) if name in self.recording else math.nan

    def has_numbers(self, *names: str) -> bool:
        """Return True if all these signals have numbers."""
        return self.recording.has(*names) and all(
            bool(np.isfinite(self.recording[name]).any()) for name in names
        )

    def at(self, row: int, name: str) -> str:
        return ", ".join(filter(None, (f"t = {self.recording.time[row]:.2f} s", self.since(name))))

    def since(self, name: str) -> str:
        """Return from when on a signal was computed; "" if it always was."""
        there = np.isfinite(self.recording[name])
        return (
            ""
            if there.all()
            else f"computed from t = {self.recording.time[np.argmax(there)]:.2f} s on"
        )

    @cached_property
    def loop_error(self) -> float:
        """Estimated error of the loop's place [m]."""
        return self.last("status.loop_error")


def judge(
    result: Result,
    hoist: Hoist,
    data: Sequence[RopeData],
    warnings: Sequence[str] = (),
    pairs: Sequence[RopePair] = (),
    arrival: Arrival | None = None,
) -> Verdict:
    """Judge a run with its ropes and pairs of them; `warnings` are those of ropes and host."""
    recording, arrival = result.recording, arrival or Arrival()
    ropes = (
        [_Rope(rope_signals(recording, one.name), one) for one in data] if recording.signals else []
    )
    rows = tuple(_rows(result, hoist, ropes, pairs, arrival)) if ropes else ()
    words = outcome(result.completed, recording, [one.name for one in data])
    words += f": {result.cause}" if result.cause else ""
    words = f"{words[0].upper()}{words[1:]}. "
    through = any(PASSED in passages(rope.recording) for rope in ropes)
    words += "Results after it passed describe no real rope. " if through else ""
    words += bounds_in_words(rows, completed=result.completed)
    remarks = (*_warnings(result, hoist, ropes, arrival.window), *warnings)
    good = result.completed and not broken(rows) and not remarks
    return Verdict(words, rows, remarks, _what_matters(ropes, pairs), good)


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
    """Return the outcome and the events of a run, in words; `names` are those of its ropes."""
    sentences = [
        passages(rope_signals(recording, name), f"rope {name}" if name else "the rope")
        for name in names
    ]
    passed = ", and ".join(filter(None, sentences))
    ended = ("completed" if completed else "stopped") + (f", but {passed}" if passed else "")
    return (
        ended
        + "".join(_broken(recording, name) for name in filter(None, names))
        + incidents(recording)
    )


def _broken(recording: Recording, name: str) -> str:
    """Describe the break of one of several ropes as the end of a sentence; "" for none."""
    times = rope_signals(recording, name).time
    if len(times) == len(recording.time):
        return ""
    return (
        f"; rope {name} broke by t = {recording.time[len(times)]:.4g} s; its loop, torques and "
        "clearances are those before"
    )


def _warnings(result: Result, hoist: Hoist, ropes: Sequence[_Rope], window: float) -> list[str]:
    """List warnings on coupling, slip of the head ropes, the ropes' fidelity and breaks."""
    texts = [result.warning, *slip_warnings(result, hoist)]
    if limited := result.recording.seconds("drive.torque_limited"):
        cure = "raise hoist.torque_limit and power_limit, or accelerate and stop more gently"
        texts.append(f"the motor was at its limit for {limited:.2f} s: {cure}")
    for rope in ropes:
        name, breaks = rope.data.name, rope.data.breaks
        texts.append(
            remark(rope.recording).replace("the rope", f"rope {name}" if name else "the rope", 1)
        )
        if (
            breaks is not None
            and result.completed
            and len(rope.recording.time) == len(result.recording.time)
        ):
            texts.append(
                f"rope {name} was to break at breaks_at = {breaks[0]:g} s, and did not: the run "
                f"ended at {rope.recording.time[-1]:.4g} s; break it earlier"
            )
    if result.completed and len(ropes) > 1:
        texts.append(
            _still_swinging(
                [rope.recording for rope in ropes if rope.has_numbers("loop.sideways")], window
            )
        )
    return [text for text in texts if text]


def _still_swinging(recordings: Sequence[Recording], window: float) -> str:
    """Return a remark where neighbours end with more than half of their swing: they may yet strike.

    "" for none.
    """
    for recording in recordings:
        sideways, time = np.abs(recording["loop.sideways"]), recording.time
        if (last := np.nanmax(sideways[time >= time[-1] - window])) > 0.5 * np.nanmax(sideways):
            words = (
                f"the loops still swing by {last:.2g} m where the record ends, and may strike each "
                "other later"
            )
            return f"{words}: wind on with a longer winding.settle"
    return ""


def _what_matters(ropes: Sequence[_Rope], pairs: Sequence[RopePair]) -> float | None:
    """Return the time of the first touch, else of the largest swing [s]."""
    touched = [
        rope.last(f"nearest.{kind}.touched_at")
        for rope in ropes
        for kind in BODIES
        if rope.last(f"nearest.{kind}.clearance") <= 0.0
    ]
    touched += [
        pair.nearest.t
        for pair in pairs
        if pair.nearest is not None and pair.nearest.clearance <= 0.0
    ]
    if touched:
        return min(touched)
    swinging = [rope.recording for rope in ropes if rope.has_numbers("loop.sideways")]
    most = max(swinging, key=lambda one: np.nanmax(one["loop.sideways"]), default=None)
    return None if most is None else float(most.time[np.nanargmax(most["loop.sideways"])])


def _rows(
    result: Result,
    hoist: Hoist,
    ropes: Sequence[_Rope],
    pairs: Sequence[RopePair],
    arrival: Arrival,
) -> Iterator[VerdictRow]:
    yield from _pulls(result.recording, hoist, ropes)
    yield from _head_ropes(result.recording, hoist)
    for stop in stops(result.recording, result.winding.emergency_at, hoist.sheave_radius):
        text = f"{stop.stopping_distance:.2f} m" + (
            ", and goes on" if stop.time is None else f" in {stop.time:.2f} s"
        )
        text += (
            f", then {abs(stop.then):.2f} m {'up' if stop.then > 0.0 else 'down'}"
            if abs(stop.then) >= 5e-3
            else ""
        )
        text += (
            f", at {number(abs(stop.speed), 2)} m/s in the end" if abs(stop.speed) > STILL else ""
        )
        quantity = f"way of the {stop.side} conveyance in the emergency stop"
        yield VerdictRow(quantity, text, "held from then on", stop.held)
    timed = result.completed and result.recording.has(
        "drive.torque", "reference.position", "conveyance.right.vy"
    )
    if timed and (cycle := trip_metrics(result, arrival).get("cycle_time")) is not None:
        text = f"{cycle:.2f} s" if math.isfinite(cycle) else "not within the record"
        yield VerdictRow("cycle time, until the conveyances have arrived", text)
    yield from _of_each(ropes, _swings)
    yield from _of_each(ropes, _clearances)
    for pair in pairs:
        yield from _between(
            pair, max(rope.loop_error for rope in ropes if rope.data.name in (pair.one, pair.other))
        )
    for hold in slip_safeties(result, hoist):
        bound = f"at least {hold.required:g}: {hold.rule}"
        yield VerdictRow(
            f"slip safety {hold.when}", hold.text, bound, hold.enough, f"t = {hold.t:.2f} s"
        )
    names = [rope.data.name or "struck" for rope in ropes if passages(rope.recording)]
    near = [pair for pair in pairs if pair.nearest is not None and pair.nearest.clearance <= 0.0]
    names += [f"{pair.one} on {pair.other}" for pair in near]
    yield VerdictRow(_STRIKES, ", ".join(names) or "none", "none", not names)
    set_guards = [
        cause for cause in GUARD_CODES.values() if ropes[0].parameter(f"guard.{cause}") > 0.0
    ]
    trip = guard_trip(result.recording)
    text = f"{trip.cause} tripped" if trip else "none tripped" if set_guards else "none set"
    where = f"t = {trip.t:.2f} s" if trip else ""
    yield VerdictRow(
        "guards",
        text,
        ", ".join(set_guards) or NO_BOUND,
        trip is None if set_guards else None,
        where,
    )
    yield from _of_each(ropes, _swivels)
    yield from _of_each(ropes, _errors)


def _of_each(
    ropes: Sequence[_Rope], rows_of: Callable[[_Rope], Iterator[VerdictRow]]
) -> list[VerdictRow]:
    """Return the rows of all ropes, comparable ones side by side."""
    rows = [(row.quantity, rope.data, row) for rope in ropes for row in rows_of(rope)]
    order = list(dict.fromkeys(quantity for quantity, *_ in rows))
    rows.sort(key=lambda row: order.index(row[0]))
    # rows that are the same for all ropes appear once
    alike = {
        q
        for q in order
        if len(own := [row for x, _, row in rows if x == q]) == len(ropes) and len({*own}) == 1
    }
    named = (row if q in alike else replace(row, quantity=data.whose(q)) for q, data, row in rows)
    return [*dict.fromkeys(named)]


_MISSED = 1e-3  #: Relative error of the forces between two ropes, against the law, that is told.
_ALONE = (
    ": each went on as if alone; contact.rope_stiffness = 1e6 and model.fidelity = torsional let "
    "them press each other"
)


def _between(pair: RopePair, error: float) -> Iterator[VerdictRow]:
    """Yield the clearance of two ropes, and how they pressed each other if they may."""
    if (near := pair.nearest) is not None:
        where = _where(near.t, near.position)
        where += _ALONE if near.clearance <= 0.0 and pair.account is None else ""
        quantity = f"clearance between {pair.one} and {pair.other}"
        bound = f"above {number(error, 2)} m, its error"
        yield VerdictRow(
            quantity, f"{rounded(near.clearance, error)} m", bound, near.clearance > error, where
        )
    if (account := pair.account) is not None and account.peak > 0.0:
        where = _where(account.peak_t, account.peak_place)
        where += (
            f"; errs by up to {number(100 * account.missed, 2)} %"
            if account.missed > _MISSED
            else ""
        )
        yield VerdictRow(
            f"force of {pair.one} on {pair.other}", f"{number(account.peak, 3)} N", where=where
        )


def _where(t: float, point: Sequence[float]) -> str:
    return f"t = {t:.2f} s, " + ", ".join(
        f"{c} = {round(x, 2) + 0.0:.2f} m" for c, x in zip("xyz", point, strict=True)
    )


def _pulls(recording: Recording, hoist: Hoist, ropes: Sequence[_Rope]) -> Iterator[VerdictRow]:
    """Yield the pull of all balance ropes on each conveyance, in digits that its error allows."""
    count = max(hoist.tail_rope_number, len(ropes))
    whose = "the rope" if count == 1 else f"all {count} ropes"
    kilo = 1e-3 * hoist.tail_rope_number
    sizes = [np.nanmax(np.abs(recording[f"{end}.fy"])) for end in SIDES if f"{end}.fy" in recording]
    error = (
        kilo * max(sizes, default=0.0) * max(rope.last("status.end_force_error") for rope in ropes)
    )
    for end in SIDES:
        if f"{end}.fy" in recording:
            pull = -kilo * recording[f"{end}.fy"]
            low, high = int(np.nanargmin(pull)), int(np.nanargmax(pull))
            text = f"{rounded(pull[low], error)} to {rounded(pull[high], error)} kN"
            where = f"t = {recording.time[low]:.2f} s and {recording.time[high]:.2f} s"
            holds = bool(pull[low] > -np.nan_to_num(error))
            yield VerdictRow(f"pull of {whose} on the {end} conveyance", text, _HANGS, holds, where)


def _head_ropes(recording: Recording, hoist: Hoist) -> Iterator[VerdictRow]:
    """Yield the smallest pull of all head ropes on either conveyance."""
    for side in SIDES:
        if (name := f"drive.pull_{side}") in recording:
            row = int(np.argmin(recording[name]))
            threshold = hoist.slack_tension
            least = float(recording[name][row])
            bound = (
                "above 0: slack"
                if threshold is None
                else f"above {number(1e-3 * threshold, 3)} kN, slack_tension"
            )
            quantity, where = (
                f"smallest pull of the head ropes, {side}",
                f"t = {recording.time[row]:.2f} s",
            )
            yield VerdictRow(
                quantity, f"{number(1e-3 * least, 3)} kN", bound, least > (threshold or 0.0), where
            )


def _swings(rope: _Rope) -> Iterator[VerdictRow]:
    for name, label, unit, guard in _SWINGS:
        if not rope.has_numbers(name):
            continue
        # the fall of a loop is no rise
        values = rope.recording[name] if guard == "rise" else np.abs(rope.recording[name])
        bound = rope.parameter(f"guard.{guard}")
        if float(rope.data.parameters.get(f"guard.{guard}_y", -FAR)) > -FAR:
            bound = 0.0  # it watches the legs instead, or counts the rise from there
        row = int(np.nanargmax(values))
        largest = float(values[row])
        text = f"{rounded(largest, rope.loop_error)} m" if unit else number(largest, 2)
        bound_text = (
            f"below {bound:g} {unit}".rstrip() + ", its guard's" if bound > 0.0 else NO_BOUND
        )
        holds = largest < bound if bound > 0.0 else None
        if name == "loop.turns" and not 0.0 < bound < HALF_TURN:
            bound_text, holds = f"below {HALF_TURN:g}: turned over", largest < HALF_TURN
        where = rope.at(row, name)
        if name == "loop.sideways" and rope.recording.has("loop.x", "loop.z"):
            origins = zip("xz", rope.data.suspension.origin[::2], strict=True)
            places = (
                (c, float(rope.recording[f"loop.{c}"][row]) + origin) for c, origin in origins
            )
            where += "".join(
                f", {c} = {rounded(x, rope.loop_error)} m" for c, x in places if math.isfinite(x)
            )
        yield VerdictRow(label, text, bound_text, holds, where)


def _clearances(rope: _Rope) -> Iterator[VerdictRow]:
    if rope.has_numbers("loop.clearance"):
        row = int(np.nanargmin(rope.recording["loop.clearance"]))
        clear = float(rope.recording["loop.clearance"][row])
        text = f"{rounded(clear, rope.loop_error)} m"
        yield VerdictRow(
            "clearance between the legs",
            text,
            "above 0",
            clear > 0.0,
            rope.at(row, "loop.clearance"),
        )
    bound = rope.parameter("guard.clearance")
    for kind, label in BODIES.items():
        near = f"nearest.{kind}"
        if not rope.has_numbers(f"{near}.clearance"):
            continue
        clear, t, s, y = (rope.last(f"{near}.{key}") for key in ("clearance", "time", "s", "y"))
        where = f"t = {t:.2f} s, y = {y:.2f} m, {s:.1f} m along the rope"
        bound_text = f"above {bound:g} m, its guard's" if bound > 0.0 else "above 0"
        text = f"{rounded(clear, rope.loop_error)} m"
        yield VerdictRow(f"clearance from {label}", text, bound_text, clear > bound, where)


def _swivels(rope: _Rope) -> Iterator[VerdictRow]:
    texts, since = {}, ""
    for end in SIDES:
        if rope.has_numbers(name := f"{end}.swivel.slipping"):
            since = rope.since(name)
            slipped = float(
                np.sum(np.diff(rope.recording.time) * (rope.recording[name][:-1] > 0.0))
            )
            texts[end] = (
                "locked" if end in rope.data.locked else f"{slipped:.2f} s" if slipped else "none"
            )
    if texts:
        text = ", ".join(f"{end} {word}" for end, word in texts.items())
        text = "both locked" if [*texts.values()] == ["locked"] * 2 else text
        yield VerdictRow("slip of the swivels", text, where=since)


def _errors(rope: _Rope) -> Iterator[VerdictRow]:
    """Return the estimates of the rope's own error, beside the accuracy that was asked of it."""
    for name, label, unit, factor, accuracy in (
        (
            "status.end_force_error",
            "estimated error of the end forces",
            "% of the largest",
            100.0,
            "end_force",
        ),
        ("status.loop_error", "estimated error of the loop's place", "mm", 1e3, "loop"),
    ):
        if rope.has_numbers(name):
            bound, error = rope.parameter(f"accuracy.{accuracy}"), rope.last(name)
            text = f"{number(factor * error, 2)} {unit}"
            if bound > 0.0:
                yield VerdictRow(
                    label,
                    text,
                    f"{number(factor * bound, 2)} {unit.split()[0]} asked",
                    error <= bound,
                )
            else:
                yield VerdictRow(label, text)


def rounded(value: float, error: float) -> str:
    """Return a number with the decimals that its error allows, three at most.

    An unknown error leaves three digits.
    """
    if not error > 0.0:
        return number(value, 3)
    decimals = min(3, max(0, round(-math.log10(error))))
    return f"{round(value, decimals) + 0.0:.{decimals}f}"
