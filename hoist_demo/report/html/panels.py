"""Panels of plots: signals that share one. Signals not recorded, and panels without any, are left out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hoist_demo.cosimulation.drive_signals import exchange_energy
from hoist_demo.parameters import Hoist
from hoist_demo.recording.passages import BODIES
from hoist_demo.recording.time_series import Array, Recording
from hoist_demo.report.summary import LOSSES, loses

LEFT, RIGHT, ASKED, LIMIT = "left", "right", "asked", "limit"
"""Line styles with a fixed meaning; the others are `a` to `e`. Colours and dashes are in assets/report.css."""

_DEGREES = 180.0 / math.pi

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


@dataclass(frozen=True)
class Line:
    """One curve: factor (signal - signal at the start, where asked for) of the recorded or derived signal."""

    signal: str
    label: str
    style: str
    factor: float = 1.0
    from_start: bool = False


@dataclass(frozen=True)
class Panel:
    """One plot over time; `least` is the smallest height of its axis, so that rounding errors stay flat."""

    group: str
    title: str
    unit: str
    lines: tuple[Line, ...]
    least: float = 0.0
    limit: tuple[float, str] | None = None
    steps: bool = False


def derived_signals(recording: Recording, hoist: Hoist) -> dict[str, tuple[Array, str]]:
    """Signals that follow from recorded ones, with their units, by names that begin with `derived.`."""
    found: dict[str, tuple[Array, str]] = {}
    if recording.has("reference.position", "conveyance.left.y"):
        travel = recording["conveyance.left.y"] - recording["conveyance.left.y"][0]
        found["derived.tracking_error"] = recording["reference.position"] - travel, "m"
        found["derived.reference_height"] = recording["conveyance.left.y"][0] + recording["reference.position"], "m"
    if hoist.lining is not None and recording.has("drive.rate", "drive.slip_speed"):
        rim = hoist.sheave_radius * recording["drive.rate"]
        found["derived.rim_speed"] = rim, "m/s"
        found["derived.rope_speed"] = rim + recording["drive.slip_speed"], "m/s"
    if recording.has("drive.work_from_balance_rope", "energy.work_ends"):
        found["derived.coupling_defect"] = exchange_energy(recording, hoist), "J"
    return found


def panels(recording: Recording, hoist: Hoist) -> list[Panel]:
    """All panels of which at least one line can be drawn, with those lines only."""
    # what a fidelity leaves out is NaN throughout
    shown_at_all = {name for name, values in recording.signals.items() if bool(np.isfinite(values).any())}
    known = {name for name in shown_at_all if loses(recording, name)} | set(derived_signals(recording, hoist))
    shown: list[Panel] = []
    for panel in _all(hoist):
        lines = tuple(line for line in panel.lines if line.signal in known)
        if lines:
            shown.append(Panel(panel.group, panel.title, panel.unit, lines, panel.least, panel.limit, panel.steps))
    return shown


def quiet(recording: Recording, panel: Panel) -> bool:
    """Return True if all recorded signals of a panel keep one value."""
    return all(line.signal in recording and np.ptp(recording[line.signal]) == 0.0 for line in panel.lines)


def _ends(pattern: str, factor: float = 1.0) -> tuple[Line, Line]:
    """Return the signal at both ends; `{}` stands for the end."""
    return (
        Line(pattern.format("left"), "left", LEFT, factor),
        Line(pattern.format("right"), "right", RIGHT, factor),
    )


def _energies(pairs: dict[str, str], factor: float) -> tuple[Line, ...]:
    """Changes since the start, one style after the other."""
    names = zip(pairs.items(), "abcde", strict=False)
    return tuple(Line(signal, label, style, factor, from_start=True) for (signal, label), style in names)


def _all(hoist: Hoist) -> tuple[Panel, ...]:
    return (*_winding(), *_drive(hoist), *_rope(), *_swivels(), *_stress(), *_energy())


def _winding() -> tuple[Panel, ...]:
    return (
        Panel(
            "Winding",
            "Height in the shaft",
            "m",
            (*_ends("conveyance.{}.y"), Line("derived.reference_height", "reference, left", ASKED)),
        ),
        Panel(
            "Winding",
            "Speed",
            "m/s",
            (*_ends("conveyance.{}.vy"), Line("reference.speed", "reference, left", ASKED)),
        ),
        Panel(
            "Winding",
            "Acceleration",
            "m/s²",
            (*_ends("conveyance.{}.ay"), Line("reference.acceleration", "reference, left", ASKED)),
        ),
        Panel("Winding", "Tracking error, left", "mm", (Line("derived.tracking_error", "error", "a", 1e3),), 1.0),
    )


def _drive(hoist: Hoist) -> tuple[Panel, ...]:
    slip = hoist.tension_ratio_limit
    return (
        Panel(
            "Drive",
            "Motor torque",
            "kN m",
            (Line("drive.torque_command", "command", ASKED, 1e-3), Line("drive.torque", "motor", "a", 1e-3)),
        ),
        Panel("Drive", "Motor power", "kW", (Line("drive.motor_power", "power", "a", 1e-3),)),
        Panel("Drive", "Brake torque on the sheave", "kN m", (Line("drive.brake_torque", "brake", "c", 1e-3),)),
        Panel("Drive", "Head rope tension at the sheave", "kN", _ends("drive.tension_{}", 1e-3)),
        Panel(
            "Drive",
            "Tension ratio on the sheave",
            "1",
            (Line("drive.tension_ratio", "larger / smaller", "b"),),
            limit=(slip, f"ropes slip at exp(µα) = {slip:.2f}"),
        ),
        *(() if hoist.lining is None else _slip()),
    )


def _slip() -> tuple[Panel, ...]:
    return (
        Panel("Drive", "Head ropes slipped on the sheave", "m", (Line("drive.slip", "way", "a"),), 0.01),
        Panel(
            "Drive",
            "Speeds at the sheave's rim",
            "m/s",
            (Line("derived.rim_speed", "sheave", "a"), Line("derived.rope_speed", "head ropes", "b")),
        ),
    )


def _rope() -> tuple[Panel, ...]:
    return (
        Panel("Balance rope", "Pull on the conveyances", "kN", _ends("{}.fy", -1e-3)),
        Panel("Balance rope", "Side force on the conveyances, in plane", "N", _ends("{}.fx"), 1.0),
        Panel("Balance rope", "Moment on the conveyances about the vertical", "N m", _ends("{}.my"), 1.0),
        Panel("Balance rope", "Lowest point of the loop", "m", (Line("loop.y", "height", "a"),)),
        Panel(
            "Balance rope",
            "Lowest point of the loop, sideways",
            "m",
            (Line("loop.x", "in plane, x", "a"), Line("loop.z", "out of plane, z", "b")),
            0.02,
        ),
        Panel("Balance rope", "Yaw of the loop", "deg", (Line("loop.yaw", "yaw", "b", _DEGREES),), 0.02),
        Panel("Balance rope", "Turns of the legs about each other", "1", (Line("loop.turns", "turns", "b"),), 0.01),
        Panel(
            "Balance rope",
            "Clearance from what is in the shaft",
            "m",
            tuple(Line(f"clearance.{k}", w, style) for (k, w), style in zip(BODIES.items(), "abcde", strict=True)),
            0.02,
        ),
        Panel("Balance rope", "Clearance between the legs", "m", (Line("loop.clearance", "clearance", "c"),), 0.02),
    )


def _swivels() -> tuple[Panel, ...]:
    return (
        Panel("Swivels", "Swivel angle", "deg", _ends("{}.swivel.angle", _DEGREES), 0.1),
        Panel("Swivels", "Swivel rate", "rad/s", _ends("{}.swivel.rate"), 0.01),
        Panel("Swivels", "Moment of the swivel on the rope", "N m", _ends("{}.swivel.torque"), 0.1),
        Panel(
            "Swivels",
            "Twist of the rope",
            "rad/m",
            (*_ends("{}.twist"), Line("loop.twist", "loop", "c")),
            1e-3,
        ),
    )


def _stress() -> tuple[Panel, ...]:
    return (
        Panel(
            "Stress",
            "Largest nominal stress of the rope",
            "MPa",
            (
                Line("stress.bending_max", "bending", "a", 1e-6),
                Line("stress.torsion_max", "torsion", "b", 1e-6),
            ),
        ),
    )


def _energy() -> tuple[Panel, ...]:
    return (
        Panel(
            "Energy",
            "Drive, since the start",
            "kJ",
            _energies(
                _DRIVE_ENERGIES,
                1e-3,
            ),
        ),
        Panel(
            "Energy",
            "Balance rope, since the start",
            "kJ",
            _energies(
                _ROPE_ENERGIES,
                1e-3,
            ),
        ),
        Panel(
            "Energy",
            "Balance rope, dissipated",
            "J",
            _energies(LOSSES, 1.0),
        ),
        Panel(
            "Energy",
            "Residual of the energy balance",
            "J",
            (
                Line("drive.energy_residual", "drive", "a"),
                Line("energy.residual", "balance rope", "b"),
                Line("energy.transformations", "transformations", "c"),
                Line("derived.coupling_defect", "coupling", "d"),
            ),
        ),
        Panel(
            "Energy",
            "Events of the rope's solver",
            "1",
            (
                Line("count.transformations", "mesh transformations", "a"),
                Line("count.swivel_events", "stick or slip", "b"),
                Line("count.rejections", "rejected steps", "c"),
            ),
            least=1.0,
            steps=True,
        ),
    )
