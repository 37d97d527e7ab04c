"""The rest of a run in a table, behind the verdict: drive, loads, energy balances and the clock.

Each row stands for itself; rows whose signals were not recorded are left out.
"""

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import SIDES, Arrival, Coupling, Hoist, Winding
from hoist_demo.recording.fidelity import fidelities_of
from hoist_demo.recording.ropes import rope_signals
from hoist_demo.recording.time_series import Array, Recording
from hoist_demo.report.html.page import number, unit_text
from hoist_demo.report.rows import SummaryRow
from hoist_demo.study.metrics import exchange_energy

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


def _least(values: Array) -> float:
    return float(np.nanmin(values))


def _last(values: Array) -> float:
    return float(values[-1])


def _rough(values: Array) -> str:
    """Format the value of largest magnitude of an error, in the two digits that it has."""
    return number(float(values[np.nanargmax(np.abs(values))]), 2)


_DRIVE, _ROPE, _WORK, _ENERGY = (
    "Drive",
    "Balance rope",
    "Energy of the drive",
    "Energy of one balance rope",
)

#: Group and quantity, signals, factor and unit, and the function that reduces the signals to a
#: value.
_ROWS: tuple[tuple[str, str, tuple[str, ...], float, str, Callable[[Array], float | str]], ...] = (
    (_DRIVE, "peak speed", ("conveyance.left.vy",), 1.0, "m/s", _largest),
    (_DRIVE, "peak motor torque", ("drive.torque",), 1e-3, "kN m", _largest),
    (
        _DRIVE,
        "largest head rope tension",
        ("drive.tension_left", "drive.tension_right"),
        1e-3,
        "kN",
        _largest,
    ),
    (_ROPE, "lowest point of the loop", ("loop.y",), 1.0, "m", _least),
    (_ROPE, "largest yaw of the loop", ("loop.yaw",), 180.0 / math.pi, "deg", _largest),
    (
        _ROPE,
        "largest torque at a swivel",
        ("left.swivel.torque", "right.swivel.torque"),
        1.0,
        "N m",
        _largest,
    ),
    (_ROPE, "largest bending stress", ("stress.bending_max",), 1e-6, "MPa", _largest),
    (_ROPE, "largest torsional stress", ("stress.torsion_max",), 1e-6, "MPa", _largest),
    (_WORK, "motor work", ("drive.work_motor",), 1e-3, "kJ", _last),
    (_WORK, "losses", ("drive.work_losses",), 1e-3, "kJ", _last),
    (_WORK, "of it head ropes that slid", ("drive.work_slip",), 1e-3, "kJ", _last),
    (_WORK, "damping of the head ropes", ("drive.work_rope_damping",), 1e-3, "kJ", _last),
    (
        _WORK,
        "work of all balance ropes on the conveyances",
        ("drive.work_from_balance_rope",),
        1e-3,
        "kJ",
        _last,
    ),
    (_WORK, "residual, largest", ("drive.energy_residual",), 1.0, "J", _rough),
    (_ENERGY, "work at its ends", ("energy.work_ends",), 1e-3, "kJ", _last),
    (_ENERGY, "dissipated in the rope", ("energy.dissipated_material",), 1e-3, "kJ", _last),
    (_ENERGY, "dissipated in the swivels", ("energy.dissipated_swivel",), 1e-3, "kJ", _last),
    *((_ENERGY, words, (name,), 1e-3, "kJ", _last) for name, words in ELSEWHERE.items()),
    (_ENERGY, "largest kinetic energy", ("energy.kinetic",), 1.0, "J", _largest),
    (
        _ENERGY,
        "residual, furthest from 0 (negative: lost by the time steps)",
        ("energy.residual",),
        1.0,
        "J",
        _rough,
    ),
)


def summarize(
    result: Result,
    hoist: Hoist,
    winding: Winding,
    coupling: Coupling,
    names: Sequence[str] = ("",),
    arrival: Arrival | None = None,
) -> tuple[SummaryRow, ...]:
    """Return all rows of a run, in reading order; `names` are those of its ropes."""
    rows: list[SummaryRow] = []
    if (recording := result.recording).signals:
        rows = _trip(recording, hoist, winding)
        rows += _swing(recording, result.trajectory.duration, (arrival or Arrival()).window)
        rows += _signals(recording, (_DRIVE, _WORK))
        rows += _together(recording) if names[0] else ()
        for name in names:
            of_rope = f", {name}" if name else ""
            rows += [
                replace(row, group=f"{row.group}{of_rope}") for row in _of_rope(recording, name)
            ]
        if "energy.work_ends" in recording:
            defect = _rough(exchange_energy(recording, hoist))
            rows.append(
                SummaryRow(_WORK, "energy that the coupling's delay makes up, largest", defect, "J")
            )
    groups = list(dict.fromkeys(row.group for row in rows))
    return (*sorted(rows, key=lambda row: groups.index(row.group)), *_clock(result, coupling))


def _of_rope(recording: Recording, name: str) -> Iterator[SummaryRow]:
    own = rope_signals(recording, name)
    if name:
        count = len(own.time)
        share = (own["left.fy"] + own["right.fy"]) / (recording["left.fy"] + recording["right.fy"])[
            :count
        ]
        text = f"{number(100.0 * share[0], 3)} %, in motion {number(100.0 * share.min(), 3)} to "
        yield SummaryRow(
            _ROPE, "share of the pull of all, at rest", f"{text}{number(100.0 * share.max(), 3)} %"
        )
    yield from _signals(own, (_ROPE, _ENERGY))
    if fidelities := fidelities_of(own):
        yield SummaryRow(_ROPE, "fidelity of the model that ran", ", then ".join(fidelities))


def _together(recording: Recording) -> Iterator[SummaryRow]:
    """Yield the moments of several ropes about the conveyances' centres."""
    for end in SIDES:
        for name, label in (
            ("mx", "tilt about X"),
            ("my", "moment about Y"),
            ("mz", "tilt about Z"),
        ):
            if bool(np.isfinite(recording[f"{end}.{name}"]).any()):
                group = f"All ropes on the {end} conveyance, about its centre"
                yield SummaryRow(group, label, _largest(recording[f"{end}.{name}"]), "N m")


def _signals(recording: Recording, groups: Collection[str]) -> Iterator[SummaryRow]:
    for group, quantity, names, factor, unit, measure in (row for row in _ROWS if row[0] in groups):
        recorded = [
            recording[name] for name in names if name in recording and loses(recording, name)
        ]
        # signals that the fidelity leaves out are NaN throughout
        if recorded and bool(np.isfinite(values := np.concatenate(recorded)).any()):
            yield SummaryRow(group, quantity, measure(factor * values), unit)


def loses(recording: Recording, name: str) -> bool:
    """Return True if a loss of energy is shown.

    A loss that not every scene has is shown if it is not 0.
    """
    return not name.endswith((*ELSEWHERE, "drive.work_slip")) or bool(np.any(recording[name]))


#: Columns of the table of exposure, what their largest value is called, and the column that tells
#: when or how fast.
_MOST = {
    "curvature.range": ("largest range of curvature in a cycle", ""),
    "torque.range": ("largest range of torque in a cycle", ""),
    "tension.range": ("largest range of tension in a cycle", ""),
    "tension.largest": ("largest tension", "largest_at"),
    "torque.amplitude": ("strongest vibration of torque", "frequency"),
    "tension.amplitude": ("strongest vibration of tension", "frequency"),
    "bent": ("longest time in the bend", ""),
}


def exposure_rows(rope: str, table: Recording) -> tuple[SummaryRow, ...]:
    """Return rows on the most loaded places of a rope.

    `table` is one of `hoist_demo.recording.exposure`.
    """
    group = f"Places in the rope {rope}".rstrip() + ", from its left end"
    rows: list[SummaryRow] = []
    for name, (label, beside) in _MOST.items():
        if bool(np.isfinite(table[name]).all()) and bool(np.any(table[name])):
            k = int(np.argmax(table[name]))
            parts = [
                (name, ""),
                ("s", " at "),
                *([(f"{name.partition('.')[0]}.{beside}", ", ")] if beside else []),
            ]
            text = "".join(
                f"{sep}{number(float(table[x][k]), 4)} {unit_text(table.units[x])}"
                for x, sep in parts
            )
            rows.append(SummaryRow(group, label, text))
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
    last, until = "final position error", ""
    if not bool(follows.all()):
        last, until = "position error at the trip", " until then"
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
    swings = {
        end: 1e3 * float(np.ptp(recording[f"conveyance.{end}.y"][in_window])) for end in SIDES
    }
    return [
        SummaryRow(_DRIVE, f"swing after arrival, {end}, {within}", swing, "mm")
        for end, swing in swings.items()
    ]


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
