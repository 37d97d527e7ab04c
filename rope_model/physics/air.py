"""Drag of the air on the rope, per length of its centre line.

With the unit tangent t and the rope's velocity w against the air, whose part across the rope is w_n = w - (w . t) t,

    f = -1/2 rho_a c_d d |w_n| w_n

the drag of a cylinder across a flow; the flow along it is left out, as are vortices.  |w_n| is rounded off below
ROUNDING, where nothing is left of it.

Along the shaft the air moves as one.  Across it, it blows everywhere or where a gallery opens, h high about the height
y0, at the share c of its speed with

    c^2 = S((y - y0 + h/2)/e) - S((y - y0 - h/2)/e)

where S goes from 0 at -1/2 to 1 at 1/2 as the cubic with level ends, so that int c^2 dy = h whatever the edges' width
e: a jet that spreads keeps its momentum, and a rope across it its drag.  e is EDGE and the element's length together:
the element looks at few places, between which a narrow flow would be lost.

A conveyance that passes moves the air aside.  In potential flow a slender body that moves at the speed V
along its axis has a source at its bow and a sink of the same strength at its tail (Rankine's ovoid).  D away from the
axis, at the height h above one of them, each moves the air across at

    b V (1 + (h/D)^2)^(-3/2)

outwards at the bow, inwards at the tail; b is A/(4 pi D^2) for a body of the cross section A in the open, more between
walls.  D is the spacing of the suspensions: this is the flow at the leg beside the conveyance, where it hangs at rest.
It is taken as proportional to the distance from the axis, so that the leg below the conveyance itself feels none.

The tangent -df/dv is symmetric: it leaves out that t turns, and that the flow changes from place to place.

Works on numbers and CasADi expressions; vectors have their components first.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

from rope_model.physics.elementary import dot, sqrt

#: m/s
ROUNDING = 1e-6
#: m: width of the edge of a flow from a gallery [assumed]
EDGE = 0.5


class AirLaw(NamedTuple):
    """Numbers of the law: force per length and square of the speed, the air's velocity (m/s), b, and lengths in m."""

    factor: float  # kg/m2
    velocity: tuple[float, float, float]
    buffet: float
    height: float  # of a conveyance
    spacing: float
    cross_y: float  # middle and height of the gallery
    cross_height: float


class Passing(NamedTuple):
    """A conveyance that moves the air: place (m) and upward speed (m/s) of its underside, where its rope ends."""

    place: tuple[float, float, float]
    speed: float


def air_law(air: Any, diameter: Any, spacing: Any) -> AirLaw:
    """Law for a rope of this diameter between suspensions so far apart, m; without air the factor is 0."""
    velocity = air.vx, air.vy, air.vz
    factor, cross = 0.5 * air.density * air.drag * diameter, (air.cross_y, air.cross_height)
    return AirLaw(factor, velocity, air.buffet, air.buffet_length, spacing, *cross)


def flow(law: AirLaw, conveyances: Sequence[Passing], point: Any, l: Any) -> list[Any]:
    """Velocity (m/s) of the air at ``point`` of an element of the length l."""
    x, y, z = law.velocity
    up, half, edge = point[1] - law.cross_y, 0.5 * law.cross_height, EDGE + l
    # where both steps are nearly 1, rounding may leave less than 0
    share = sqrt(abs(_smooth_step((up + half) / edge) - _smooth_step((up - half) / edge)))
    x, z = share * x, share * z
    for underside, speed in conveyances:
        h = point[1] - underside[1]
        aside = law.buffet * speed / law.spacing * (_bell((h - law.height) / law.spacing) - _bell(h / law.spacing))
        x, z = x + aside * (point[0] - underside[0]), z + aside * (point[2] - underside[2])
    return [x, y, z]


def _smooth_step(x: Any) -> Any:
    within = 1.0 - _ramp(1.0 - _ramp(x + 0.5))
    return within * within * (3.0 - 2.0 * within)


def _ramp(x: Any) -> Any:
    return 0.5 * (x + abs(x))


def _bell(h: Any) -> Any:
    square = 1.0 + h * h
    return 1.0 / (square * sqrt(square))


def drag(law: AirLaw, velocity: Any, slope: Any, speed: Any) -> tuple[list[Any], list[list[Any]]]:
    """Force per length in air of this ``velocity`` where r' and r_t are ``slope`` and ``speed``, and -df/dv (3, 3)."""
    against = [speed[i] - velocity[i] for i in range(3)]
    square = dot(slope, slope)
    along = dot(against, slope) / square
    across = [against[i] - along * slope[i] for i in range(3)]
    size = sqrt(dot(across, across) + ROUNDING**2)
    force = [-law.factor * size * x for x in across]
    tangent = [
        [
            law.factor * (size * (float(i == j) - slope[i] * slope[j] / square) + across[i] * across[j] / size)
            for j in range(3)
        ]
        for i in range(3)
    ]
    return force, tangent
