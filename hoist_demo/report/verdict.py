"""The verdict on a run: its most important numbers with bound, time and place.

Terminal, Markdown and HTML show the rows that are declared here. Rows whose signals were not
recorded are left out.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

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
from hoist_demo.report.formatting import number
from hoist_demo.run.metrics import trip_metrics
from hoist_demo.run.slip import slip_safeties, slip_warnings
from rope_model import BODIES, FAR

HALF_TURN = 0.5  #: Turns of the legs about each other at which a loop has turned over.
NO_BOUND = "none asked"
_STRIKES = "strikes"
_HANGS = "above 0: a rope only pulls"
#: Part of its largest swing with which a loop counts as still swinging.
STILL_SWINGING = 0.5
#: Shortest way of a conveyance after an emergency stop that the verdict mentions [m].
SMALLEST_DRIFT = 5e-3


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
        kept = {None: "", True: "yes", False: "NO"}[self.holds]
        return self.quantity, self.value, self.bound, kept, self.where


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
        if isinstance(value, int | float):
            return float(value)
        return 0.0

    def last(self, name: str) -> float:
        """Return the value at the end of the record; NaN if it was not computed."""
        if name in self.recording:
            return float(self.recording[name][-1])
        return math.nan

    def has_numbers(self, *names: str) -> bool:
        """Return True if all these signals have numbers."""
        return self.recording.has(*names) and all(
            bool(np.isfinite(self.recording[name]).any()) for name in names
        )

    def at(self, row: int, name: str) -> str:
        """Return the instant of a row, and from when on the signal was computed."""
        instant = f"t = {self.recording.time[row]:.2f} s"
        since = self.since(name)
        if since:
            return f"{instant}, {since}"
        return instant

    def since(self, name: str) -> str:
        """Return from when on a signal was computed; "" if it always was."""
        computed = np.isfinite(self.recording[name])
        if computed.all():
            return ""
        return f"computed from t = {self.recording.time[np.argmax(computed)]:.2f} s on"

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
    recording = result.recording
    arrival = arrival or Arrival()
    ropes = list[_Rope]()
    rows = list[VerdictRow]()
    if recording.signals:
        ropes = [_Rope(rope_signals(recording, one.name), one) for one in data]
        rows = _rows(result, hoist, ropes, pairs, arrival)
    words = outcome(result.completed, recording, [one.name for one in data])
    if result.cause:
        words += f": {result.cause}"
    words = f"{words[0].upper()}{words[1:]}. "
    if any(PASSED in passages(rope.recording) for rope in ropes):
        words += "Results after it passed describe no real rope. "
    words += bounds_in_words(rows, completed=result.completed)
    remarks = (*_warnings(result, hoist, ropes, arrival.window), *warnings)
    return Verdict(
        words,
        rows=tuple(rows),
        remarks=remarks,
        when=_instant_to_show(ropes, pairs),
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
    """Return the outcome and the events of a run, in words; `names` are those of its ropes."""
    text = "completed" if completed else "stopped"
    sentences = [passages(rope_signals(recording, name), _rope_text(name)) for name in names]
    if any(sentences):
        text += f", but {', and '.join(filter(None, sentences))}"
    for name in filter(None, names):
        text += _broken(recording, name)
    return text + incidents(recording)


def _rope_text(name: str) -> str:
    """Return a rope's name in a sentence; the only rope has none."""
    if name:
        return f"rope {name}"
    return "the rope"


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
        name = rope.data.name
        texts.append(remark(rope.recording).replace("the rope", _rope_text(name), 1))
        whole = len(rope.recording.time) == len(result.recording.time)
        if rope.data.breaks is not None and result.completed and whole:
            breaks_at, _ = rope.data.breaks
            texts.append(
                f"rope {name} was to break at breaks_at = {breaks_at:g} s, and did not: the run "
                f"ended at {rope.recording.time[-1]:.4g} s; break it earlier"
            )
    if result.completed and len(ropes) > 1:
        texts.append(_still_swinging(_swinging(ropes), window))
    return [text for text in texts if text]


def _swinging(ropes: Sequence[_Rope]) -> list[Recording]:
    """Return the records that have the sideways swing of a loop."""
    return [rope.recording for rope in ropes if rope.has_numbers("loop.sideways")]


def _still_swinging(recordings: Sequence[Recording], window: float) -> str:
    """Return a remark where neighbours end with more than half of their swing: they may yet strike.

    "" for none.
    """
    for recording in recordings:
        time = recording.time
        sideways = np.abs(recording["loop.sideways"])
        last = np.nanmax(sideways[time >= time[-1] - window])
        if last > STILL_SWINGING * np.nanmax(sideways):
            return (
                f"the loops still swing by {last:.2g} m where the record ends, and may strike each "
                "other later: wind on with a longer winding.settle"
            )
    return ""


def _instant_to_show(ropes: Sequence[_Rope], pairs: Sequence[RopePair]) -> float | None:
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
        _swinging(ropes), key=lambda one: float(np.nanmax(one["loop.sideways"])), default=None
    )
    if largest is None:
        return None
    return float(largest.time[np.nanargmax(largest["loop.sideways"])])


def _touches(pair: RopePair) -> bool:
    """Return True if the ropes of a pair touched, as far as their shapes show."""
    return pair.nearest is not None and pair.nearest.clearance <= 0.0


def _rows(
    result: Result,
    hoist: Hoist,
    ropes: Sequence[_Rope],
    pairs: Sequence[RopePair],
    arrival: Arrival,
) -> list[VerdictRow]:
    return [
        *_pulls(result.recording, hoist, ropes),
        *_head_ropes(result.recording, hoist),
        *_emergency_stops(result, hoist),
        *_cycle_time(result, arrival),
        *_rows_of_ropes(ropes, _swings),
        *_rows_of_ropes(ropes, _clearances),
        *_between_ropes(pairs, ropes),
        *_slip_safeties(result, hoist),
        _strikes(ropes, pairs),
        _guards(result.recording, ropes[0]),
        *_rows_of_ropes(ropes, _swivels),
        *_rows_of_ropes(ropes, _errors),
    ]


def _emergency_stops(result: Result, hoist: Hoist) -> Iterator[VerdictRow]:
    for stop in stops(result.recording, result.winding.emergency_at, hoist.sheave_radius):
        text = f"{stop.stopping_distance:.2f} m"
        text += ", and goes on" if stop.time is None else f" in {stop.time:.2f} s"
        if abs(stop.drift) >= SMALLEST_DRIFT:
            direction = "up" if stop.drift > 0.0 else "down"
            text += f", then {abs(stop.drift):.2f} m {direction}"
        if abs(stop.speed) > STILL:
            text += f", at {number(abs(stop.speed), 2)} m/s in the end"
        quantity = f"way of the {stop.side} conveyance in the emergency stop"
        yield VerdictRow(quantity, text, bound="held from then on", holds=stop.held)


def _cycle_time(result: Result, arrival: Arrival) -> Iterator[VerdictRow]:
    needed = ("drive.torque", "reference.position", "conveyance.right.vy")
    if not (result.completed and result.recording.has(*needed)):
        return
    cycle = trip_metrics(result, arrival).get("cycle_time")
    if cycle is not None:
        if math.isfinite(cycle):
            text = f"{cycle:.2f} s"
        else:
            text = "not within the record"
        yield VerdictRow("cycle time, until the conveyances have arrived", text)


def _between_ropes(pairs: Sequence[RopePair], ropes: Sequence[_Rope]) -> Iterator[VerdictRow]:
    for pair in pairs:
        members = [rope for rope in ropes if rope.data.name in (pair.one, pair.other)]
        yield from _between(pair, error=max(rope.loop_error for rope in members))


def _slip_safeties(result: Result, hoist: Hoist) -> Iterator[VerdictRow]:
    for hold in slip_safeties(result, hoist):
        yield VerdictRow(
            f"slip safety {hold.when}",
            hold.text,
            bound=f"at least {hold.required:g}: {hold.rule}",
            holds=hold.sufficient,
            where=f"t = {hold.t:.2f} s",
        )


def _strikes(ropes: Sequence[_Rope], pairs: Sequence[RopePair]) -> VerdictRow:
    names = [rope.data.name or "struck" for rope in ropes if passages(rope.recording)]
    names += [f"{pair.one} on {pair.other}" for pair in pairs if _touches(pair)]
    return VerdictRow(_STRIKES, ", ".join(names) or "none", bound="none", holds=not names)


def _guards(recording: Recording, rope: _Rope) -> VerdictRow:
    causes = [cause for cause in GUARD_CODES.values() if rope.parameter(f"guard.{cause}") > 0.0]
    trip = guard_trip(recording)
    holds = trip is None if causes else None
    bound = ", ".join(causes) or NO_BOUND
    if trip is not None:
        return VerdictRow("guards", f"{trip.cause} tripped", bound, holds, f"t = {trip.t:.2f} s")
    return VerdictRow("guards", "none tripped" if causes else "none set", bound, holds)


def _rows_of_ropes(
    ropes: Sequence[_Rope], rows_of: Callable[[_Rope], Iterator[VerdictRow]]
) -> list[VerdictRow]:
    """Return the rows of all ropes, comparable ones side by side."""
    by_quantity = dict[str, list[tuple[RopeData, VerdictRow]]]()
    for rope in ropes:
        for row in rows_of(rope):
            by_quantity.setdefault(row.quantity, []).append((rope.data, row))
    shown = dict[VerdictRow, None]()  # each row once
    for quantity, rows in by_quantity.items():
        equal = len(rows) == len(ropes) and len({row for _, row in rows}) == 1
        for data, row in rows:
            # rows that are the same for all ropes need no rope's name
            shown[row if equal else replace(row, quantity=data.with_name(quantity))] = None
    return list(shown)


#: Relative error of the forces between two ropes, against the law, that the verdict mentions.
SMALLEST_FORCE_ERROR = 1e-3
_NO_CONTACT = (
    ": each went on as if alone; contact.rope_stiffness = 1e6 and model.fidelity = torsional let "
    "them press each other"
)


def _between(pair: RopePair, error: float) -> Iterator[VerdictRow]:
    """Yield the clearance of two ropes, and how they pressed each other if they may."""
    near = pair.nearest
    if near is not None:
        where = _where(near.t, near.position)
        if near.clearance <= 0.0 and pair.account is None:
            where += _NO_CONTACT
        yield VerdictRow(
            f"clearance between {pair.one} and {pair.other}",
            f"{rounded(near.clearance, error)} m",
            bound=f"above {number(error, 2)} m, its error",
            holds=near.clearance > error,
            where=where,
        )
    account = pair.account
    if account is not None and account.peak > 0.0:
        where = _where(account.peak_t, account.peak_place)
        if account.missed > SMALLEST_FORCE_ERROR:
            where += f"; errs by up to {number(100 * account.missed, 2)} %"
        yield VerdictRow(
            f"force of {pair.one} on {pair.other}", f"{number(account.peak, 3)} N", where=where
        )


def _where(t: float, point: Sequence[float]) -> str:
    """Return instant [s] and place [m] in words."""
    texts = [f"t = {t:.2f} s"]
    for axis, x in zip("xyz", point, strict=True):
        texts.append(f"{axis} = {round(x, 2) + 0.0:.2f} m")
    return ", ".join(texts)


def _pulls(recording: Recording, hoist: Hoist, ropes: Sequence[_Rope]) -> Iterator[VerdictRow]:
    """Yield the pull of all balance ropes on each conveyance, in digits that its error allows."""
    count = max(hoist.tail_rope_number, len(ropes))
    ropes_text = "the rope" if count == 1 else f"all {count} ropes"
    kilo = 1e-3 * hoist.tail_rope_number
    ends = [end for end in SIDES if f"{end}.fy" in recording]
    largest = max((np.nanmax(np.abs(recording[f"{end}.fy"])) for end in ends), default=0.0)
    error = kilo * largest * max(rope.last("status.end_force_error") for rope in ropes)
    for end in ends:
        pull = -kilo * recording[f"{end}.fy"]
        low = int(np.nanargmin(pull))
        high = int(np.nanargmax(pull))
        yield VerdictRow(
            f"pull of {ropes_text} on the {end} conveyance",
            f"{rounded(pull[low], error)} to {rounded(pull[high], error)} kN",
            bound=_HANGS,
            holds=bool(pull[low] > -np.nan_to_num(error)),
            where=f"t = {recording.time[low]:.2f} s and {recording.time[high]:.2f} s",
        )


def _head_ropes(recording: Recording, hoist: Hoist) -> Iterator[VerdictRow]:
    """Yield the smallest pull of all head ropes on either conveyance."""
    if hoist.slack_tension is None:
        threshold = 0.0
        bound = "above 0: slack"
    else:
        threshold = hoist.slack_tension
        bound = f"above {number(1e-3 * threshold, 3)} kN, slack_tension"
    for side in SIDES:
        name = f"drive.pull_{side}"
        if name not in recording:
            continue
        row = int(np.argmin(recording[name]))
        smallest_force = float(recording[name][row])
        yield VerdictRow(
            f"smallest pull of the head ropes, {side}",
            f"{number(1e-3 * smallest_force, 3)} kN",
            bound=bound,
            holds=smallest_force > threshold,
            where=f"t = {recording.time[row]:.2f} s",
        )


def _swings(rope: _Rope) -> Iterator[VerdictRow]:
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


def _bound_of_guard(rope: _Rope, guard: str) -> float:
    """Return the bound of a guard of the loop; 0 for none.

    A guard with a height watches the legs instead, or counts the rise from there.
    """
    height = float(rope.data.parameters.get(f"guard.{guard}_y", -FAR))
    if height > -FAR:
        return 0.0
    return rope.parameter(f"guard.{guard}")


def _loop_place(rope: _Rope, row: int) -> str:
    """Return x and z of the loop in the shaft at a row, in words, as far as they are computed."""
    text = ""
    for axis, origin in zip("xz", rope.data.suspension.origin[::2], strict=True):
        place = float(rope.recording[f"loop.{axis}"][row]) + origin
        if math.isfinite(place):
            text += f", {axis} = {rounded(place, rope.loop_error)} m"
    return text


def _clearances(rope: _Rope) -> Iterator[VerdictRow]:
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


def _swivels(rope: _Rope) -> Iterator[VerdictRow]:
    texts = dict[str, str]()
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


def _slip_text(rope: _Rope, end: str) -> str:
    """Return for how long the swivel of an end slipped, in words."""
    if end in rope.data.locked:
        return "locked"
    slipping = rope.recording[f"{end}.swivel.slipping"][:-1] > 0.0
    slipped = float(np.sum(np.diff(rope.recording.time) * slipping))
    if slipped:
        return f"{slipped:.2f} s"
    return "none"


def _errors(rope: _Rope) -> Iterator[VerdictRow]:
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


def rounded(value: float, error: float) -> str:
    """Return a number with the decimals that its error allows, three at most.

    An unknown error leaves three digits.
    """
    if not error > 0.0:
        return number(value, 3)
    decimals = min(3, max(0, round(-math.log10(error))))
    return f"{round(value, decimals) + 0.0:.{decimals}f}"
