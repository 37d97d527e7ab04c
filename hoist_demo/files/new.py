"""A new hoist's file from a few numbers: what is not given follows by rules, each of which the file states.

All rules are ours [assumed]: plausible for a tower hoist with skips, and taken from no installation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from hoist_demo.files.values import DERIVED, GIVEN
from hoist_demo.files.writing import Line, hoist_text
from hoist_demo.parameters import GRAVITY
from hoist_demo.parameters.quantity import Value
from rope_model import Rope
from rope_model import rope as catalogue_rope

#: Qb and Qc of an installed size's balance rope over those of a rope similar to the known one [-, assumed].  Balance
#: ropes of deep shafts are made to turn little. With the known rope's coupling, the weight of 1000 m held at both ends
#: would turn the loop through more than a full turn before it moves: the legs would pass through each other.
COUPLING = 0.1

#: Hz [assumed]: of the motor against the sheave
_SHAFT = 12.0
_ABOUT = """\
Written by balance-rope new. Values are SI or { value, unit, status, source }, status: published, data sheet, measured,
given, derived (by the rule behind it) or assumed. Replace what you know and say where it comes from; what you delete
follows by a rule or is a default: balance-rope show FILE prints it all."""


@dataclass(frozen=True)
class Wish:
    """What is known of a new hoist, SI."""

    name: str
    depth: float
    payload: float
    speed: float
    conveyance: float | None = None
    head_ropes: int = 4
    ropes: int = 1
    construction: str = "34x7"
    diameter: float = 0.044
    lay: str = "right-hand"  # or "alternate", of several ropes
    acceleration: float = 0.8
    jerk: float = 0.5
    spacing: float = 2.4
    given: frozenset[str] = field(default_factory=frozenset)  # names of the fields above that somebody chose


def round_rope(length: float, mass_per_length: float, spacing: float, coupling: float = COUPLING) -> dict[str, float]:
    """Parameters by FMI name of a rope similar to the known one of 44 mm and 8 kg/m.

    The diameter is d = 44 mm sqrt(m / 8); Qa ~ d^2, Qb and Qc ~ d^3, Qd, EI and rhoJ ~ d^4. `length` [m],
    `mass_per_length` [kg/m], `spacing` [m]; `coupling` is the share of the similar rope's Qb and Qc, which the lay
    decides: 1 keeps them, COUPLING suits deep shafts, 0 makes a rope without torque.
    """
    known = Rope()
    s = math.sqrt(mass_per_length / known.mass_per_length)
    return {
        "rope.length": length,
        "rope.mass_per_length": mass_per_length,
        "rope.Qa": known.Qa * s**2,
        "rope.Qb": coupling * known.Qb * s**3,
        "rope.Qc": coupling * known.Qc * s**3,
        "rope.Qd": known.Qd * s**4,
        "rope.EI": known.EI * s**4,
        "rope.rhoJ": known.rhoJ * s**4,
        "rope.diameter": known.diameter * s,
        "layout.spacing": spacing,
    }


def new_hoist(wish: Wish) -> str:
    """Return the text of a file; ValueError where the rope is not in the catalogue."""
    rope = catalogue_rope(wish.construction, wish.diameter)
    conveyance = 0.9 * wish.payload if wish.conveyance is None else wish.conveyance
    head_mass = wish.ropes * rope.middle.mass_per_length / wish.head_ropes
    head_diameter = math.sqrt(head_mass / 4000.0)
    radius = _rounded(50.0 * head_diameter)
    sheave = _rounded(1.5 * wish.payload)
    motor = _rounded(0.4 * sheave)
    power = _rounded(2.6 * wish.payload * GRAVITY * wish.speed)

    def known(name: str, key: str, value: Value, rule: str = "") -> Line:
        status = GIVEN if key in wish.given else DERIVED if rule else "assumed"
        return Line(name, value, status, "" if key in wish.given else rule)

    lines = [
        known("hoist.shaft_travel", "depth", wish.depth),
        known("hoist.payload_left", "payload", wish.payload),
        known("hoist.conveyance_mass", "conveyance", conveyance, "0.9 of the payload"),
        known("hoist.head_rope_number", "head_ropes", wish.head_ropes),
        Line("hoist.head_rope_mass", head_mass, DERIVED, "the balance ropes' mass over the head ropes' number"),
        Line("hoist.head_rope_stiffness", 1.3e7 * head_mass, DERIVED, "110 GPa of the steel"),
        Line("hoist.head_rope_damping", 0.02, "assumed"),
        Line("hoist.head_rope_length_up", 40.0, "assumed"),
        Line("hoist.head_rope_modes", 2, "assumed"),
        Line("hoist.sheave_radius", radius, DERIVED, f"50 times {head_diameter:.3f} m, a head rope of 4000 kg/m3 d2"),
        Line("hoist.sheave_mass", sheave, DERIVED, "1.5 times the payload"),
        Line("hoist.torque_limit", _rounded(power * radius / wish.speed), DERIVED, "of the power at full speed"),
        Line("hoist.power_limit", power, DERIVED, "2.6 times what lifts the payload at full speed"),
        Line("hoist.loss_coulomb", _rounded(0.01 * conveyance * GRAVITY), DERIVED, "1 % of a conveyance's weight"),
        Line("hoist.loss_viscous", _rounded(0.02 * wish.payload), DERIVED, "0.02 1/s of the payload"),
        Line("hoist.friction_coefficient", 0.25, "assumed"),
        Line("hoist.wrap_angle", math.pi, "assumed"),
        Line("hoist.drive_shaft.motor_mass", motor, DERIVED, "0.4 of the sheave's"),
        Line(
            "hoist.drive_shaft.stiffness",
            _rounded((2.0 * math.pi * _SHAFT) ** 2 * motor * (sheave - motor) / sheave * radius**2),
            DERIVED,
            f"{_SHAFT:g} Hz",
        ),
        Line("hoist.brake.torque", _rounded(3.0 * wish.payload * GRAVITY * radius), DERIVED, "3 times the payload's"),
        Line("hoist.guides.coulomb", _rounded(0.005 * conveyance * GRAVITY), DERIVED, "0.5 % of a conveyance's weight"),
        Line("hoist.guides.viscous", _rounded(0.01 * wish.payload), DERIVED, "0.01 1/s of the payload"),
        Line("hoist.play.clearance", 5e-3, "assumed"),
        Line("winding.travel", wish.depth, DERIVED, "from landing to landing"),
        known("winding.speed", "speed", wish.speed),
        known("winding.acceleration", "acceleration", wish.acceleration),
        known("winding.jerk", "jerk", wish.jerk),
        Line("winding.settle", 15.0, "assumed"),
        Line("winding.emergency_deceleration", 2.0, "assumed"),
        known("layout.spacing", "spacing", wish.spacing),
    ]
    alike = wish.ropes == 1 or wish.lay != "alternate"
    ropes = [_rope(wish, k) for k in range(1 if alike else wish.ropes)]
    return hoist_text(wish.name, lines, ropes, _ABOUT)


def _rope(wish: Wish, k: int) -> list[Line]:
    lay = ("right-hand", "left-hand")[k % 2] if wish.lay == "alternate" else wish.lay
    lines = [Line("rope.construction", wish.construction), Line("rope.lay", lay)]
    lines.append(Line("rope.diameter", wish.diameter, GIVEN if "diameter" in wish.given else "assumed"))
    if wish.ropes > 1 and wish.lay == "alternate":
        z = 0.3 * (k - 0.5 * (wish.ropes - 1))
        lines = [Line("rope.name", f"rope{k + 1}"), *lines, Line("rope.z", z, "assumed")]
    elif wish.ropes > 1:
        lines.insert(0, Line("rope.number", wish.ropes))
    lines.append(Line("rope.length", wish.depth + 40.0, DERIVED, "travel and 40 m"))
    return [*lines, Line("rope.swivels.mode", "coulomb")]


def _rounded(value: float) -> float:
    """Return the value to three digits: rules know no more."""
    return float(f"{value:.3g}")
