"""Rows of the verdict on the hoist: pulls, emergency stops, time of a cycle, slip."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import SIDES, Arrival, Hoist
from hoist_demo.recording.incidents import STILL, stops
from hoist_demo.recording.time_series import Recording
from hoist_demo.report.formatting import number, rounded
from hoist_demo.report.rope_record import RopeRecord
from hoist_demo.report.verdict_row import VerdictRow
from hoist_demo.run.metrics import trip_metrics
from hoist_demo.run.slip import slip_safeties

_HANGS = "above 0: a rope only pulls"
#: Shortest way of a conveyance after an emergency stop that the verdict mentions [m].
SMALLEST_DRIFT = 5e-3


def pulls(recording: Recording, hoist: Hoist, ropes: Sequence[RopeRecord]) -> Iterator[VerdictRow]:
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


def head_ropes(recording: Recording, hoist: Hoist) -> Iterator[VerdictRow]:
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


def emergency_stops(result: Result, hoist: Hoist) -> Iterator[VerdictRow]:
    """Yield the way of each conveyance in an emergency stop."""
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


def cycle_time(result: Result, arrival: Arrival) -> Iterator[VerdictRow]:
    """Yield the time until both conveyances have arrived, of a completed trip."""
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


def slip_rows(result: Result, hoist: Hoist) -> Iterator[VerdictRow]:
    """Yield the slip safeties of the head ropes on the sheave."""
    for hold in slip_safeties(result, hoist):
        yield VerdictRow(
            f"slip safety {hold.when}",
            hold.text,
            bound=f"at least {hold.required:g}: {hold.rule}",
            holds=hold.sufficient,
            where=f"t = {hold.t:.2f} s",
        )
