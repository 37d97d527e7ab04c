"""Units, quantities and declared types of the model descriptions."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

from fmu_src.interface import Variable


class Quantity(NamedTuple):
    """The declared type of all variables with one unit: its name, nominal value and display unit ('' for none)."""

    name: str
    nominal: float
    display: str = ""


#: unit -> exponents of the SI base units, and display units (name, factor)
_UNITS: dict[str, tuple[dict[str, int], dict[str, float]]] = {
    "m": ({"m": 1}, {"mm": 1e3}),
    "s": ({"s": 1}, {"ms": 1e3}),
    "kg": ({"kg": 1}, {}),
    "1": ({}, {}),
    "rad": ({"rad": 1}, {"deg": 180 / math.pi}),
    "rad/m": ({"rad": 1, "m": -1}, {"deg/m": 180 / math.pi}),
    "rad/s": ({"rad": 1, "s": -1}, {"deg/s": 180 / math.pi}),
    "m/s": ({"m": 1, "s": -1}, {}),
    "m/s2": ({"m": 1, "s": -2}, {}),
    "kg/m": ({"kg": 1, "m": -1}, {}),
    "kg/m3": ({"kg": 1, "m": -3}, {}),
    "kg.m": ({"kg": 1, "m": 1}, {}),
    "kg.m2": ({"kg": 1, "m": 2}, {}),
    "N": ({"kg": 1, "m": 1, "s": -2}, {"kN": 1e-3}),
    "N.s": ({"kg": 1, "m": 1, "s": -1}, {}),
    "N.m": ({"kg": 1, "m": 2, "s": -2}, {}),
    "N.m2": ({"kg": 1, "m": 3, "s": -2}, {}),
    "N/m2": ({"kg": 1, "m": -1, "s": -2}, {}),
    "s/m": ({"s": 1, "m": -1}, {}),
    "Pa": ({"kg": 1, "m": -1, "s": -2}, {"MPa": 1e-6}),
    "J": ({"kg": 1, "m": 2, "s": -2}, {"kJ": 1e-3}),
    "1/s": ({"s": -1}, {}),
    "1/m": ({"m": -1}, {}),
    "N.s/m": ({"kg": 1, "s": -1}, {}),
}
#: unit -> declared type; the names are those of the Modelica Standard Library where it has them
QUANTITIES: dict[str, Quantity] = {
    "m": Quantity("Length", 10.0),
    "s": Quantity("Time", 1.0),
    "kg": Quantity("Mass", 1e3),
    "1": Quantity("Ratio", 1.0),
    "rad": Quantity("Angle", 1.0, "deg"),
    "rad/m": Quantity("Twist", 1.0, "deg/m"),
    "rad/s": Quantity("AngularVelocity", 1.0, "deg/s"),
    "m/s": Quantity("Velocity", 1.0),
    "m/s2": Quantity("Acceleration", 1.0),
    "kg/m": Quantity("LinearDensity", 10.0),
    "kg/m3": Quantity("Density", 1.0),
    "kg.m": Quantity("PolarMassMomentPerLength", 1e-3),
    "kg.m2": Quantity("MomentOfInertia", 0.1),
    "N": Quantity("Force", 1e4, "kN"),
    "N.s": Quantity("Impulse", 100.0),
    "N.m": Quantity("Torque", 100.0),
    "N.m2": Quantity("Stiffness", 1e3),
    "N/m2": Quantity("StiffnessPerLength", 1e6),
    "s/m": Quantity("DampingPerForce", 1.0),
    "Pa": Quantity("Stress", 1e8, "MPa"),
    "J": Quantity("Energy", 1e6, "kJ"),
    "1/s": Quantity("PositionGain", 1.0),
    "1/m": Quantity("Curvature", 1.0),
    "N.s/m": Quantity("SpeedGain", 1e5),
}


def units_of(table: Iterable[Variable]) -> list[str]:
    """The units that occur, sorted."""
    return sorted({v.unit for v in table} - {""})


def add_units(parent: Element, table: Iterable[Variable]) -> None:
    """``UnitDefinitions``, alike in FMI 2.0 and 3.0."""
    definitions = SubElement(parent, "UnitDefinitions")
    for name in units_of(table):
        base, displays = _UNITS[name]
        unit = SubElement(definitions, "Unit", name=name)
        SubElement(unit, "BaseUnit", {key: str(exponent) for key, exponent in base.items()})
        for display, factor in displays.items():
            SubElement(unit, "DisplayUnit", name=display, factor=repr(factor))


def quantity_attributes(unit: str) -> dict[str, str]:
    """Attributes of the declared type of ``unit``."""
    quantity = QUANTITIES[unit]
    attributes = {"quantity": quantity.name, "unit": unit, "nominal": f"{quantity.nominal:g}"}
    return attributes | ({"displayUnit": quantity.display} if quantity.display else {})
