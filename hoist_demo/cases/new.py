"""A new hoist's file from a few numbers.

Other values follow by rules, which the file states.

All rules are ours [assumed]: plausible for a tower hoist with skips, and taken from no
installation.
"""

import math
from collections.abc import Mapping

from hoist_demo.cases.rules import HEAD_ROPE_STIFFNESS, TAIL_SPARE, RuleInputs
from hoist_demo.cases.writing import hoist_text
from hoist_demo.files.registry import data_of
from hoist_demo.files.values import DERIVED, ParameterValue, values_of
from hoist_demo.parameters import GRAVITY, hoist_with
from hoist_demo.parameters.quantity import Bounds, Parameter, Value
from rope_model import rope as catalogue_rope

_SHAFT = 12.0  #: Frequency of the motor against the sheave [Hz, assumed].
_COMMENT = """\
Written by balance-rope new. Values are SI or { value, unit, status, source }, status: published, data sheet, measured,
given, derived (by the rule behind it) or assumed. Replace what you know and say where it comes from; what you delete
follows by a rule or is a default: balance-rope show FILE prints it all."""
LAYS = ("right-hand", "left-hand", "alternate")
#: Inputs for a new hoist; those without a start are required, but for the conveyance's mass.
WISHES = (
    Parameter("depth", "m", "Real", "", Bounds(1.0, 4000.0), meaning="way between the landings"),
    Parameter("payload", "kg", "Real", "", Bounds(1.0), meaning="in the left conveyance"),
    Parameter("speed", "m/s", "Real", "", Bounds(0.1, 30.0), meaning="limit of the trip"),
    Parameter(
        "conveyance",
        "kg",
        "Real",
        0.0,
        Bounds(1.0),
        meaning="each, with its attachments; 0.9 of the payload",
    ),
    Parameter("head-ropes", "1", "Integer", 4, Bounds(1, 20), meaning="head ropes"),
    Parameter("ropes", "1", "Integer", 1, Bounds(1, 20), meaning="balance ropes"),
    Parameter("rope", "1", "String", "34x7", meaning="the catalogue's construction"),
    Parameter("diameter", "m", "Real", 0.044, Bounds(1e-3, 1.0), meaning="of a balance rope"),
    Parameter("lay", "1", "String", "right-hand", choices=LAYS, meaning="of the balance ropes"),
    Parameter("acceleration", "m/s2", "Real", 0.8, Bounds(0.01), meaning="limit of the trip"),
    Parameter("jerk", "m/s3", "Real", 0.5, Bounds(0.01), meaning="limit of the trip"),
    Parameter("spacing", "m", "Real", 2.4, Bounds(0.01), meaning="between the rope's two ends"),
)


def new_hoist(name: str, chosen: Mapping[str, Value]) -> str:
    """Return the text of a file by values of WISHES.

    ValueError where the rope is not in the catalogue.
    """
    inputs = {p.name: ParameterValue(p.start, "assumed") for p in WISHES}
    inputs |= {wish: ParameterValue(value) for wish, value in chosen.items()}
    wish = {
        key: float(entry.value) for key, entry in inputs.items() if not isinstance(entry.value, str)
    }
    kind = str(inputs["rope"].value)
    payload = wish["payload"]
    depth = wish["depth"]
    mass = catalogue_rope(kind, wish["diameter"]).middle.mass_per_length
    if "conveyance" not in chosen:
        inputs["conveyance"] = ParameterValue(0.9 * payload, DERIVED, "0.9 of the payload")
    conveyance = float(inputs["conveyance"].value)
    number = int(wish["ropes"])
    head_mass = number * mass / wish["head-ropes"]
    head_diameter = math.sqrt(head_mass / 4000.0)
    radius = _rounded(50.0 * head_diameter)
    sheave = _rounded(1.5 * payload)
    motor = _rounded(0.4 * sheave)
    omega = 2.0 * math.pi * _SHAFT
    stiffness = _rounded(omega**2 * motor * (sheave - motor) / sheave * radius**2)

    def rule(value: float, expression: str) -> ParameterValue:
        return ParameterValue(value, DERIVED, expression)

    def ours(value: Value) -> ParameterValue:
        return ParameterValue(value, "assumed")

    values = {
        "hoist.shaft_travel": inputs["depth"],
        "hoist.payload_left": inputs["payload"],
        "hoist.conveyance_mass": inputs["conveyance"],
        "hoist.head_rope_number": inputs["head-ropes"],
        "hoist.head_rope_mass": rule(
            head_mass, "the balance ropes' mass over the head ropes' number"
        ),
        "hoist.head_rope_stiffness": rule(HEAD_ROPE_STIFFNESS * head_mass, "110 GPa of the steel"),
        "hoist.head_rope_damping": ours(0.02),
        "hoist.head_rope_length_up": ours(40.0),
        "hoist.head_rope_modes": ours(2),
        "hoist.sheave_radius": rule(
            radius, f"50 times {head_diameter:.3f} m, a head rope of 4000 kg/m3 d2"
        ),
        "hoist.sheave_mass": rule(sheave, "1.5 times the payload"),
        "hoist.loss_coulomb": rule(
            _rounded(0.01 * conveyance * GRAVITY), "1 % of a conveyance's weight"
        ),
        "hoist.loss_viscous": rule(_rounded(0.02 * payload), "0.02 1/s of the payload"),
        "hoist.friction_coefficient": ours(0.25),
        "hoist.wrap_angle": ours(math.pi),
        "hoist.drive_shaft.motor_mass": rule(motor, "0.4 of the sheave's"),
        "hoist.drive_shaft.stiffness": rule(stiffness, f"{_SHAFT:g} Hz"),
        "hoist.guides.coulomb": rule(
            _rounded(0.005 * conveyance * GRAVITY), "0.5 % of a conveyance's weight"
        ),
        "hoist.guides.viscous": rule(_rounded(0.01 * payload), "0.01 1/s of the payload"),
        "hoist.play.clearance": ours(5e-3),
        "winding.travel": rule(depth, "from landing to landing"),
        "winding.speed": inputs["speed"],
        "winding.acceleration": inputs["acceleration"],
        "winding.jerk": inputs["jerk"],
        "winding.settle": ours(15.0),
        "winding.emergency_deceleration": ours(2.0),
        "layout.spacing": inputs["spacing"],
    }
    parts = data_of(values_of(values))
    whole = hoist_with(parts["hoist"], [(number * mass, depth + TAIL_SPARE)])
    lifting = 2.6 * payload * GRAVITY * radius
    trip = 1.5 * RuleInputs(whole, parts["winding"], whole).torque()
    torque = _rounded(max(lifting, trip))
    values["hoist.torque_limit"] = rule(
        torque, "2.6 times what lifts the payload, or 1.5 times what the trip asks for"
    )
    stopping = radius * (
        whole.moving_mass * parts["winding"].emergency_deceleration + payload * GRAVITY
    )
    brake = _rounded(max(3.0 * payload * GRAVITY * radius, stopping))
    values["hoist.brake.torque"] = rule(
        brake, "3 times the payload's, or an emergency stop's with the payload going down"
    )
    values["hoist.power_limit"] = rule(
        _rounded(torque * wish["speed"] / radius), "of the torque at full speed"
    )
    alternate = inputs["lay"].value == LAYS[-1] and number > 1
    ropes = list[dict[str, ParameterValue]]()
    if alternate:
        for k in range(number):
            z = round(0.25 * wish["spacing"] * (k - 0.5 * (number - 1)), 3)
            ropes.append(
                {
                    "rope.name": ParameterValue(f"rope{k + 1}"),
                    "rope.z": rule(z, "a quarter of the spacing apart"),
                    "rope.construction": ParameterValue(kind),
                    "rope.lay": ParameterValue(LAYS[k % 2]),
                }
            )
    else:
        ropes.append(
            {
                "rope.number": ParameterValue(number),
                "rope.construction": ParameterValue(kind),
                "rope.lay": ParameterValue(inputs["lay"].value),
            }
        )
    for rope in ropes:
        rope["rope.diameter"] = inputs["diameter"]
        rope["rope.length"] = rule(depth + TAIL_SPARE, f"travel and {TAIL_SPARE:g} m")
        rope["rope.swivels.mode"] = ParameterValue("coulomb")
    return hoist_text(name, values, ropes, _COMMENT)


def _rounded(value: float) -> float:
    """Return the value to three digits: rules know no more."""
    return float(f"{value:.3g}")
