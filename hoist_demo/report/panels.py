"""Panels of plots and instants to mark in them, for the pages and the PNG files.

A panel has signals that share a plot. Signals not recorded, and panels without any, are left out.
"""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle

import numpy as np

from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Hoist
from hoist_demo.recording.incidents import guard_trip, jams, slack_ropes, slip
from hoist_demo.recording.ropes import rope_signals
from hoist_demo.recording.time_series import Array, Recording
from hoist_demo.report.summary import LOSSES, loses
from hoist_demo.run.metrics import exchange_energy
from rope_model import BODIES

# Line styles with a fixed meaning; the others are `a` to `e`. Colours and dashes are in
# assets/report.css.
LEFT = "left"  #: Style of the left end.
RIGHT = "right"  #: Style of the right end.
REFERENCE = "asked"  #: Style of a reference.
STYLES = "abcde"  #: Styles without a meaning.
_DEGREES = 180.0 / math.pi
CONSTANT_RANGE = 1e-6  #: Range of a constant signal, as a part of its panel's least height.


@dataclass(frozen=True)
class Line:
    """Curve of a recorded or derived signal: factor times it, less its start if ``from_start``."""

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

    ``min_range`` is the smallest height of its axis, so that rounding errors stay flat.
    """

    group: str
    title: str
    unit: str
    lines: tuple[Line, ...]
    min_range: float = 0.0
    limit: Limit | None = None


def derived_signals(recording: Recording, hoist: Hoist) -> dict[str, tuple[Array, str]]:
    """Return signals that follow from recorded ones, with units; names begin with ``derived.``."""
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

    ``names`` are those of the ropes.
    """
    # signals that a fidelity leaves out are NaN throughout
    drawable = set(derived_signals(recording, hoist))
    for name, values in recording.signals.items():
        if bool(np.isfinite(values).any()) and loses(recording, name):
            drawable.add(name)
    shown: list[Panel] = []
    for declared in _all(hoist):
        for panel in _panels_of_ropes(declared, drawable, names):
            lines = tuple(line for line in panel.lines if line.signal in drawable)
            if lines:
                shown.append(replace(panel, lines=lines))
    return shown


def _panels_of_ropes(
    panel: Panel, drawable: Collection[str], names: Sequence[str]
) -> Iterator[Panel]:
    """Yield the panels for several ropes.

    A signal of one line is drawn for all ropes in one panel, others in a panel for each rope.
    """
    yield panel
    of_each_rope = [line for line in panel.lines if line.signal not in drawable]
    if not names[0] or not of_each_rope:
        return
    if len(of_each_rope) == 1:
        line = of_each_rope[0]
        lines = [
            replace(line, signal=f"{name}.{line.signal}", label=name, style=style)
            for name, style in zip(names, cycle(STYLES), strict=False)
        ]
        yield replace(panel, lines=tuple(lines))
    else:
        for name in names:
            lines = [replace(line, signal=f"{name}.{line.signal}") for line in of_each_rope]
            yield replace(panel, title=f"{panel.title}, {name}", lines=tuple(lines))


def is_constant(recording: Recording, panel: Panel) -> bool:
    """Return True if all recorded signals of a panel keep one value, rounding errors apart."""
    recorded = [
        abs(line.factor) * np.ptp(recording[line.signal])
        for line in panel.lines
        if line.signal in recording
    ]
    if len(recorded) < len(panel.lines):
        return False
    return bool(max(recorded) <= CONSTANT_RANGE * panel.min_range)


def _ends(pattern: str, factor: float = 1.0) -> tuple[Line, Line]:
    """Return the signal at both ends; ``{}`` stands for the end."""
    return (
        Line(pattern.format(LEFT), label=LEFT, style=LEFT, factor=factor),
        Line(pattern.format(RIGHT), label=RIGHT, style=RIGHT, factor=factor),
    )


def _lines(
    names: dict[str, str], factor: float = 1.0, from_start: bool = False
) -> tuple[Line, ...]:
    """Return lines by signal and label, one style after the other."""
    return tuple(
        Line(signal, label, style, factor, from_start)
        for (signal, label), style in zip(names.items(), STYLES, strict=False)
    )


def _followed(quantity: str, component: str) -> tuple[Line, ...]:
    return *_ends(f"conveyance.{{}}.{component}"), Line(quantity, "reference, left", REFERENCE)


def _all(hoist: Hoist) -> Iterator[Panel]:
    """Yield all panels by group."""
    yield from _winding_panels()
    yield from _drive_panels(hoist)
    yield from _rope_panels(hoist.tail_rope_number)
    yield from _swivel_panels()
    stresses = _lines(_STRESSES, factor=_MEGA)
    yield Panel("Stress", "Largest nominal stress of the rope", "MPa", stresses)
    yield from _energy_panels()


def _winding_panels() -> Iterator[Panel]:
    group = "Winding"
    heights = _followed("derived.reference_height", "y")
    yield Panel(group, "Height in the shaft", "m", heights)
    yield Panel(group, "Speed", "m/s", _followed("reference.speed", "vy"))
    yield Panel(group, "Acceleration", "m/s²", _followed("reference.acceleration", "ay"))
    error = _lines({"derived.tracking_error": "error"}, factor=_MILLI)
    yield Panel(group, "Tracking error, left", "mm", error, min_range=1.0)


def _drive_panels(hoist: Hoist) -> Iterator[Panel]:
    group = "Drive"
    torque = (
        Line("drive.torque_command", "command", REFERENCE, factor=_KILO),
        Line("drive.torque", "motor", "a", factor=_KILO),
    )
    brake = Line("drive.brake_torque", "brake", "c", factor=_KILO)
    tensions = _ends("drive.tension_{}", factor=_KILO)
    ratio = Line("drive.tension_ratio", "larger / smaller", "b")
    slip_ratio = hoist.tension_ratio_limit
    limit = Limit(slip_ratio, f"ropes slip at exp(µα) = {slip_ratio:.2f}")
    yield Panel(group, "Motor torque", "kN m", torque)
    power = _lines({"drive.motor_power": "power"}, factor=_KILO)
    yield Panel(group, "Motor power", "kW", power)
    yield Panel(group, "Brake torque on the sheave", "kN m", (brake,))
    yield Panel(group, "Head rope tension at the sheave", "kN", tensions)
    yield Panel(group, "Tension ratio on the sheave", "1", (ratio,), limit=limit)
    if hoist.lining is not None:
        way = _lines({"drive.slip": "way"})
        yield Panel(group, "Head ropes slipped on the sheave", "m", way, min_range=0.01)
        yield Panel(group, "Speeds at the sheave's rim", "m/s", _lines(_SPEEDS))


def _rope_panels(count: int) -> Iterator[Panel]:
    """Yield the panels of the balance rope; forces are those of ``count`` equal ropes."""
    group = "Balance rope"
    pull = _ends("{}.fy", factor=-_KILO * count)
    side_force = _ends("{}.fx", factor=count)
    moment = _ends("{}.my", factor=count)
    yaw = Line("loop.yaw", "yaw", "b", factor=_DEGREES)
    turns = Line("loop.turns", "turns", "b")
    from_bodies = _lines({f"clearance.{kind}": words for kind, words in BODIES.items()})
    between_legs = Line("loop.clearance", "clearance", "c")
    yield Panel(group, "Pull on the conveyances", "kN", pull)
    yield Panel(group, "Side force on the conveyances, in plane", "N", side_force, min_range=1.0)
    title = "Moment on the conveyances about the vertical"
    yield Panel(group, title, "N m", moment, min_range=1.0)
    yield Panel(group, "Lowest point of the loop", "m", _lines({"loop.y": "height"}))
    title = "Lowest point of the loop, sideways"
    yield Panel(group, title, "m", _lines(_SIDEWAYS), min_range=0.02)
    yield Panel(group, "Yaw of the loop", "deg", (yaw,), min_range=0.02)
    yield Panel(group, "Turns of the legs about each other", "1", (turns,), min_range=0.01)
    yield Panel(group, "Clearance from what is in the shaft", "m", from_bodies, min_range=0.02)
    yield Panel(group, "Clearance between the legs", "m", (between_legs,), min_range=0.02)


def _swivel_panels() -> Iterator[Panel]:
    group = "Swivels"
    angle = _ends("{}.swivel.angle", factor=_DEGREES)
    torque = _ends("{}.swivel.torque")
    twist = (*_ends("{}.twist"), Line("loop.twist", "loop", "c"))
    yield Panel(group, "Swivel angle", "deg", angle, min_range=0.1)
    yield Panel(group, "Swivel rate", "rad/s", _ends("{}.swivel.rate"), min_range=0.01)
    yield Panel(group, "Moment of the swivel on the rope", "N m", torque, min_range=0.1)
    yield Panel(group, "Twist of the rope", "rad/m", twist, min_range=1e-3)


def _energy_panels() -> Iterator[Panel]:
    group = "Energy"
    drive = _lines(_DRIVE_ENERGIES, factor=_KILO, from_start=True)
    rope = _lines(_ROPE_ENERGIES, factor=_KILO, from_start=True)
    yield Panel(group, "Drive, since the start", "kJ", drive)
    yield Panel(group, "Balance rope, since the start", "kJ", rope)
    losses = _lines(LOSSES, from_start=True)
    yield Panel(group, "Balance rope, dissipated", "J", losses)
    yield Panel(group, "Residual of the energy balance", "J", _lines(_RESIDUALS))


# factors from SI to the unit with a prefix
_MILLI = 1e3
_KILO = 1e-3
_MEGA = 1e-6

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
    recording = result.recording
    winding = result.winding
    # the host's reference counts from the start of the record
    start = float(recording.time[0])
    end = float(recording.time[-1])
    instants = [Mark(jam.t, f"{jam.side} conveyance jams") for jam in jams(recording)]
    for slack in slack_ropes(recording):
        instants.append(Mark(slack.t, f"{slack.side} head ropes slack"))
    head_rope_slip = slip(recording)
    if head_rope_slip is not None:
        instants.append(Mark(head_rope_slip.t, "head ropes slip"))
    if winding.creeps:
        for t in result.trajectory.cruise_times(winding.creep_speed):
            instants.append(Mark(start + t, "creep"))
    trip = guard_trip(recording)
    if trip is not None:
        instants.append(Mark(trip.t, f"guard: {trip.cause}"))
    if winding.emergency_at is not None:
        instants.append(Mark(start + winding.emergency_at, "emergency stop"))
    instants.append(Mark(start + result.trajectory.duration, "reference at rest"))
    inside = [mark for mark in instants if start <= mark.t <= end]
    inside.sort(key=lambda mark: mark.t)
    if not result.completed:
        inside.append(Mark(end, "run stopped"))
    return inside


def transformations(recording: Recording, names: Sequence[str] = ("",)) -> list[float]:
    """First recorded instants [s] after a transformation of a rope's mesh, in ascending order."""
    instants: set[float] = set()
    for name in names:
        rope = rope_signals(recording, name)
        if "count.transformations" in rope:
            transformed = np.diff(rope["count.transformations"]) > 0.0
            instants |= {*rope.time[1:][transformed].tolist()}
    return sorted(instants)


def slips(
    recording: Recording, end: str, names: Sequence[str] = ("",)
) -> list[tuple[float, float]]:
    """Return intervals [s] during which the swivel of ``end`` slips.

    A recorded state holds until the next row.
    """
    intervals: list[tuple[float, float]] = []
    signal = f"{end}.swivel.slipping"
    for name in names:
        rope = rope_signals(recording, name)
        if signal in rope:
            slipping = np.concatenate([[False], rope[signal] > 0.5, [False]])
            edges = np.flatnonzero(slipping[1:] != slipping[:-1])
            times = rope.time
            last = len(times) - 1
            for begin, stop in edges.reshape(-1, 2):
                intervals.append((float(times[begin]), float(times[min(stop, last)])))
    return sorted(intervals)
