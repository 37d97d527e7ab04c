"""Parameters of the shaft: bodies near the rope, contact, guards of the loop, and air.

Sizes are in m, heights count from the origin of the conveyances' heights.  Without a width, a
diameter or a size a body is absent.  ``physics.shaft`` makes the bodies from them.
"""

from dataclasses import dataclass, field
from typing import get_type_hints

from rope_model.parameter_table import Bounds, ParameterGroup, angle_parameter, parameter

#: m, longer than any shaft; a clearance of this much means that there is no such body
FAR = 1e6
#: m, bound of positions and sizes
REACH = 1e4

_NONE = "use 0 for none, or give it in metres"
_EDGE_CURE = "0 is sharp-edged, 1 as round as it can be"


def _size(default: float, description: str) -> float:
    return parameter(default, "m", description, Bounds(0.0, REACH, _NONE))


def _position(description: str) -> float:
    return parameter(0.0, "m", description, Bounds(-REACH, REACH, "give it in metres"))


def _rounding(default: float, description: str) -> float:
    return parameter(default, "1", description, Bounds(0.0, 1.0, _EDGE_CURE))


@dataclass(frozen=True)
class Lining(ParameterGroup):
    """Wall of the shaft: a rectangle with rounded corners or, wholly rounded, a circle."""

    width: float = _size(0.0, "width of the shaft in X; 0: none")
    depth: float = _size(0.0, "width of the shaft in Z")
    rounding: float = _rounding(0.0, "radius of the corners over half the smaller width; 1: round")
    x: float = _position("X of the shaft's axis from midway between the ends")
    z: float = _position("Z of the shaft's axis from the ends")


@dataclass(frozen=True)
class Conveyance(ParameterGroup):
    """Either conveyance: an upright box that moves with the suspension point below it; its yaw is left out."""

    width: float = _size(0.0, "width of a conveyance in X; 0: none")
    depth: float = _size(0.0, "width of a conveyance in Z")
    height: float = _size(0.0, "height of a conveyance")
    above: float = _size(0.0, "height of its underside above the rope's end")


@dataclass(frozen=True)
class HeadRopes(ParameterGroup):
    """Head ropes above each conveyance: an upright row, closed between its outermost ropes."""

    diameter: float = _size(0.0, "diameter of a head rope; 0: none")
    row: float = _size(0.0, "distance of the outermost head ropes, in a row along Z")


@dataclass(frozen=True)
class Divider(ParameterGroup):
    """Horizontal beam from wall to wall, of square or round section."""

    size: float = _size(0.0, "side or diameter of the section; 0: none")
    y: float = _position("height of the axis, from the origin of left.y and right.y")
    offset: float = _position("place of the axis across it, X where it lies along Z")
    direction: float = angle_parameter("yaw about Y, 0: along Z")
    rounding: float = _rounding(1.0, "radius of the corners over half the side: 0 square, 1 round")


@dataclass(frozen=True)
class Sump(ParameterGroup):
    """Lower end of the shaft: its floor, or water standing in it."""

    level: float = parameter(
        -FAR,
        "m",
        "height of floor or water, from the origin of left.y and right.y; -1e6: none",
        Bounds(-FAR, REACH, "give it in metres, or -1e6 for none"),
    )


@dataclass(frozen=True)
class Contact(ParameterGroup):
    """Contact of the rope with a body or with itself, per length: see physics.contact."""

    stiffness: float = parameter(
        1e6,
        "N/m2",
        "contact stiffness of rope and body, per length; 0: bodies do not hold the rope [assumed]",
        Bounds(0.0, 1e9, "1e6 holds a falling rope within a diameter"),
    )
    damping: float = parameter(
        0.5,
        "s/m",
        "relative growth of the contact force per speed of approach [assumed]",
        Bounds(0.0, 100.0, "use 0 for a perfect rebound"),
    )
    friction: float = parameter(
        0.2,
        "1",
        "coefficient of friction of rope and body [assumed]",
        Bounds(0.0, 10.0, "use 0 for none"),
    )
    slip_speed: float = parameter(
        0.01,
        "m/s",
        "speed at which friction has reached 71 % of its force; slower ropes creep",
        Bounds(1e-6, 10.0, "use 0.01"),
    )
    rope_stiffness: float = parameter(
        0.0,
        "N/m2",
        "contact stiffness of the rope with itself, per length; 0: legs pass through each other",
        Bounds(0.0, 1e9, "1e7 holds a leg that swings across the other"),
    )


def _threshold(unit: str, description: str, cure: str) -> float:
    return parameter(0.0, unit, f"{description}; 0: none", Bounds(0.0, FAR, cure))


def _delay() -> float:
    return parameter(
        0.0, "s", "delay before this guard trips", Bounds(0.0, REACH, "use 0 to trip at once")
    )


def _switch(description: str) -> float:
    return parameter(
        -FAR, "m", description, Bounds(-FAR, REACH, "give it in metres, or -1e6 to follow the loop")
    )


_OFF = "use 0 for no such guard"


@dataclass(frozen=True)
class Guard(ParameterGroup):
    """Guards of the loop: thresholds, delays, and heights of those that are switches: see physics.guard."""

    rise: float = _threshold("m", "rise of the loop that trips a guard", _OFF)
    rise_delay: float = _delay()
    rise_y: float = _switch(
        "height from which the rise counts; -1e6: the loop's quasi-static place"
    )
    window: float = _threshold(
        "m", "horizontal distance of the loop from midway between the ends that trips a guard", _OFF
    )
    window_delay: float = _delay()
    window_y: float = _switch(
        "height at which the window watches the legs instead; -1e6: the loop's lowest point"
    )
    clearance: float = _threshold("m", "distance from a body of the shaft that trips a guard", _OFF)
    clearance_delay: float = _delay()
    turns: float = _threshold(
        "1", "turns of one side of the rope about the other that trip a guard", _OFF
    )
    turns_delay: float = _delay()
    torque: float = _threshold("N.m", "moment of a swivel that trips a guard", _OFF)
    torque_delay: float = _delay()


_ACROSS = " within air.cross_height"


def _velocity(axis: str, where: str) -> float:
    text = f"velocity of the air along {axis}{where}; changes between steps make gusts"
    return parameter(0.0, "m/s", text, Bounds(-100.0, 100.0, "give it in m/s"), tunable=True)


@dataclass(frozen=True)
class Air(ParameterGroup):
    """Air in the shaft: vertical and horizontal wind, and flow aside of passing conveyances: see physics.air."""

    density: float = parameter(
        0.0,
        "kg/m3",
        "density of the air; 0: none",
        Bounds(0.0, 100.0, "air at the surface has 1.2, 1000 m deeper 1.35"),
    )
    drag: float = parameter(
        1.2,
        "1",
        "drag coefficient of the rope across the flow [assumed]",
        Bounds(0.0, 10.0, "stranded ropes have 1.0 to 1.3"),
    )
    vx: float = _velocity("X", _ACROSS)
    vy: float = _velocity("Y, upwards", "")
    vz: float = _velocity("Z", _ACROSS)
    cross_y: float = _position(
        "height of the middle of a gallery that blows, from the origin of left.y and right.y"
    )
    cross_height: float = parameter(
        FAR,
        "m",
        "height of that gallery, from floor to roof; 1e6: air blows everywhere",
        Bounds(
            0.1, FAR, "give the height of the gallery's mouth, or 1e6 for air that moves as one"
        ),
    )
    buffet: float = parameter(
        0.0,
        "1",
        "speed of the air that a passing conveyance pushes at the leg beside it, over its own; 0: none [assumed]",
        Bounds(
            0.0,
            10.0,
            "0.06 suits a conveyance of 3 m2 in the open, 2 m away; in a shaft it is more",
        ),
    )
    buffet_length: float = parameter(
        4.0,
        "m",
        "height of that conveyance, from tail to bow [assumed]",
        Bounds(0.1, 100.0, "give the height of the skip or cage"),
    )


@dataclass(frozen=True)
class Shaft:
    """Bodies that the rope may come near, contact, guards of its loop, and air."""

    lining: Lining = field(default_factory=Lining)
    conveyance: Conveyance = field(default_factory=Conveyance)
    head_ropes: HeadRopes = field(default_factory=HeadRopes)
    divider_1: Divider = field(default_factory=Divider)
    divider_2: Divider = field(default_factory=Divider)
    divider_3: Divider = field(default_factory=Divider)
    divider_4: Divider = field(default_factory=Divider)
    sump: Sump = field(default_factory=Sump)
    contact: Contact = field(default_factory=Contact)
    guard: Guard = field(default_factory=Guard)
    air: Air = field(default_factory=Air)


#: parts of a shaft by name
PARTS: dict[str, type] = get_type_hints(Shaft)
