"""Units, quantities and declared types of the model descriptions."""

import math
from collections.abc import Iterable
from typing import NamedTuple
from xml.etree.ElementTree import Element

from fmu_src.interface import Variable
from fmu_src.xml import node


class DeclaredType(NamedTuple):
    """Declared type of all variables with one unit, and the unit's definition."""

    name: str  # name in the Modelica Standard Library if it has one
    nominal: float
    base: dict[str, int]  # exponents of the SI base units
    display: tuple[str, float] | None = None  # display unit, and its factor
    preferred: bool = True  # true if tools shall show the display unit


_DEGREES = 180 / math.pi
#: quantities by unit
DECLARED_TYPES: dict[str, DeclaredType] = {
    "m": DeclaredType("Length", 10.0, {"m": 1}, ("mm", 1e3), preferred=False),
    "s": DeclaredType("Time", 1.0, {"s": 1}, ("ms", 1e3), preferred=False),
    "kg": DeclaredType("Mass", 1e3, {"kg": 1}),
    "1": DeclaredType("Ratio", 1.0, {}),
    "rad": DeclaredType("Angle", 1.0, {"rad": 1}, ("deg", _DEGREES)),
    "rad/m": DeclaredType("Twist", 1.0, {"rad": 1, "m": -1}, ("deg/m", _DEGREES)),
    "rad/s": DeclaredType("AngularVelocity", 1.0, {"rad": 1, "s": -1}, ("deg/s", _DEGREES)),
    "m/s": DeclaredType("Velocity", 1.0, {"m": 1, "s": -1}),
    "m/s2": DeclaredType("Acceleration", 1.0, {"m": 1, "s": -2}),
    "kg/m": DeclaredType("LinearDensity", 10.0, {"kg": 1, "m": -1}),
    "kg/m3": DeclaredType("Density", 1.0, {"kg": 1, "m": -3}),
    "kg.m": DeclaredType("PolarMassMomentPerLength", 1e-3, {"kg": 1, "m": 1}),
    "kg.m2": DeclaredType("MomentOfInertia", 0.1, {"kg": 1, "m": 2}),
    "N": DeclaredType("Force", 1e4, {"kg": 1, "m": 1, "s": -2}, ("kN", 1e-3)),
    "N.s": DeclaredType("Impulse", 100.0, {"kg": 1, "m": 1, "s": -1}),
    "N.m": DeclaredType("Torque", 100.0, {"kg": 1, "m": 2, "s": -2}),
    "N.m2": DeclaredType("Stiffness", 1e3, {"kg": 1, "m": 3, "s": -2}),
    "N/m2": DeclaredType("StiffnessPerLength", 1e6, {"kg": 1, "m": -1, "s": -2}),
    "s/m": DeclaredType("DampingPerForce", 1.0, {"s": 1, "m": -1}),
    "Pa": DeclaredType("Stress", 1e8, {"kg": 1, "m": -1, "s": -2}, ("MPa", 1e-6)),
    "J": DeclaredType("Energy", 1e6, {"kg": 1, "m": 2, "s": -2}, ("kJ", 1e-3)),
    "1/s": DeclaredType("PositionGain", 1.0, {"s": -1}),
    "1/m": DeclaredType("Curvature", 1.0, {"m": -1}),
    "Hz": DeclaredType("Frequency", 1.0, {"s": -1}),
    "N.s/m": DeclaredType("SpeedGain", 1e5, {"kg": 1, "s": -1}),
}


def units_of(table: Iterable[Variable]) -> list[str]:
    """Return the units in the table, sorted."""
    return sorted({v.unit for v in table} - {""})


def unit_definition(name: str) -> Element:
    """Return the ``Unit`` element, which is the same in FMI 2.0 and 3.0."""
    quantity = DECLARED_TYPES[name]
    displays = []
    if quantity.display is not None:
        display, factor = quantity.display
        displays = [node("DisplayUnit", name=display, factor=repr(factor))]
    return node("Unit", node("BaseUnit", **quantity.base), *displays, name=name)


def quantity_attributes(unit: str) -> dict[str, str | None]:
    """Return the attributes of the declared type of ``unit``."""
    quantity = DECLARED_TYPES[unit]
    display = None
    if quantity.display is not None and quantity.preferred:
        display, _ = quantity.display
    return {
        "quantity": quantity.name,
        "unit": unit,
        "nominal": f"{quantity.nominal:g}",
        "displayUnit": display,
    }
