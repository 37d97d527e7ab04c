"""Panels of plots and instants to mark in them, for the pages and the PNG files.

A panel has signals that share a plot. Signals not recorded, and panels without any, are left out.
"""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle
from typing import Any

import numpy as np

from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Hoist
from hoist_demo.recording.incidents import guard_trip, jams, slack_ropes, slip
from hoist_demo.recording.ropes import rope_signals
from hoist_demo.recording.time_series import Array, Recording
from hoist_demo.report.summary import LOSSES, loses
from hoist_demo.study.metrics import exchange_energy
from rope_model import BODIES

# Line styles with a fixed meaning; the others are `a` to `e`. Colours and dashes are in
# assets/report.css.
LEFT = "left"  #: Style of the left end.
RIGHT = "right"  #: Style of the right end.
REFERENCE = "asked"  #: Style of a reference.
_DEGREES = 180.0 / math.pi


@dataclass(frozen=True)
class Line:
    """Curve of a recorded or derived signal: factor times it, less its start if `from_start`."""

    signal: str
    label: str
    style: str
    factor: float = 1.0
    from_start: bool = False


@dataclass(frozen=True)
class Limit:
    """Horizontal line across a panel."""

    value: float
    label: str


@dataclass(frozen=True)
class Panel:
    """Plot over time.

    `least` is the smallest height of its axis, so that rounding errors stay flat.
    """

    group: str
    title: str
    unit: str
    lines: tuple[Line, ...]
    least: float = 0.0
    limit: Limit | None = None


def derived_signals(recording: Recording, hoist: Hoist) -> dict[str, tuple[Array, str]]:
    """Return signals that follow from recorded ones, with units; names begin with `derived.`."""
    derived: dict[str, tuple[Array, str]] = {}
    if recording.has("reference.position", "conveyance.left.y"):
        travel = recording["conveyance.left.y"] - recording["conveyance.left.y"][0]
        derived["derived.tracking_error"] = recording["reference.position"] - travel, "m"
        derived["derived.reference_height"] = (
            recording["conveyance.left.y"][0] + recording["reference.position"],
            "m",
        )
    if hoist.lining is not None and recording.has("drive.rate", "drive.slip_speed"):
        rim = hoist.sheave_radius * recording["drive.rate"]
        derived["derived.rim_speed"] = rim, "m/s"
        derived["derived.rope_speed"] = rim + recording["drive.slip_speed"], "m/s"
    if recording.has("drive.work_from_balance_rope", "energy.work_ends"):
        derived["derived.coupling_defect"] = exchange_energy(recording, hoist), "J"
    return derived


def panels(recording: Recording, hoist: Hoist, names: Sequence[str] = ("",)) -> list[Panel]:
    """Return all panels of which a line can be drawn, with those lines only.

    `names` are those of the ropes.
    """
    # signals that a fidelity leaves out are NaN throughout
    shown_at_all = {
        name for name, values in recording.signals.items() if bool(np.isfinite(values).any())
    }
    drawable = {name for name in shown_at_all if loses(recording, name)} | set(
        derived_signals(recording, hoist)
    )
    shown: list[Panel] = []
    for panel in (part for whole in _all(hoist) for part in _of_ropes(whole, drawable, names)):
        lines = tuple(line for line in panel.lines if line.signal in drawable)
        if lines:
            shown.append(replace(panel, lines=lines))
    return shown


def _of_ropes(panel: Panel, drawable: Collection[str], names: Sequence[str]) -> Iterator[Panel]:
    """Yield the panels for several ropes.

    A signal of one line is drawn for all ropes in one panel, others in a panel for each rope.
    """
    yield panel
    own = [line for line in panel.lines if line.signal not in drawable]
    if not names[0] or not own:
        return
    if len(own) == 1:
        (line,) = own
        styled = zip(names, cycle("abcde"), strict=False)
        lines = tuple(
            replace(line, signal=f"{n}.{line.signal}", label=n, style=s) for n, s in styled
        )
        yield replace(panel, lines=lines)
    else:
        for n in names:
            lines = tuple(replace(line, signal=f"{n}.{line.signal}") for line in own)
            yield replace(panel, title=f"{panel.title}, {n}", lines=lines)


def quiet(recording: Recording, panel: Panel) -> bool:
    """Return True if all recorded signals of a panel keep one value, rounding errors apart."""
    recorded = [
        abs(line.factor) * np.ptp(recording[line.signal])
        for line in panel.lines
        if line.signal in recording
    ]
    return len(recorded) == len(panel.lines) and bool(max(recorded) <= 1e-6 * panel.least)


def _ends(pattern: str, factor: float = 1.0) -> tuple[Line, Line]:
    """Return the signal at both ends; `{}` stands for the end."""
    left, right = (Line(pattern.format(end), end, end, factor) for end in (LEFT, RIGHT))
    return left, right


def _lines(
    names: dict[str, str], factor: float = 1.0, from_start: bool = False
) -> tuple[Line, ...]:
    """Return lines by signal and label, one style after the other."""
    return tuple(
        Line(*item, style, factor, from_start)
        for item, style in zip(names.items(), "abcde", strict=False)
    )


def _followed(quantity: str, component: str) -> tuple[Line, ...]:
    return *_ends(f"conveyance.{{}}.{component}"), Line(quantity, "reference, left", REFERENCE)


def _all(hoist: Hoist) -> Iterator[Panel]:
    """Yield all panels by group."""
    limit, kilo, mega, count = hoist.tension_ratio_limit, 1e-3, 1e-6, hoist.tail_rope_number
    slip: list[tuple[Any, ...]] = [
        ("Head ropes slipped on the sheave", "m", _lines({"drive.slip": "way"}), 0.01),
        ("Speeds at the sheave's rim", "m/s", _lines(_SPEEDS)),
    ]
    torque = (
        Line("drive.torque_command", "command", REFERENCE, kilo),
        Line("drive.torque", "motor", "a", kilo),
    )
    ratio = (Line("drive.tension_ratio", "larger / smaller", "b"),)
    clearances = {f"clearance.{kind}": words for kind, words in BODIES.items()}
    # title, unit, lines and the further fields of Panel, by group
    groups: dict[str, list[tuple[Any, ...]]] = {
        "Winding": [
            ("Height in the shaft", "m", _followed("derived.reference_height", "y")),
            ("Speed", "m/s", _followed("reference.speed", "vy")),
            ("Acceleration", "m/s²", _followed("reference.acceleration", "ay")),
            ("Tracking error, left", "mm", _lines({"derived.tracking_error": "error"}, 1e3), 1.0),
        ],
        "Drive": [
            ("Motor torque", "kN m", torque),
            ("Motor power", "kW", _lines({"drive.motor_power": "power"}, kilo)),
            (
                "Brake torque on the sheave",
                "kN m",
                (Line("drive.brake_torque", "brake", "c", kilo),),
            ),
            ("Head rope tension at the sheave", "kN", _ends("drive.tension_{}", kilo)),
            (
                "Tension ratio on the sheave",
                "1",
                ratio,
                0.0,
                Limit(limit, f"ropes slip at exp(µα) = {limit:.2f}"),
            ),
            *(slip if hoist.lining is not None else []),
        ],
        "Balance rope": [
            ("Pull on the conveyances", "kN", _ends("{}.fy", -kilo * count)),
            ("Side force on the conveyances, in plane", "N", _ends("{}.fx", count), 1.0),
            ("Moment on the conveyances about the vertical", "N m", _ends("{}.my", count), 1.0),
            ("Lowest point of the loop", "m", _lines({"loop.y": "height"})),
            ("Lowest point of the loop, sideways", "m", _lines(_SIDEWAYS), 0.02),
            ("Yaw of the loop", "deg", (Line("loop.yaw", "yaw", "b", _DEGREES),), 0.02),
            ("Turns of the legs about each other", "1", (Line("loop.turns", "turns", "b"),), 0.01),
            ("Clearance from what is in the shaft", "m", _lines(clearances), 0.02),
            ("Clearance between the legs", "m", (Line("loop.clearance", "clearance", "c"),), 0.02),
        ],
        "Swivels": [
            ("Swivel angle", "deg", _ends("{}.swivel.angle", _DEGREES), 0.1),
            ("Swivel rate", "rad/s", _ends("{}.swivel.rate"), 0.01),
            ("Moment of the swivel on the rope", "N m", _ends("{}.swivel.torque"), 0.1),
            (
                "Twist of the rope",
                "rad/m",
                (*_ends("{}.twist"), Line("loop.twist", "loop", "c")),
                1e-3,
            ),
        ],
        "Stress": [("Largest nominal stress of the rope", "MPa", _lines(_STRESSES, mega))],
        "Energy": [
            ("Drive, since the start", "kJ", _lines(_DRIVE_ENERGIES, kilo, from_start=True)),
            ("Balance rope, since the start", "kJ", _lines(_ROPE_ENERGIES, kilo, from_start=True)),
            ("Balance rope, dissipated", "J", _lines(LOSSES, from_start=True)),
            ("Residual of the energy balance", "J", _lines(_RESIDUALS)),
        ],
    }
    for group, rows in groups.items():
        yield from (Panel(group, *row) for row in rows)


_SPEEDS = {"derived.rim_speed": "sheave", "derived.rope_speed": "head ropes"}
_SIDEWAYS = {
    "loop.x": "in plane, from the rope's place",
    "loop.z": "out of plane, from the rope's place",
}
_STRESSES = {"stress.bending_max": "bending", "stress.torsion_max": "torsion"}
_DRIVE_ENERGIES = {
    "drive.work_motor": "motor",
    "drive.energy_potential": "potential",
    "drive.energy_kinetic": "kinetic",
    "drive.work_losses": "losses",
    "drive.work_from_balance_rope": "from the rope",
}
_ROPE_ENERGIES = {
    "energy.work_ends": "work at the ends",
    "energy.gravity": "gravity",
    "energy.kinetic": "kinetic",
    "energy.strain": "strain",
    "energy.total": "total",
}
_RESIDUALS = {
    "drive.energy_residual": "drive",
    "energy.residual": "balance rope",
    "energy.transformations": "transformations",
    "derived.coupling_defect": "coupling",
}


@dataclass(frozen=True)
class Mark:
    """Instant to be marked in all panels, with its name."""

    t: float  # s
    label: str


def marks(result: Result) -> list[Mark]:
    """List faults, creep, the reference's arrival and the stop of a run, in order of time."""
    times, winding = result.recording.time, result.winding
    # Host's reference counts from the start of the record
    start = float(times[0])
    instants = [Mark(jam.t, f"{jam.side} conveyance jams") for jam in jams(result.recording)]
    instants += [
        Mark(slack.t, f"{slack.side} head ropes slack") for slack in slack_ropes(result.recording)
    ]
    if (slid := slip(result.recording)) is not None:
        instants.append(Mark(slid.t, "head ropes slip"))
    if winding.creeps:
        instants += [
            Mark(start + t, "creep") for t in result.trajectory.cruise_times(winding.creep_speed)
        ]
    if (trip := guard_trip(result.recording)) is not None:
        instants.append(Mark(trip.t, f"guard: {trip.cause}"))
    if winding.emergency_at is not None:
        instants.append(Mark(start + winding.emergency_at, "emergency stop"))
    instants.append(Mark(start + result.trajectory.duration, "reference at rest"))
    # inside the record only
    instants = sorted(
        (mark for mark in instants if start <= mark.t <= float(times[-1])), key=lambda mark: mark.t
    )
    return instants if result.completed else [*instants, Mark(float(times[-1]), "run stopped")]


def transformations(recording: Recording, names: Sequence[str] = ("",)) -> list[float]:
    """First recorded instants [s] after a transformation of a rope's mesh, in ascending order."""
    instants = set[float]()
    for own in (rope_signals(recording, name) for name in names):
        if "count.transformations" in own:
            instants |= {*own.time[1:][np.diff(own["count.transformations"]) > 0.0].tolist()}
    return sorted(instants)


def slips(
    recording: Recording, end: str, names: Sequence[str] = ("",)
) -> list[tuple[float, float]]:
    """Return intervals [s] during which the swivel of `end` slips.

    A recorded state holds until the next row.
    """
    intervals = list[tuple[float, float]]()
    for own in (rope_signals(recording, name) for name in names):
        if (signal := f"{end}.swivel.slipping") in own:
            inside = np.concatenate([[False], own[signal] > 0.5, [False]])
            edges = np.flatnonzero(inside[1:] != inside[:-1])
            times, last = own.time, len(own.time) - 1
            intervals += [
                (float(times[a]), float(times[min(b, last)])) for a, b in edges.reshape(-1, 2)
            ]
    return sorted(intervals)
