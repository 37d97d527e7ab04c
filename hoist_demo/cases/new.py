"""A new hoist's file from a few numbers.

Other values follow by rules, which the file states.

All rules are ours [assumed]: plausible for a tower hoist with skips, and taken from no
installation.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from hoist_demo.cases.rules import (
    HEAD_ROPE_STIFFNESS,
    TAIL_SPARE,
    TRIP_TORQUE,
    RuleInputs,
)
from hoist_demo.cases.writing import hoist_text
from hoist_demo.files.registry import data_of
from hoist_demo.files.values import ASSUMED, DERIVED, ParameterValue, ParameterValues, values_of
from hoist_demo.parameters import GRAVITY, hoist_with
from hoist_demo.parameters.quantity import FileParameter, NumberRange, Value
from rope_model import rope as catalogue_rope

# All [assumed]; the file states each beside the value that follows from it.
CONVEYANCE_MASS = 0.9  #: Mass of a conveyance over the payload.
SHEAVE_MASS = 1.5  #: Mass of the sheave at its rim over the payload.
MOTOR_MASS = 0.4  #: Mass of the motor at the sheave's rim over the sheave's.
SHAFT_FREQUENCY = 12.0  #: Frequency of the motor against the sheave [Hz].
HEAD_ROPE_DENSITY = 4000.0  #: Mass per length of a head rope over its squared diameter [kg/m^3].
SHEAVE_RADIUS = 50.0  #: Radius of the sheave over the diameter of a head rope.
LOSS_COULOMB = 0.01  #: Friction of the drive over a conveyance's weight.
LOSS_VISCOUS = 0.02  #: Viscous loss of the drive over the payload [1/s].
GUIDES_COULOMB = 0.005  #: Friction of the guides over a conveyance's weight.
GUIDES_VISCOUS = 0.01  #: Viscous loss of the guides over the payload [1/s].
LIFTING_TORQUE = 2.6  #: Limit of the motor over the torque that lifts the payload.
BRAKE_TORQUE = 3.0  #: Torque of the brake over the payload's.
ROPE_DISTANCE = 0.25  #: Distance of ropes of alternate lay over layout.spacing.
_COMMENT = """\
Written by balance-rope new. Values are SI or { value, unit, status, source }, status: published, data sheet, measured,
given, derived (by the rule behind it) or assumed. Replace what you know and say where it comes from; what you delete
follows by a rule or is a default: balance-rope show FILE prints it all."""
HANDS = ("right-hand", "left-hand")
ALTERNATE = "alternate"  #: Lay of ropes that alternate, so that their torques cancel.
LAYS = (*HANDS, ALTERNATE)
#: Inputs for a new hoist; those without a start are required, but for the conveyance's mass.
WISHES = (
    FileParameter(
        "depth", "m", "Real", "", NumberRange(1.0, 4000.0), meaning="way between the landings"
    ),
    FileParameter("payload", "kg", "Real", "", NumberRange(1.0), meaning="in the left conveyance"),
    FileParameter("speed", "m/s", "Real", "", NumberRange(0.1, 30.0), meaning="limit of the trip"),
    FileParameter(
        "conveyance",
        "kg",
        "Real",
        0.0,
        NumberRange(1.0),
        meaning=f"each, with its attachments; {CONVEYANCE_MASS:g} of the payload",
    ),
    FileParameter("head-ropes", "1", "Integer", 4, NumberRange(1, 20), meaning="head ropes"),
    FileParameter("ropes", "1", "Integer", 1, NumberRange(1, 20), meaning="balance ropes"),
    FileParameter("rope", "1", "String", "34x7", meaning="the catalogue's construction"),
    FileParameter(
        "diameter", "m", "Real", 0.044, NumberRange(1e-3, 1.0), meaning="of a balance rope"
    ),
    FileParameter("lay", "1", "String", "right-hand", choices=LAYS, meaning="of the balance ropes"),
    FileParameter(
        "acceleration", "m/s2", "Real", 0.8, NumberRange(0.01), meaning="limit of the trip"
    ),
    FileParameter("jerk", "m/s3", "Real", 0.5, NumberRange(0.01), meaning="limit of the trip"),
    FileParameter(
        "spacing", "m", "Real", 2.4, NumberRange(0.01), meaning="between the rope's two ends"
    ),
)


@dataclass(frozen=True)
class _Wishes:
    """Values of WISHES with their statuses, and what they say as numbers."""

    entries: ParameterValues

    def number(self, wish: str) -> float:
        """Return the value of a wish as a number."""
        return float(self.entries[wish].value)

    @property
    def ropes(self) -> int:
        """Number of the balance ropes."""
        return int(self.number("ropes"))

    @property
    def construction(self) -> str:
        """Construction of the balance ropes, of the catalogue."""
        return str(self.entries["rope"].value)

    @property
    def rope_mass(self) -> float:
        """Mass per length of a balance rope [kg/m]; ValueError where it is not in the catalogue."""
        rope = catalogue_rope(self.construction, self.number("diameter"))
        return rope.middle.mass_per_length

    @property
    def head_rope_mass(self) -> float:
        """Mass per length of a head rope that balances the ropes below [kg/m]."""
        return self.ropes * self.rope_mass / self.number("head-ropes")

    @property
    def head_rope_diameter(self) -> float:
        """Diameter of a head rope [m]."""
        return math.sqrt(self.head_rope_mass / HEAD_ROPE_DENSITY)

    @property
    def sheave_radius(self) -> float:
        """Radius of the sheave [m]."""
        return _rounded(SHEAVE_RADIUS * self.head_rope_diameter)


def new_hoist(name: str, chosen: Mapping[str, Value]) -> str:
    """Return the text of a file by values of WISHES.

    ValueError where the rope is not in the catalogue.
    """
    entries = {p.name: _assumed(p.start) for p in WISHES}
    entries |= {wish: ParameterValue(value) for wish, value in chosen.items()}
    if "conveyance" not in chosen:
        entries["conveyance"] = _derived(
            CONVEYANCE_MASS * float(entries["payload"].value),
            f"{CONVEYANCE_MASS:g} of the payload",
        )
    wishes = _Wishes(entries)
    values = {**_host_values(wishes), **_trip_values(wishes)}
    values |= _drive_limits(wishes, values)
    return hoist_text(name, values, _ropes(wishes), _COMMENT)


def _derived(value: float, rule: str) -> ParameterValue:
    return ParameterValue(value, DERIVED, rule)


def _assumed(value: Value) -> ParameterValue:
    return ParameterValue(value, ASSUMED)


def _host_values(wishes: _Wishes) -> dict[str, ParameterValue]:
    """Return conveyances, head ropes, sheave and losses."""
    payload = wishes.number("payload")
    weight = wishes.number("conveyance") * GRAVITY
    return {
        "hoist.shaft_travel": wishes.entries["depth"],
        "hoist.payload_left": wishes.entries["payload"],
        "hoist.conveyance_mass": wishes.entries["conveyance"],
        "hoist.head_rope_number": wishes.entries["head-ropes"],
        "hoist.head_rope_mass": _derived(
            wishes.head_rope_mass, "the balance ropes' mass over the head ropes' number"
        ),
        "hoist.head_rope_stiffness": _derived(
            HEAD_ROPE_STIFFNESS * wishes.head_rope_mass,
            f"{HEAD_ROPE_STIFFNESS:g} m2/s2 times its mass",
        ),
        "hoist.head_rope_damping": _assumed(0.02),
        "hoist.head_rope_length_up": _assumed(40.0),
        "hoist.head_rope_modes": _assumed(2),
        "hoist.sheave_radius": _derived(
            wishes.sheave_radius,
            f"{SHEAVE_RADIUS:g} times {wishes.head_rope_diameter:.3f} m, a head rope of "
            f"{HEAD_ROPE_DENSITY:g} kg/m3 d2",
        ),
        "hoist.sheave_mass": _derived(
            _rounded(SHEAVE_MASS * payload), f"{SHEAVE_MASS:g} times the payload"
        ),
        "hoist.loss_coulomb": _derived(
            _rounded(LOSS_COULOMB * weight), f"{100.0 * LOSS_COULOMB:g} % of a conveyance's weight"
        ),
        "hoist.loss_viscous": _derived(
            _rounded(LOSS_VISCOUS * payload), f"{LOSS_VISCOUS:g} 1/s of the payload"
        ),
        "hoist.friction_coefficient": _assumed(0.25),
        "hoist.wrap_angle": _assumed(math.pi),
        **_drive_shaft(wishes),
        "hoist.guides.coulomb": _derived(
            _rounded(GUIDES_COULOMB * weight),
            f"{100.0 * GUIDES_COULOMB:g} % of a conveyance's weight",
        ),
        "hoist.guides.viscous": _derived(
            _rounded(GUIDES_VISCOUS * payload), f"{GUIDES_VISCOUS:g} 1/s of the payload"
        ),
        "hoist.play.clearance": _assumed(5e-3),
    }


def _drive_shaft(wishes: _Wishes) -> dict[str, ParameterValue]:
    """Return the motor's mass, and the stiffness that gives its frequency against the sheave."""
    sheave = _rounded(SHEAVE_MASS * wishes.number("payload"))
    motor = _rounded(MOTOR_MASS * sheave)
    omega = 2.0 * math.pi * SHAFT_FREQUENCY
    stiffness_at_rim = omega**2 * motor * (sheave - motor) / sheave
    stiffness = _rounded(stiffness_at_rim * wishes.sheave_radius**2)
    return {
        "hoist.drive_shaft.motor_mass": _derived(motor, f"{MOTOR_MASS:g} of the sheave's"),
        "hoist.drive_shaft.stiffness": _derived(stiffness, f"{SHAFT_FREQUENCY:g} Hz"),
    }


def _trip_values(wishes: _Wishes) -> dict[str, ParameterValue]:
    """Return the trip, and the distance of the rope's ends."""
    return {
        "winding.travel": _derived(wishes.number("depth"), "from landing to landing"),
        "winding.speed": wishes.entries["speed"],
        "winding.acceleration": wishes.entries["acceleration"],
        "winding.jerk": wishes.entries["jerk"],
        "winding.settle": _assumed(15.0),
        "winding.emergency_deceleration": _assumed(2.0),
        "layout.spacing": wishes.entries["spacing"],
    }


def _drive_limits(wishes: _Wishes, values: ParameterValues) -> dict[str, ParameterValue]:
    """Return the limits of motor and brake for the hoist and the trip of ``values``."""
    parts = data_of(values_of(values))
    winding = parts["winding"]
    balance_ropes = (wishes.ropes * wishes.rope_mass, wishes.number("depth") + TAIL_SPARE)
    hoist = hoist_with(parts["hoist"], [balance_ropes])
    radius = wishes.sheave_radius
    payload = wishes.number("payload")
    lifting = LIFTING_TORQUE * payload * GRAVITY * radius
    trip = TRIP_TORQUE * RuleInputs(hoist, winding, hoist).torque()
    motor = _rounded(max(lifting, trip))
    stopping = radius * (hoist.moving_mass * winding.emergency_deceleration + payload * GRAVITY)
    brake = _rounded(max(BRAKE_TORQUE * payload * GRAVITY * radius, stopping))
    power = _rounded(motor * wishes.number("speed") / radius)
    return {
        "hoist.torque_limit": _derived(
            motor,
            f"{LIFTING_TORQUE:g} times what lifts the payload, or {TRIP_TORQUE:g} times what the "
            "trip asks for",
        ),
        "hoist.brake.torque": _derived(
            brake,
            f"{BRAKE_TORQUE:g} times the payload's, or an emergency stop's with the payload going "
            "down",
        ),
        "hoist.power_limit": _derived(power, "of the torque at full speed"),
    }


def _ropes(wishes: _Wishes) -> list[dict[str, ParameterValue]]:
    """Return the [[rope]] tables: one of equal ropes, or ropes of alternate lay side by side."""
    number = wishes.ropes
    lay = str(wishes.entries["lay"].value)
    if lay != ALTERNATE or number == 1:
        rope = {"rope.number": ParameterValue(number), **_rope_values(wishes, lay)}
        return [rope]
    ropes: list[dict[str, ParameterValue]] = []
    for k in range(number):
        z = ROPE_DISTANCE * wishes.number("spacing") * (k - 0.5 * (number - 1))
        ropes.append(
            {
                "rope.name": ParameterValue(f"rope{k + 1}"),
                "rope.z": _derived(round(z, 3), f"{ROPE_DISTANCE:g} of the spacing apart"),
                **_rope_values(wishes, HANDS[k % len(HANDS)]),
            }
        )
    return ropes


def _rope_values(wishes: _Wishes, lay: str) -> dict[str, ParameterValue]:
    """Return what a [[rope]] says of the rope itself."""
    length = wishes.number("depth") + TAIL_SPARE
    return {
        "rope.construction": ParameterValue(wishes.construction),
        "rope.lay": ParameterValue(lay),
        "rope.diameter": wishes.entries["diameter"],
        "rope.length": _derived(length, f"travel and {TAIL_SPARE:g} m"),
        "rope.swivels.mode": ParameterValue("coulomb"),
    }


def _rounded(value: float) -> float:
    """Return the value to three digits: rules know no more."""
    return float(f"{value:.3g}")
