"""The rest of a run in a table, behind the verdict: drive, loads, energy balances and the clock.

Each row stands for itself; rows whose signals were not recorded are left out.
"""

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import SIDES, Arrival, Coupling, Hoist, Winding
from hoist_demo.recording.fidelity import fidelities_of
from hoist_demo.recording.ropes import rope_signals
from hoist_demo.recording.time_series import Array, Recording
from hoist_demo.report.formatting import number, unit_text
from hoist_demo.report.rows import SummaryRow
from hoist_demo.run.metrics import exchange_energy

#: What the rope loses only where its scene has that, in words.
ELSEWHERE = {
    "energy.dissipated_contact": "dissipated in contact",
    "energy.dissipated_wires": "dissipated between its wires",
    "energy.given_to_air": "given to the air",
}

#: All that the rope loses, in words for a figure.
LOSSES = {
    "energy.dissipated_material": "in the rope",
    "energy.dissipated_swivel": "in the swivels",
} | ELSEWHERE


def _largest(values: Array) -> float:
    """Return the largest magnitude."""
    return float(np.nanmax(np.abs(values)))


def _minimum(values: Array) -> float:
    return float(np.nanmin(values))


def _last(values: Array) -> float:
    return float(values[-1])


def _rough(values: Array) -> str:
    """Format the value of largest magnitude of an error, in the two digits that it has."""
    return number(float(values[np.nanargmax(np.abs(values))]), 2)


_DRIVE = "Drive"
_ROPE = "Balance rope"
_WORK = "Energy of the drive"
_ENERGY = "Energy of one balance rope"


class _Unit(NamedTuple):
    """Unit of a row, and the factor that leads from SI to it."""

    name: str
    factor: float


_SPEED = _Unit("m/s", 1.0)
_LENGTH = _Unit("m", 1.0)
_DEGREE = _Unit("deg", 180.0 / math.pi)
_FORCE = _Unit("kN", 1e-3)
_TORQUE = _Unit("N m", 1.0)
_DRIVE_TORQUE = _Unit("kN m", 1e-3)
_STRESS = _Unit("MPa", 1e-6)
_JOULE = _Unit("J", 1.0)
_KILOJOULE = _Unit("kJ", 1e-3)


class _SignalRow(NamedTuple):
    """Row of the summary that one function reduces from signals."""

    group: str
    quantity: str
    signals: tuple[str, ...]
    unit: _Unit
    reduce: Callable[[Array], float | str]


_HEAD_ROPE_TENSIONS = ("drive.tension_left", "drive.tension_right")
_SWIVEL_TORQUES = ("left.swivel.torque", "right.swivel.torque")
_ROPE_WORK = ("drive.work_from_balance_rope",)
_RESIDUAL = "residual, furthest from 0 (negative: lost by the time steps)"

_ROWS = (
    _SignalRow(_DRIVE, "peak speed", ("conveyance.left.vy",), _SPEED, _largest),
    _SignalRow(_DRIVE, "peak motor torque", ("drive.torque",), _DRIVE_TORQUE, _largest),
    _SignalRow(_DRIVE, "largest head rope tension", _HEAD_ROPE_TENSIONS, _FORCE, _largest),
    _SignalRow(_ROPE, "lowest point of the loop", ("loop.y",), _LENGTH, _minimum),
    _SignalRow(_ROPE, "largest yaw of the loop", ("loop.yaw",), _DEGREE, _largest),
    _SignalRow(_ROPE, "largest torque at a swivel", _SWIVEL_TORQUES, _TORQUE, _largest),
    _SignalRow(_ROPE, "largest bending stress", ("stress.bending_max",), _STRESS, _largest),
    _SignalRow(_ROPE, "largest torsional stress", ("stress.torsion_max",), _STRESS, _largest),
    _SignalRow(_WORK, "motor work", ("drive.work_motor",), _KILOJOULE, _last),
    _SignalRow(_WORK, "losses", ("drive.work_losses",), _KILOJOULE, _last),
    _SignalRow(_WORK, "of it head ropes that slid", ("drive.work_slip",), _KILOJOULE, _last),
    _SignalRow(_WORK, "damping of the head ropes", ("drive.work_rope_damping",), _KILOJOULE, _last),
    _SignalRow(
        _WORK, "work of all balance ropes on the conveyances", _ROPE_WORK, _KILOJOULE, _last
    ),
    _SignalRow(_WORK, "residual, largest", ("drive.energy_residual",), _JOULE, _rough),
    _SignalRow(_ENERGY, "work at its ends", ("energy.work_ends",), _KILOJOULE, _last),
    *(
        _SignalRow(_ENERGY, f"dissipated {place}", (signal,), _KILOJOULE, _last)
        for place, signal in (
            ("in the rope", "energy.dissipated_material"),
            ("in the swivels", "energy.dissipated_swivel"),
        )
    ),
    *(
        _SignalRow(_ENERGY, words, (signal,), _KILOJOULE, _last)
        for signal, words in ELSEWHERE.items()
    ),
    _SignalRow(_ENERGY, "largest kinetic energy", ("energy.kinetic",), _JOULE, _largest),
    _SignalRow(_ENERGY, _RESIDUAL, ("energy.residual",), _JOULE, _rough),
)


def summarize(
    result: Result,
    hoist: Hoist,
    winding: Winding,
    coupling: Coupling,
    names: Sequence[str] = ("",),
    arrival: Arrival | None = None,
) -> tuple[SummaryRow, ...]:
    """Return all rows of a run, in reading order; ``names`` are those of its ropes."""
    rows: list[SummaryRow] = []
    recording = result.recording
    if recording.signals:
        window = (arrival or Arrival()).window
        rows += _trip(recording, hoist, winding)
        rows += _swing(recording, result.trajectory.duration, window)
        rows += _signals(recording, (_DRIVE, _WORK))
        if names[0]:
            rows += _moments(recording)
        for name in names:
            of_rope = f", {name}" if name else ""
            for row in _rope_rows(recording, name):
                rows.append(replace(row, group=f"{row.group}{of_rope}"))
        if "energy.work_ends" in recording:
            defect = _rough(exchange_energy(recording, hoist))
            quantity = "energy that the coupling's delay makes up, largest"
            rows.append(SummaryRow(_WORK, quantity, defect, "J"))
    groups = list(dict.fromkeys(row.group for row in rows))
    rows.sort(key=lambda row: groups.index(row.group))
    return (*rows, *_clock(result, coupling))


def _rope_rows(recording: Recording, name: str) -> Iterator[SummaryRow]:
    rope = rope_signals(recording, name)
    if name:
        pull = rope["left.fy"] + rope["right.fy"]
        pull_of_all = recording["left.fy"] + recording["right.fy"]
        percent = 100.0 * (pull / pull_of_all[: len(rope.time)])
        at_rest = number(percent[0], 3)
        low = number(percent.min(), 3)
        high = number(percent.max(), 3)
        text = f"{at_rest} %, in motion {low} to {high} %"
        yield SummaryRow(_ROPE, "share of the pull of all, at rest", text)
    yield from _signals(rope, (_ROPE, _ENERGY))
    fidelities = fidelities_of(rope)
    if fidelities:
        yield SummaryRow(_ROPE, "fidelity of the model that ran", ", then ".join(fidelities))


_MOMENTS = {"mx": "tilt about X", "my": "moment about Y", "mz": "tilt about Z"}


def _moments(recording: Recording) -> Iterator[SummaryRow]:
    """Yield the moments of several ropes about the conveyances' centres."""
    for end in SIDES:
        group = f"All ropes on the {end} conveyance, about its centre"
        for component, label in _MOMENTS.items():
            moment = recording[f"{end}.{component}"]
            if bool(np.isfinite(moment).any()):
                yield SummaryRow(group, label, _largest(moment), "N m")


def _signals(recording: Recording, groups: Collection[str]) -> Iterator[SummaryRow]:
    for row in _ROWS:
        if row.group not in groups:
            continue
        recorded = [
            recording[name] for name in row.signals if name in recording and loses(recording, name)
        ]
        if not recorded:
            continue
        values = np.concatenate(recorded)
        # signals that the fidelity leaves out are NaN throughout
        if bool(np.isfinite(values).any()):
            value = row.reduce(row.unit.factor * values)
            yield SummaryRow(row.group, row.quantity, value, row.unit.name)


def loses(recording: Recording, name: str) -> bool:
    """Return True if a loss of energy is shown.

    A loss that not every scene has is shown if it is not 0.
    """
    return not name.endswith((*ELSEWHERE, "drive.work_slip")) or bool(np.any(recording[name]))


class _LargestOf(NamedTuple):
    """Column of the table of exposure whose largest value is shown."""

    column: str
    label: str
    qualifier: str = ""  # column of its time or frequency


_LARGEST_OF = (
    _LargestOf("curvature.range", "largest range of curvature in a cycle"),
    _LargestOf("torque.range", "largest range of torque in a cycle"),
    _LargestOf("tension.range", "largest range of tension in a cycle"),
    _LargestOf("tension.largest", "largest tension", "tension.largest_at"),
    _LargestOf("torque.amplitude", "strongest vibration of torque", "torque.frequency"),
    _LargestOf("tension.amplitude", "strongest vibration of tension", "tension.frequency"),
    _LargestOf("bent", "longest time in the bend"),
)


def exposure_rows(rope: str, table: Recording) -> tuple[SummaryRow, ...]:
    """Return rows on the most loaded places of a rope.

    ``table`` is one of ``hoist_demo.recording.exposure``.
    """
    group = f"Places in the rope {rope}".rstrip() + ", from its left end"
    rows: list[SummaryRow] = []

    def quantity(column: str, station: int) -> str:
        return f"{number(float(table[column][station]), 4)} {unit_text(table.units[column])}"

    for one in _LARGEST_OF:
        values = table[one.column]
        if bool(np.isfinite(values).all()) and bool(np.any(values)):
            station = int(np.argmax(values))
            text = f"{quantity(one.column, station)} at {quantity('s', station)}"
            if one.qualifier:
                text += f", {quantity(one.qualifier, station)}"
            rows.append(SummaryRow(group, one.label, text))
    return tuple(rows)


def _trip(recording: Recording, hoist: Hoist, winding: Winding) -> list[SummaryRow]:
    travel = recording["conveyance.left.y"] - recording["conveyance.left.y"][0]
    error = recording["reference.position"] - travel
    return [
        SummaryRow(_DRIVE, "travel asked for", winding.travel, "m"),
        SummaryRow(_DRIVE, "travel reached, left conveyance", float(travel[-1]), "m"),
        *_tracking(_DRIVE, 1e3 * error, recording.time - recording.time[0], winding),
        SummaryRow(
            _DRIVE, "time at the torque limit", recording.seconds("drive.torque_limited"), "s"
        ),
        SummaryRow(_DRIVE, "tension ratio at which the head ropes slip", hoist.tension_ratio_limit),
    ]


def _tracking(group: str, error: Array, elapsed: Array, winding: Winding) -> list[SummaryRow]:
    """Return errors [mm] while the drive follows the reference, until the brake trips."""
    follows = elapsed <= winding.tracking_end
    last = "final position error"
    until = ""
    if not bool(follows.all()):
        last = "position error at the trip"
        until = " until then"
    elif winding.emergency_at is not None and winding.emergency_at <= elapsed[-1]:
        last = "final error against the stop's reference"
    return [
        SummaryRow(group, last, float(error[follows][-1]), "mm"),
        SummaryRow(group, f"largest tracking error{until}", _largest(error[follows]), "mm"),
    ]


def _swing(recording: Recording, arrival: float, window: float) -> list[SummaryRow]:
    """Return the swing of both conveyances in a window [s] after the reference's arrival [s]."""
    elapsed = recording.time - recording.time[0]
    in_window = (elapsed >= arrival) & (elapsed <= arrival + window)
    if not bool(in_window.any()):
        return []
    within = f"within {float(np.ptp(elapsed[in_window])):.2g} s, peak to peak"
    rows = []
    for end in SIDES:
        swing = 1e3 * float(np.ptp(recording[f"conveyance.{end}.y"][in_window]))
        rows.append(SummaryRow(_DRIVE, f"swing after arrival, {end}, {within}", swing, "mm"))
    return rows


def _clock(result: Result, coupling: Coupling) -> list[SummaryRow]:
    group = "Clock"
    simulated = result.steps * coupling.step
    both = result.rope_clock.wall + result.drive_clock.wall
    rows = [
        SummaryRow(group, "simulated time", simulated, "s"),
        SummaryRow(group, "communication step", coupling.step, "s"),
        SummaryRow(group, "rope, initialization, wall", result.start_clock.wall, "s"),
        SummaryRow(group, "rope, wall", result.rope_clock.wall, "s"),
        SummaryRow(group, "drive, wall", result.drive_clock.wall, "s"),
    ]
    if result.rope_clock.wall > 0.0:
        rows.append(SummaryRow(group, "real-time factor, rope", simulated / result.rope_clock.wall))
        rows.append(SummaryRow(group, "real-time factor, rope and drive", simulated / both))
    return rows
