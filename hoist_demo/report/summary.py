"""A run in a table: what a hoist engineer asks, the rope's work counters, energy balances and the clock.

Each row stands for itself; rows whose signals were not recorded are left out.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hoist_demo.cosimulation.drive_signals import exchange_energy
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Coupling, Hoist, Winding
from hoist_demo.recording.fidelity import fidelities_of, remark
from hoist_demo.recording.incidents import (
    AFTER,
    after,
    guard_trip,
    jams,
    largest_ratio,
    slack_ropes,
    slip,
    told,
    told_of_jams,
    told_of_slip,
)
from hoist_demo.recording.passages import BODIES, outcome_of, passages
from hoist_demo.recording.time_series import Array, Recording
from hoist_demo.report.html.page import number, unit_text
from hoist_demo.report.rows import CAUSE, OUTCOME, WARNING, SummaryRow
from hoist_demo.study.slip import slip_warning

SWING_WINDOW = 5.0  #: Length of the record's tail over which the residual swing is judged [s].


#: What the rope loses only where its scene has that, in words.
ELSEWHERE = {
    "energy.dissipated_contact": "dissipated in contact",
    "energy.dissipated_wires": "dissipated between its wires",
    "energy.given_to_air": "given to the air",
}

#: All that the rope loses, in words for a figure.
LOSSES = {"energy.dissipated_material": "in the rope", "energy.dissipated_swivel": "in the swivels"} | ELSEWHERE

AT_REST = 0.01  #: Speed of the sheave's rim that counts as standstill [m/s].


def summarize(result: Result, hoist: Hoist, winding: Winding, coupling: Coupling) -> tuple[SummaryRow, ...]:
    """All rows of a run, in reading order."""
    rows = _outcome(result, hoist, coupling)
    if len(result.recording.signals):
        recording = result.recording
        rows += (
            _trip(recording, hoist, winding)
            + _swing(recording, result.trajectory.duration)
            + _after_guard(recording)
            + _after_jam(recording, hoist)
            + _slip(recording)
            + _rope(recording, hoist)
            + _energy(recording, hoist)
            + _counts(recording)
        )
    return tuple(rows + _clock(result, coupling))


#: Columns of the table of exposure, what their largest value is called, and the column that tells when or how fast.
_MOST = {
    "curvature.range": ("largest range of curvature in a cycle", ""),
    "torque.range": ("largest range of torque in a cycle", ""),
    "tension.range": ("largest range of tension in a cycle", ""),
    "tension.largest": ("largest tension", "largest_at"),
    "torque.amplitude": ("strongest vibration of torque", "frequency"),
    "tension.amplitude": ("strongest vibration of tension", "frequency"),
    "bent": ("longest time in the bend", ""),
}


def exposure_rows(exposed: Recording) -> tuple[SummaryRow, ...]:
    """Return rows on the most loaded places of the rope; `exposed` is a table of `hoist_demo.recording.exposure`."""
    rows: list[SummaryRow] = []
    for name, (words, beside) in _MOST.items():
        if bool(np.isfinite(exposed[name]).all()) and bool(np.any(exposed[name])):
            k = int(np.argmax(exposed[name]))
            parts = [(name, ""), ("s", " at "), *([(f"{name.partition('.')[0]}.{beside}", ", ")] if beside else [])]
            text = "".join(
                f"{join}{number(float(exposed[key][k]))} {unit_text(exposed.units[key])}" for key, join in parts
            )
            rows.append(SummaryRow("Places in the rope, from its left end", words, text))
    return tuple(rows)


def _outcome(result: Result, hoist: Hoist, coupling: Coupling) -> list[SummaryRow]:
    group = OUTCOME
    rows = [
        SummaryRow(group, "status", status(result.completed, result.recording)),
        SummaryRow(group, "simulated time", result.steps * coupling.step, "s"),
        SummaryRow(group, "communication step", coupling.step, "s"),
        SummaryRow(group, "communication steps done", float(result.steps)),
    ]
    if result.cause:
        rows.insert(1, SummaryRow(group, CAUSE, result.cause))
    return rows + [SummaryRow(group, WARNING, text) for text in warnings(result, hoist)]


def status(completed: bool, recording: Recording) -> str:
    """Return the outcome and the events of a run, in words."""
    return outcome_of(completed, passages(recording)) + incidents(recording)


def incidents(recording: Recording) -> str:
    """Guards that tripped, conveyances that jammed, head ropes that went slack or slipped: the end of a sentence."""
    return told(recording) + told_of_jams(recording) + told_of_slip(recording)


def warnings(result: Result, hoist: Hoist) -> list[str]:
    """List the warnings that readers of the numbers need.

    An unstable coupling, ropes that a real sheave would not hold, and what the rope's fidelity leaves out.
    """
    texts = result.warning, slip_warning(result.recording, hoist, result.winding), remark(result.recording)
    return [text for text in texts if text]


def _trip(recording: Recording, hoist: Hoist, winding: Winding) -> list[SummaryRow]:
    group = "Drive"
    travel = recording["conveyance.left.y"] - recording["conveyance.left.y"][0]
    error = recording["reference.position"] - travel
    ratio = largest_ratio(recording, hoist.tension_ratio_limit)
    return [
        SummaryRow(group, "travel asked for", winding.travel, "m"),
        SummaryRow(group, "travel reached, left conveyance", float(travel[-1]), "m"),
        *_tracking(group, 1e3 * error, recording.time - recording.time[0], winding),
        *_stopping(group, recording, hoist, winding),
        SummaryRow(group, "peak speed", _largest(recording["conveyance.left.vy"]), "m/s"),
        SummaryRow(group, "peak motor torque", _largest(1e-3 * recording["drive.torque"]), "kN m"),
        SummaryRow(group, "time at the torque limit", _duration(recording, "drive.torque_limited"), "s"),
        SummaryRow(group, "largest head rope tension", _largest(1e-3 * _tensions(recording)), "kN"),
        SummaryRow(group, "largest tension ratio on the sheave", ratio),
        SummaryRow(group, "ratio at which the ropes slip", hoist.tension_ratio_limit),
        SummaryRow(group, "smallest slip safety, (limit - 1) / (ratio - 1)", hoist.slip_safety(ratio)),
    ]


def _slip(recording: Recording) -> list[SummaryRow]:
    if (slid := slip(recording)) is None:
        return []
    group = "Head ropes that slipped"
    return [
        SummaryRow(group, "from", slid.t, "s"),
        SummaryRow(group, "for", slid.duration, "s"),
        SummaryRow(group, "way on the sheave", slid.way, "m"),
        SummaryRow(group, "of it left in the end", slid.net, "m"),
        SummaryRow(group, "largest speed on the sheave", slid.speed, "m/s"),
        SummaryRow(group, "work of the friction", 1e-3 * float(recording["drive.work_slip"][-1]), "kJ"),
    ]


def _tracking(group: str, error: Array, elapsed: Array, winding: Winding) -> list[SummaryRow]:
    """Errors [mm] while the drive follows the reference; once the brake has tripped there is nothing to follow."""
    follows = elapsed <= winding.tracking_end
    last, until = "final position error", ""
    if not bool(follows.all()):
        last, until = "position error at the trip", " until then"
    elif winding.emergency_at is not None and winding.emergency_at <= elapsed[-1]:
        last = "final error against the stop's reference"
    return [
        SummaryRow(group, last, float(error[follows][-1]), "mm"),
        SummaryRow(group, f"largest tracking error{until}", _largest(error[follows]), "mm"),
    ]


def _stopping(group: str, recording: Recording, hoist: Hoist, winding: Winding) -> list[SummaryRow]:
    """Way and time of an emergency stop, at the sheave's rim."""
    if winding.emergency_at is None:
        return []
    begun = recording.time - recording.time[0] >= winding.emergency_at
    at_rest = begun & (np.abs(hoist.sheave_radius * recording["drive.rate"]) < AT_REST)
    if not bool(at_rest.any()):
        return [SummaryRow(group, "emergency stop", "not at rest within the record")]
    first, last = int(np.argmax(begun)), int(np.argmax(at_rest))
    way = hoist.sheave_radius * abs(float(recording["drive.angle"][last] - recording["drive.angle"][first]))
    return [
        SummaryRow(group, "emergency stop, way to standstill at the rim", way, "m"),
        SummaryRow(
            group, "emergency stop, time to standstill", float(recording.time[last] - recording.time[first]), "s"
        ),
    ]


def _swing(recording: Recording, arrival: float) -> list[SummaryRow]:
    """Swing of both conveyances at the end of the record, counted from the arrival of the reference [s] at most."""
    elapsed = recording.time - recording.time[0]
    tail = (elapsed >= arrival) & (elapsed >= elapsed[-1] - SWING_WINDOW)
    if not bool(tail.any()):
        return []
    seconds = float(np.ptp(elapsed[tail]))
    return [
        SummaryRow(
            "Drive",
            f"residual swing, {end}, last {seconds:.2g} s, peak to peak",
            1e3 * float(np.ptp(recording[f"conveyance.{end}.y"][tail])),
            "mm",
        )
        for end in ("left", "right")
    ]


def _rope(recording: Recording, hoist: Hoist) -> list[SummaryRow]:
    group = "Balance rope"
    rows: list[SummaryRow] = []
    if hoist.tail_rope_number > 1:
        rows.append(SummaryRow(group, "equal balance ropes; forces and energies are of one", hoist.tail_rope_number))
    if fidelities := fidelities_of(recording):
        rows.append(SummaryRow(group, "fidelity of the model that ran", ", then ".join(fidelities)))
    for end in ("left", "right"):
        rows.append(SummaryRow(group, f"largest pull on the {end} conveyance", _pull(recording[f"{end}.fy"]), "kN"))
    for end in ("left", "right"):
        # one that hangs only pulls; slack, a real one gives way to the sides sooner than elements of some length
        if (push := _pull(-recording[f"{end}.fy"])) > 0.0:
            quantity = f"slack, it pushes the {end} conveyance up by (a real one gives way)"
            rows.append(SummaryRow(group, quantity, push, "kN"))
    extremes: tuple[tuple[str, str, float, str, Any], ...] = (
        ("loop.y", "lowest point of the loop", 1.0, "m", np.nanmin),
        ("loop.clearance", "smallest clearance between the legs", 1.0, "m", np.nanmin),
        *(
            (f"nearest.{kind}.clearance", f"smallest clearance from {words}", 1.0, "m", np.nanmin)
            for kind, words in BODIES.items()
        ),
        ("loop.turns", "largest turns of the legs about each other", 1.0, "", _largest),
        ("loop.yaw", "largest yaw of the loop", 180.0 / math.pi, "deg", _largest),
        ("loop.z", "largest out-of-plane position of the loop", 1.0, "m", _largest),
        ("left.swivel.torque", "largest torque at the left swivel", 1.0, "N m", _largest),
        ("right.swivel.torque", "largest torque at the right swivel", 1.0, "N m", _largest),
        ("stress.bending_max", "largest bending stress", 1e-6, "MPa", np.nanmax),
        ("stress.torsion_max", "largest torsional stress", 1e-6, "MPa", np.nanmax),
    )
    for name, quantity, factor, unit, extreme in extremes:
        # what the fidelity leaves out is NaN throughout
        if name in recording and bool(np.isfinite(recording[name]).any()):
            rows.append(SummaryRow(group, quantity, float(extreme(factor * recording[name])), unit))
    if recording.has("left.swivel.slipping", "right.swivel.slipping"):
        for end in ("left", "right"):
            slipped = _duration(recording, f"{end}.swivel.slipping")
            if math.isfinite(slipped):
                rows.append(SummaryRow(group, f"time the {end} swivel slipped", slipped, "s"))
    return rows


def _after_guard(recording: Recording) -> list[SummaryRow]:
    """Return rows on the rope in the seconds after a guard's trip."""
    if (trip := guard_trip(recording)) is None:
        return []
    group = f"After the guard's trip, {AFTER:g} s"
    rows = [SummaryRow(group, "tripped at", trip.t, "s"), SummaryRow(group, "by", trip.cause)]
    return rows + [SummaryRow(group, *row) for row in after(trip.t, recording)]


def _after_jam(recording: Recording, hoist: Hoist) -> list[SummaryRow]:
    """Return rows on a jam, slack head ropes, and the rope in the seconds after it."""
    rows: list[SummaryRow] = []
    for jam in jams(recording):
        group, way = f"Jam of the {jam.side} conveyance", jam.way
        rows += [
            SummaryRow(group, "caught at", jam.t, "s"),
            SummaryRow(group, "at the height", jam.height, "m"),
            SummaryRow(group, "way to standstill", *(("none, it went through", "") if way is None else (way, "m"))),
            SummaryRow(group, "largest acceleration until then", jam.deceleration, "m/s2"),
            *(SummaryRow(f"After the jam, {AFTER:g} s", *row) for row in after(jam.t, recording)),
        ]
    group = "Slack head ropes"
    for slack in slack_ropes(recording):
        rows += [
            SummaryRow(group, f"{slack.side}, from", slack.t, "s"),
            SummaryRow(group, f"{slack.side}, for", slack.duration, "s"),
            SummaryRow(group, f"{slack.side}, at most", slack.length, "m"),
        ]
    opened = seen_slack(recording, hoist)
    return rows if opened is None else [*rows, SummaryRow(group, "seen by the safety circuit at", opened, "s")]


def seen_slack(recording: Recording, hoist: Hoist) -> float | None:
    """First sample at which the safety circuit sees too little tension of the head ropes [s]."""
    if hoist.slack_tension is None or not recording.has("drive.pull_left", "drive.pull_right"):
        return None
    low = np.minimum(recording["drive.pull_left"], recording["drive.pull_right"]) < hoist.slack_tension
    return float(recording.time[np.argmax(low)]) if bool(low.any()) else None


def _energy(recording: Recording, hoist: Hoist) -> list[SummaryRow]:
    group = "Energy balance"
    drive = "drive.work_from_balance_rope"
    rows = [
        SummaryRow(group, "motor work", 1e-3 * float(recording["drive.work_motor"][-1]), "kJ"),
        SummaryRow(group, "losses", 1e-3 * float(recording["drive.work_losses"][-1]), "kJ"),
        SummaryRow(group, "damping of the head ropes", 1e-3 * float(recording["drive.work_rope_damping"][-1]), "kJ"),
        SummaryRow(group, f"work of {_all_ropes(hoist)} on the conveyances", 1e-3 * float(recording[drive][-1]), "kJ"),
        SummaryRow(group, "residual of the drive, largest", _largest(recording["drive.energy_residual"]), "J"),
    ]
    of_one = "" if hoist.tail_rope_number == 1 else ", of one rope"
    for name, quantity in (
        ("energy.work_ends", "work on the balance rope at its ends"),
        ("energy.dissipated_material", "dissipated in the balance rope"),
        ("energy.dissipated_swivel", "dissipated in the swivels"),
        *ELSEWHERE.items(),
    ):
        # what the fidelity leaves out is NaN throughout
        if name in recording and math.isfinite(recording[name][-1]) and loses(recording, name):
            rows.append(SummaryRow(group, f"{quantity}{of_one}", 1e-3 * float(recording[name][-1]), "kJ"))
    if recording.has("energy.residual", "energy.kinetic"):
        residual, kinetic = _furthest(recording["energy.residual"]), float(np.max(recording["energy.kinetic"]))
        quantity = "residual of the rope, furthest from 0 (dissipated by the time steps: negative)"
        rows.append(SummaryRow(group, quantity, residual, "J"))
        if kinetic > 0.0:
            share = 100.0 * residual / kinetic
            rows.append(SummaryRow(group, "the same over the rope's largest kinetic energy", share, "%"))
    if "energy.work_ends" in recording:
        defect = exchange_energy(recording, hoist)
        rows.append(SummaryRow(group, "energy that the coupling's delay makes up, largest", _largest(defect), "J"))
    return rows


def loses(recording: Recording, name: str) -> bool:
    """Return True if a loss of energy is to be shown: one of ELSEWHERE only if it is not 0."""
    return name not in ELSEWHERE or bool(np.any(recording[name]))


def _all_ropes(hoist: Hoist) -> str:
    number = hoist.tail_rope_number
    return "the balance rope" if number == 1 else f"all {number} balance ropes"


def _counts(recording: Recording) -> list[SummaryRow]:
    names = (
        ("count.steps", "internal steps"),
        ("count.rejections", "rejected steps"),
        ("count.transformations", "mesh transformations"),
        ("count.newton", "Newton iterations"),
    )
    return [SummaryRow("Effort of the rope", q, float(recording[name][-1])) for name, q in names if name in recording]


def _clock(result: Result, coupling: Coupling) -> list[SummaryRow]:
    group = "Clock"
    simulated = result.steps * coupling.step
    both = result.rope_clock.wall + result.drive_clock.wall
    rows = [
        SummaryRow(group, "rope, initialization, wall", result.start_clock.wall, "s"),
        SummaryRow(group, "rope, wall", result.rope_clock.wall, "s"),
        SummaryRow(group, "drive, wall", result.drive_clock.wall, "s"),
    ]
    if result.rope_clock.wall > 0.0:
        rows.append(SummaryRow(group, "real-time factor, rope", simulated / result.rope_clock.wall))
        rows.append(SummaryRow(group, "real-time factor, rope and drive", simulated / both))
    return rows


def _largest(values: Array) -> float:
    """Value of largest magnitude, without its sign."""
    return float(np.nanmax(np.abs(values)))


def _furthest(values: Array) -> float:
    """Value of largest magnitude, with its sign."""
    return float(values[np.argmax(np.abs(values))])


def _pull(force: Array) -> float:
    """Largest downward force [kN]."""
    return float(np.max(-1e-3 * force))


def _tensions(recording: Recording) -> Array:
    return np.concatenate([recording["drive.tension_left"], recording["drive.tension_right"]])


def _duration(recording: Recording, flag: str) -> float:
    """Time during which a 0/1 signal is 1 [s], each value holding until the next row."""
    return float(np.sum(np.diff(recording.time) * recording[flag][:-1]))
