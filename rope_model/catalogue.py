"""Catalogue of round wire ropes: ranges of the properties of a construction that has not been measured.

Every datum is a range with its status and its source.  A rope of diameter d has

    mass per length   rho = W d^2                     W: mass factor of EN 12385-4 (there in kg per 100 m and mm^2)
    metal area        A = C d^2                       C: metallic area factor, ibid.
    axial stiffness   Qa = E_rope A
    torque factor     c1 = Qc / (Qa d): the torque of a tension T is c1 d T while nothing turns
    torsional stiffness at constant tension           D = Qd - Qb Qc / Qa: the result of a torsion test under load

Bending and torsion have two bounds: n equal wires of this area that slide freely, and a section
without slip whose metal fills the circle evenly:

    EI from E A^2 / (4 pi n) to E A d^2 / 16          D from 2 (G / E) times the first to 2 (G / E) times the second

The ``middle`` of a range is its geometric mean, or the arithmetic mean if it begins at 0.  Damping
and the growth of D with tension keep the defaults of ``Rope``: no source was found.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

from rope_model.parameter_table import require, require_number
from rope_model.parameters import Rope

DatumStatus = Literal["measured", "published", "derived", "calibrated", "contradicted", "assumed"]
Lay = Literal["right-hand", "left-hand"]

STEEL_MODULUS = 2.0e11  #: N/m^2, modulus of drawn steel wire
POISSON = 0.3  #: its Poisson ratio
SHEAR = 0.5 / (1 + POISSON)  #: its shear modulus over STEEL_MODULUS


@dataclass(frozen=True)
class Datum:
    """Range of a number, with its unit, its status and its source."""

    low: float  #: lower end
    high: float  #: upper end
    unit: str  #: unit of both
    status: DatumStatus  #: published, derived or assumed
    source: str  #: reference

    @property
    def middle(self) -> float:
        """Geometric mean, or the arithmetic one of a range that begins at 0."""
        if self.logarithmic:
            return math.sqrt(self.low * self.high)
        return 0.5 * (self.low + self.high)

    @property
    def logarithmic(self) -> bool:
        """True if the range is divided logarithmically."""
        return self.low > 0

    def at(self, share: float) -> float:
        """Return the value at a fraction between 0 and 1 of the range."""
        if self.logarithmic:
            return self.low * math.exp(share * math.log(self.high / self.low))
        return self.low + share * (self.high - self.low)


@dataclass(frozen=True)
class Property:
    """Property of a rope; ``power`` is the power of the diameter with which it grows in similar ropes."""

    power: int
    unit: str
    description: str


PROPERTIES = {
    "mass_per_length": Property(2, "kg/m", "mass per length"),
    "axial_stiffness": Property(2, "N", "tension over strain while nothing turns, Qa"),
    "torque_factor": Property(
        0, "1", "torque over tension and diameter while nothing turns, Qc / (Qa d)"
    ),
    "torsional_stiffness": Property(
        4, "N.m2", "torque over twist at constant tension, Qd - Qb Qc / Qa"
    ),
    "bending_stiffness": Property(4, "N.m2", "bending moment over curvature, EI"),
}

_EN = (
    "EN 12385-4, fibre and steel core, in K. Feyrer, Wire Ropes, table 1.9; "
    "http://what-when-how.com/Tutorial/topic-1297r4j9i2h/Wire-Ropes-Tension-Endurance-Reliability-51.html"
)
_STEEL_AREA = "area of EN 12385-4 and the steel's modulus, see rope_model/catalogue.py"
_SIX_STRANDS = (
    "EA of 6x19 in moorwire.py of https://github.com/ddjokic/Mooring-Line-Properties, over its area"
)
_SETTLED = f"lower end: {_SIX_STRANDS}; upper end: ours, for a rope that has settled"
_LAY = "ours: strands at d / 3, lays of 6 to 8 d, less up to a third by wires in ordinary lay"
_TWO_LAYERS = "ours: two layers of opposite lay, the outer one prevails"
_THREE_LAYERS = "ours: three layers, balanced within tolerance; the maker measures it"
_BENT = "lower end: wires that slide freely; upper end: ours, 16 times that, with friction"


@dataclass(frozen=True)
class Construction:
    """Construction of a rope: factors of EN 12385-4, number of wires, modulus and torque factor."""

    description: str
    mass: tuple[float, float]  # kg per 100 m and mm^2
    area: tuple[float, float]  # 1
    wires: int
    modulus: Datum  # N/m^2
    torque_factor: Datum

    def factors(self) -> dict[str, Datum]:
        """Return each property of PROPERTIES over its power of the diameter in m."""
        thin, thick = self.area
        n = self.wires
        sliding = [STEEL_MODULUS * area**2 / (4 * math.pi * n) for area in self.area]
        solid = STEEL_MODULUS * thick / 16
        return {
            # kg per 100 m and mm^2 is 1e4 kg/m^3
            "mass_per_length": Datum(
                1e4 * self.mass[0], 1e4 * self.mass[1], "kg/m3", "published", _EN
            ),
            "axial_stiffness": Datum(
                self.modulus.low * thin,
                self.modulus.high * thick,
                "N/m2",
                self.modulus.status,
                self.modulus.source,
            ),
            "torque_factor": self.torque_factor,
            "torsional_stiffness": Datum(
                2 * SHEAR * sliding[0],
                2 * SHEAR * solid,
                "N/m2",
                "derived",
                f"between all wires alone and none that slips: {_STEEL_AREA}",
            ),
            "bending_stiffness": Datum(sliding[0], 16 * sliding[1], "N/m2", "assumed", _BENT),
        }


_SINGLE_LAYER = Datum(0.07, 0.12, "1", "assumed", _LAY)
_MODULUS_OF_SIX_STRANDS = Datum(9.0e10, 9.6e10, "N/m2", "derived", _SIX_STRANDS)
_MODULUS_OF_MORE_LAYERS = Datum(9.0e10, 1.3e11, "N/m2", "assumed", _SETTLED)


def _head_rope(
    description: str, mass: tuple[float, float], area: tuple[float, float], wires: int
) -> Construction:
    return Construction(description, mass, area, wires, _MODULUS_OF_SIX_STRANDS, _SINGLE_LAYER)


#: constructions with a source of their factors; 35x6, 35x7 and ropes of 16 outer strands have none
CONSTRUCTIONS = {
    "34x7": Construction(
        "three layers of strands, the non-rotating rope of deep shafts",
        (0.390, 0.401),
        (0.416, 0.428),
        34 * 7,
        _MODULUS_OF_MORE_LAYERS,
        Datum(0.0, 0.02, "1", "assumed", _THREE_LAYERS),
    ),
    "18x7": Construction(
        "two layers of strands, rotation-resistant",
        (0.382, 0.401),
        (0.408, 0.433),
        18 * 7,
        _MODULUS_OF_MORE_LAYERS,
        Datum(0.02, 0.05, "1", "assumed", _TWO_LAYERS),
    ),
    "6x19": _head_rope(
        "one layer of strands, a head rope; as a balance rope it turns its loop",
        (0.359, 0.400),
        (0.384, 0.449),
        6 * 19,
    ),
    "6x36": _head_rope(
        "one layer of strands, a head rope, as 6x19", (0.367, 0.409), (0.393, 0.460), 6 * 36
    ),
    "8x36": _head_rope(
        "one layer of eight strands, a head rope, as 6x19", (0.348, 0.417), (0.357, 0.468), 8 * 36
    ),
}

_KOYO = "https://koyo.jtekt.co.jp/en/support/bearing-knowledge/8-4000.html"
_ROLLING = f"thrust ball to spherical roller thrust bearings; {_KOYO}"
_PLAIN = f"plain bearings, from well kept to special cases; {_KOYO}"
_STARTING = "starting up to twice running; https://roymech.org/Useful_Tables/Tribology/Bearing-Friction.html"
#: friction of a swivel by its bearing: running, and starting over running
BEARINGS = {
    "rolling": {
        "running_friction": Datum(0.0010, 0.0025, "1", "published", _ROLLING),
        "starting_ratio": Datum(1.0, 2.0, "1", "published", _STARTING),
    },
    "plain": {
        "running_friction": Datum(0.01, 0.2, "1", "published", _PLAIN),
        "starting_ratio": Datum(1.0, 2.0, "1", "assumed", f"as rolling bearings: {_STARTING}"),
    },
}


@dataclass(frozen=True)
class KnownRope:
    """A rope with a range of each property; ``rope`` takes one value of each."""

    construction: str  #: one of CONSTRUCTIONS
    diameter: float  #: m
    length: float = Rope.length  #: m
    lay: Lay = "right-hand"  #: sense of the lay
    data: Mapping[str, Datum] = field(default_factory=dict)  #: ranges by property

    @property
    def middle(self) -> Rope:
        """Rope with the middle of each range."""
        return self.rope()

    def rope(self, **properties: float) -> Rope:
        """Return the rope with these properties, and the middle of its range for each other.

        Parameters
        ----------
        **properties : float
            Values by the names of ``data``, in SI units.

        Returns
        -------
        Rope
            Parameters of a scene.

        Raises
        ------
        ValueError
            If a name is no property, or a value no number.
        """
        for name, value in properties.items():
            require(
                name in self.data, "property", name, f"one of {', '.join(self.data)}", "choose one"
            )
            require_number(name, value)
        known = {name: datum.middle for name, datum in self.data.items()} | properties
        return rope_of(self.diameter, self.length, self.lay, **known)


def rope(
    construction: str, diameter: float, length: float = Rope.length, lay: Lay = "right-hand"
) -> KnownRope:
    """Return the catalogue's ranges for a rope, as in ``rope("34x7", diameter=0.046)``.

    Parameters
    ----------
    construction : str
        One of CONSTRUCTIONS.
    diameter : float
        Diameter of the rope [m], at most 1.
    length : float
        Length between the two swivels [m].
    lay : {"right-hand", "left-hand"}
        A right-hand rope has positive Qb and Qc: stretched and free to turn, it unwinds.

    Returns
    -------
    KnownRope
        A range for each property, with status and source.

    Raises
    ------
    ValueError
        If an argument is out of its range; the message names the cure.
    """
    require(
        construction in CONSTRUCTIONS,
        "construction",
        construction,
        f"one of {', '.join(CONSTRUCTIONS)}",
        _ALTERNATIVE,
    )
    require(
        lay in get_args(Lay),
        "lay",
        lay,
        f"one of {', '.join(get_args(Lay))}",
        "see the rope's data sheet",
    )
    require_number("diameter", diameter)
    require_number("length", length)
    require(
        0.0 < diameter <= 1.0, "diameter", diameter, "above 0 and at most 1 m", "give it in metres"
    )
    require(0.0 < length < math.inf, "length", length, "above 0 and finite", "give it in metres")
    data = {}
    for name, factor in CONSTRUCTIONS[construction].factors().items():
        kind = PROPERTIES[name]
        scale = diameter**kind.power
        data[name] = Datum(
            scale * factor.low, scale * factor.high, kind.unit, factor.status, factor.source
        )
    return KnownRope(construction, diameter, length, lay, data)


_ALTERNATIVE = "take the one with as many layers, or give the parameters of the data sheet"


def rope_of(
    diameter: float,
    length: float,
    lay: Lay,
    *,
    mass_per_length: float,
    axial_stiffness: float,
    torque_factor: float,
    torsional_stiffness: float,
    bending_stiffness: float,
) -> Rope:
    """Return the rope with these values of PROPERTIES."""
    coupling = (
        {"right-hand": 1.0, "left-hand": -1.0}[lay] * torque_factor * axial_stiffness * diameter
    )
    return Rope(
        length=length,
        mass_per_length=mass_per_length,
        Qa=axial_stiffness,
        Qb=coupling,
        Qc=coupling,
        Qd=torsional_stiffness + coupling * coupling / axial_stiffness,
        EI=bending_stiffness,
        rhoJ=mass_per_length * diameter**2 / 8,
        diameter=diameter,
    )


def properties_of(rope: Rope) -> dict[str, float]:
    """Return the values of PROPERTIES of a rope with Qb = Qc; the inverse of ``rope_of`` without the lay."""
    return {
        "mass_per_length": rope.mass_per_length,
        "axial_stiffness": rope.Qa,
        "torque_factor": abs(rope.Qc) / (rope.Qa * rope.diameter),
        "torsional_stiffness": rope.Qd - rope.Qb * rope.Qc / rope.Qa,
        "bending_stiffness": rope.EI,
    }
