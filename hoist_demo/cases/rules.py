"""What a hoist's file leaves out and what follows from the rest, by stated rules.

And values that no hoist has.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from hoist_demo.cases.case import BalanceRopeData, Case
from hoist_demo.files.registry import data_of, host_parameters, rope_parameters
from hoist_demo.files.rope_file import CATALOGUE_PARAMETERS
from hoist_demo.files.values import DERIVED, ParameterValue, values_of
from hoist_demo.parameters import Hoist, Winding, hoist_with, require_trip_fits
from hoist_demo.parameters.problems import Problems
from hoist_demo.parameters.quantity import Value
from hoist_demo.parameters.suspension import SuspensionOffset
from rope_model import rope as catalogue_rope
from rope_model.physics.estimates import NATURAL_WIDTH

#: Length of a balance rope beyond the travel [m, assumed]: loop, and sump below the lower landing.
TAIL_SPARE = 40.0
#: EA of a head rope over its mass per length [m^2/s^2, assumed], a modulus of 110 GPa of the steel.
HEAD_ROPE_STIFFNESS = 1.3e7
#: Limit of the motor over the torque that the trip needs with the payload [assumed].
TRIP_TORQUE = 1.5
# default gains of the controller [assumed]
SPEED_GAIN = 3.0  #: Over all moving masses [1/s].
INTEGRAL_TIME = 2.0  #: [s]
POSITION_GAIN = 0.5  #: [1/s]
#: Relative difference of stated totals of balance ropes from their sum that rounding explains.
TOTALS_TOLERANCE = 1e-3


@dataclass(frozen=True)
class RuleInputs:
    """Inputs of the rules: hoist and trip as stated so far, and ropes as the drive sees them."""

    hoist: Hoist
    winding: Winding
    rope: Hoist  # hoist with number, mass and length of the balance ropes alone

    def torque(self, travelled: float = 0.0) -> float:
        """Return the torque at the sheave that accelerates the hoist [N m].

        ``travelled`` is the way from a landing [m].
        """
        hoist = self.hoist
        coulomb, viscous = hoist.travel_loss
        force = hoist.moving_mass * self.winding.acceleration + hoist.imbalance(travelled)
        return hoist.sheave_radius * (force + (coulomb + viscous * self.winding.speed))


class Rule(NamedTuple):
    """Rule for a parameter that the file leaves out."""

    key: str
    expression: str
    value: Callable[[RuleInputs], Value]


LENGTH = Rule(
    "rope.length",
    f"hoist.shaft_travel + {TAIL_SPARE:g} m",
    lambda k: k.hoist.shaft_travel + TAIL_SPARE,
)
RULES = (
    Rule(
        "hoist.tail_rope_number",
        "number of the only [[rope]]; 1 of several that differ",
        lambda k: k.rope.tail_rope_number,
    ),
    Rule(
        "hoist.tail_rope_mass",
        "rope.mass_per_length; the sum of ropes that differ",
        lambda k: k.rope.tail_rope_mass,
    ),
    Rule(
        "hoist.tail_rope_length",
        "rope.length; the mean by mass of ropes that differ",
        lambda k: k.rope.tail_rope_length,
    ),
    Rule(
        "winding.travel",
        "hoist.shaft_travel, from landing to landing",
        lambda k: k.hoist.shaft_travel,
    ),
    Rule(
        "hoist.head_rope_mass",
        "mass per length of all balance ropes over hoist.head_rope_number, which balances them",
        lambda k: k.hoist.tail_mass / k.hoist.head_rope_number,
    ),
    Rule(
        "hoist.head_rope_stiffness",
        f"{HEAD_ROPE_STIFFNESS:g} m2/s2 times hoist.head_rope_mass",
        lambda k: HEAD_ROPE_STIFFNESS * k.hoist.head_rope_mass,
    ),
    Rule(
        "hoist.torque_limit",
        f"{TRIP_TORQUE:g} times the torque of the acceleration with the payload, R (m a + "
        "difference of the weights with ropes + losses)",
        lambda k: TRIP_TORQUE * k.torque(),
    ),
    Rule(
        "gains.speed",
        f"{SPEED_GAIN:g} 1/s times all moving masses",
        lambda k: SPEED_GAIN * k.hoist.moving_mass,
    ),
    Rule("gains.integral_time", f"{INTEGRAL_TIME:g} s", lambda _: INTEGRAL_TIME),
    Rule("gains.position", f"{POSITION_GAIN:g} 1/s", lambda _: POSITION_GAIN),
)


def apply_rules(
    host: Mapping[str, ParameterValue], ropes: Iterable[BalanceRopeData], **header: Any
) -> Case:
    """Return the hoist of what is stated of its host and ropes, with all that follows.

    ValueError where none can be.
    """
    host = dict(host)
    if "hoist.shaft_travel" not in host and "winding.travel" in host:
        deep = abs(float(host["winding.travel"].value))
        host["hoist.shaft_travel"] = ParameterValue(deep, DERIVED, "winding.travel")
    sections = data_of(values_of(host))
    complete_ropes = _with_lengths(
        ropes, RuleInputs(sections["hoist"], sections["winding"], Hoist())
    )
    _fill_in(host, sections, _require_totals_fit(host, complete_ropes))
    require_trip_fits(sections["hoist"], sections["winding"])
    # each line once, whatever the number of ropes that share it
    remarks_once: dict[str, None] = {}
    notes_once: dict[str, None] = {}
    for rope in complete_ropes:
        remarks_once |= dict.fromkeys(remarks(values_of({**host, **rope.values})))
        notes_once |= dict.fromkeys(notes(sections["hoist"], rope))
    return Case(
        **header,
        hoist=sections["hoist"],
        winding=sections["winding"],
        gains=sections["gains"],
        host=host,
        balance_ropes=complete_ropes,
        rope=complete_ropes[0].parameters,
        remarks=tuple(remarks_once),
        notes=tuple(notes_once),
    )


def _with_lengths(
    ropes: Iterable[BalanceRopeData], inputs: RuleInputs
) -> tuple[BalanceRopeData, ...]:
    """Return the ropes with the length by the rule and the catalogue's data where none are stated."""
    length = ParameterValue(LENGTH.value(inputs), DERIVED, LENGTH.expression, follows=True)
    filled: list[BalanceRopeData] = []
    with Problems() as problems:
        for k, rope in enumerate(ropes, 1):
            with problems.at(f"rope {k}"):
                values = {"rope.length": length, **_of_catalogue(rope), **rope.values}
                filled.append(replace(rope, values=values))
    return tuple(filled)


def _require_totals_fit(
    host: Mapping[str, ParameterValue], ropes: tuple[BalanceRopeData, ...]
) -> Hoist:
    """Return a hoist with the sums of the ropes; ValueError where the host states others."""
    drive = rope_totals(ropes)
    stated_number = host.get("hoist.tail_rope_number")
    if stated_number is not None and stated_number.value != drive.tail_rope_number:
        raise ValueError(
            f"hoist.tail_rope_number = {stated_number.value} must be "
            f"{drive.tail_rope_number}, as number of the [[rope]] says: leave it out"
        )
    if any(map(_has_a_place, ropes)) or len(ropes) > 1:
        _require_totals(host, drive)
    return drive


def _fill_in(host: dict[str, ParameterValue], sections: dict[str, Any], drive: Hoist) -> None:
    """Add to ``host`` and its ``sections`` what follows by RULES, each from those before it."""
    for rule in RULES:
        if rule.key in host:
            continue
        value = rule.value(RuleInputs(sections["hoist"], sections["winding"], drive))
        host[rule.key] = ParameterValue(value, DERIVED, rule.expression, follows=True)
        section, _, field = rule.key.partition(".")
        try:
            sections[section] = replace(sections[section], **{field: value})
        except ValueError as error:
            raise ValueError(f"{section}: {error}") from error


def _of_catalogue(rope: BalanceRopeData) -> dict[str, ParameterValue]:
    """Return what the catalogue knows of a rope; ValueError where it has none such."""
    if not rope.construction:
        return {}
    diameter = float(rope.parameters.get("rope.diameter", 0.0))
    mean = catalogue_rope(rope.construction, diameter, lay=rope.lay).middle  # type: ignore[arg-type]  # checks the lay
    source = f"catalogue, {rope.construction}, middle of its range"
    return {
        f"rope.{name}": ParameterValue(getattr(mean, name), DERIVED, source, follows=True)
        for name in CATALOGUE_PARAMETERS
    }


def _has_a_place(rope: BalanceRopeData) -> bool:
    """Return True for a rope with a suspension or a break of its own."""
    return bool(rope.suspension or rope.breaks)


def _require_totals(host: Mapping[str, ParameterValue], drive: Hoist) -> None:
    """Refuse mass or length of the balance ropes that differ from the totals of the ropes."""
    with Problems() as problems:
        for key in ("tail_rope_mass", "tail_rope_length"):
            total = getattr(drive, key)
            entry = host.get(f"hoist.{key}")
            if entry is not None and not math.isclose(
                float(entry.value), total, rel_tol=TOTALS_TOLERANCE
            ):
                problems.append(
                    f"hoist.{key} = {float(entry.value):g} must be {total:.6g}, as the [[rope]] say: "
                    "leave it out"
                )


def rope_totals(ropes: tuple[BalanceRopeData, ...]) -> Hoist:
    """Return a hoist with number, mass and length of the balance ropes as the drive takes them."""
    default_mass = rope_parameters()["rope.mass_per_length"].start
    masses_and_lengths = []
    for rope in ropes:
        mass = rope.parameters.get("rope.mass_per_length", default_mass)
        masses_and_lengths.append((float(mass), float(rope.parameters["rope.length"])))
    number = sum(rope.number for rope in ropes)
    if len(ropes) == 1 and not _has_a_place(ropes[0]):
        mass, length = masses_and_lengths[0]
        return Hoist(tail_rope_number=number, tail_rope_mass=mass, tail_rope_length=length)
    if number > len(ropes):
        raise ValueError(
            "number must be 1 where ropes hang at places of their own: give each its own [[rope]]"
        )
    return hoist_with(Hoist(), masses_and_lengths)


def case_with_values(case: Case, values: Mapping[str, Value | ParameterValue]) -> Case:
    """Return the hoist with values as if they stood in its file; derived values follow anew."""
    if not values:
        return case
    of_host: dict[str, ParameterValue] = {}
    of_rope: dict[str, ParameterValue] = {}
    for key, value in values.items():
        if isinstance(value, ParameterValue):
            entry = value
        else:
            entry = ParameterValue(value)
        if key in host_parameters():
            of_host[key] = entry
        else:
            of_rope[key] = entry
    ropes = [
        replace(rope, values=_without_derived(rope.values) | of_rope) for rope in case.balance_ropes
    ]
    header = {name: getattr(case, name) for name in ("name", "source", "level", "signals")}
    return apply_rules(_without_derived(case.host) | of_host, ropes, **header)


def _without_derived(values: Mapping[str, ParameterValue]) -> dict[str, ParameterValue]:
    return {key: entry for key, entry in values.items() if not entry.follows}


#: Usual ranges [assumed]: a value beyond draws a remark that its unit may be wrong.
USUAL = {
    "hoist.payload_left": (200.0, 6e4),
    "hoist.payload_right": (200.0, 6e4),
    "hoist.conveyance_mass": (500.0, 8e4),
    "hoist.conveyance_mass_right": (500.0, 8e4),
    "hoist.sheave_mass": (500.0, 2e5),
    "hoist.sheave_radius": (0.4, 5.0),
    "hoist.torque_limit": (1e3, 5e6),
    "hoist.power_limit": (1e4, 2e7),
    "hoist.head_rope_mass": (0.3, 30.0),
    "hoist.head_rope_stiffness": (3e6, 5e8),
    "hoist.head_rope_length_up": (2.0, 200.0),
    "hoist.shaft_travel": (20.0, 3500.0),
    "winding.speed": (1.0, 25.0),
    "winding.acceleration": (0.05, 2.0),
    "winding.jerk": (0.05, 5.0),
    "winding.emergency_deceleration": (0.5, 10.0),
    "rope.length": (20.0, 3600.0),
    "rope.mass_per_length": (0.3, 40.0),
    "rope.diameter": (0.008, 0.12),
    "rope.Qa": (1e6, 1e9),
    "layout.spacing": (0.3, 8.0),
}


def remarks(values: Mapping[str, Value]) -> Iterable[str]:
    """Yield a line on each value that is far from what hoists have."""
    units = {**rope_parameters(), **host_parameters()}
    for key, (low, high) in USUAL.items():
        value = values.get(key)
        if not isinstance(value, float) or value == 0.0 or not math.isfinite(value):
            continue
        if not low <= abs(value) <= high:
            unit = units[key].unit
            yield (
                f"{key} = {value:g} {unit} is far from what hoists have, {low:g} to {high:g} "
                f"{unit} [assumed]: check its unit"
            )


#: Least spacing of the balance rope's ends over the sheave's diameter without deflection sheaves
#: [assumed].
MIN_SPACING = 0.5


def notes(hoist: Hoist, rope: BalanceRopeData) -> Iterable[str]:
    """Yield a line on a place of the rope that is right for some hoists only."""

    def value(name: str) -> float:
        return float(rope.parameters.get(name, rope_parameters()[name].start))

    spacing = SuspensionOffset(**rope.suspension).end_distance(value("layout.spacing"))
    diameter = 2.0 * hoist.sheave_radius
    if spacing < MIN_SPACING * diameter:
        yield (
            f"layout.spacing: the rope's ends are {spacing:.4g} m apart beside a sheave of "
            f"{diameter:.4g} m diameter; {MIN_SPACING * diameter:.4g} m or more is usual without "
            "deflection sheaves [assumed]: check both, and that there are deflection sheaves"
        )
    weight = value("rope.mass_per_length") * value("layout.gravity")
    width = NATURAL_WIDTH * (value("rope.EI") / weight) ** (1.0 / 3.0)
    if spacing < width:
        yield (
            f"layout.spacing: the rope's ends are {spacing:.4g} m apart, less than the width of "
            f"its free loop, {NATURAL_WIDTH:.4g} (EI/(rho g))^(1/3) = {width:.4g} m: the loop bulges beyond its "
            "legs; give the distance of the rope's ends, or check rope.EI"
        )
