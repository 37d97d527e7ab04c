"""Drag of the air on the rope, per length of its centre line.

With the unit tangent t and the rope's velocity w relative to the air, of which w_n = w - (w . t) t
is across the rope,

    f = -1/2 rho_a c_d d |w_n| w_n

the drag of a cylinder in cross flow; flow along the rope and vortices are left out.  |w_n| is
rounded off below SMOOTHED_SPEED, where the force is negligible.

The vertical wind is uniform.  The horizontal wind blows everywhere, or where a gallery of height h
opens at the height y0, with the fraction c of its speed:

    c^2 = S((y - y0 + h/2)/e) - S((y - y0 - h/2)/e)

S is the smooth cubic step from 0 at -1/2 to 1 at 1/2, so that int c^2 dy = h whatever the width e
of the edges: a jet that spreads keeps its momentum, and a rope across it its drag.  e is EDGE plus
the element's length: a flow narrower than the spacing of the Gauss points would be lost between
them.

A passing conveyance moves the air aside.  In potential flow a slender body that moves at the speed
V along its axis has a source at its bow and a sink of the same strength at its tail (Rankine's
ovoid).  At the distance D from the axis and the height h above one of them, each moves the air
across at

    b V (1 + (h/D)^2)^(-3/2)

outwards at the bow, inwards at the tail; b is A/(4 pi D^2) for a body of the cross section A in the
open, more between walls.  D is the spacing of the suspensions: this is the flow at the leg beside
the conveyance, where it hangs at rest.  It is taken as proportional to the distance from the axis,
so that it vanishes at the leg below the conveyance.

The tangent -df/dv is symmetric: it leaves out the turning of t and the gradient of the flow.  Works
on numbers and CasADi expressions; vectors have their components first.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, get_args, get_type_hints

from rope_model.physics.elementary import Scalar, Vector, dot, sqrt, where
from rope_model.shaft_parameters import Air

#: m/s, speed below which |w_n| is rounded off
SMOOTHED_SPEED = 1e-6
#: m, width of the edge of a flow from a gallery [assumed]
EDGE = 0.5


class AirCoefficients(NamedTuple):
    """Coefficients of the law: factor of the squared speed, velocity of the air (m/s), b, and lengths (m)."""

    factor: float  # kg/m2
    velocity: tuple[float, float, float]
    buffet: float
    height: float  # height of a conveyance
    spacing: float
    cross_y: float  # height of the middle of the gallery
    cross_height: float  # height of the gallery's mouth

    def numbers(self) -> list[Scalar]:
        """Return the coefficients in order, a vector as its components: the beginning of A."""
        numbers: list[Scalar] = []
        for value in self:
            numbers += value if isinstance(value, tuple) else (value,)
        return numbers

    @staticmethod
    def from_numbers(numbers: Vector) -> AirCoefficients:
        """Return the coefficients whose ``numbers`` these are."""
        values: list[Any] = []
        first = 0
        for length in COEFFICIENT_LENGTHS:
            stop = first + max(length, 1)
            part = tuple(numbers[k] for k in range(first, stop))
            values.append(part if length else part[0])
            first = stop
        return AirCoefficients._make(values)


#: numbers of components of the coefficients, 0 of one that is no vector
COEFFICIENT_LENGTHS = tuple(len(get_args(of)) for of in get_type_hints(AirCoefficients).values())


class Passing(NamedTuple):
    """Position (m) and upward speed (m/s) of the underside of a conveyance, where its rope ends."""

    position: tuple[float, float, float]
    speed: float


def air_coefficients(air: Air, diameter: Scalar, spacing: Scalar) -> AirCoefficients:
    """Return those of a rope of this diameter between suspensions ``spacing`` (m) apart."""
    velocity = air.vx, air.vy, air.vz
    factor = drag_factor(air, diameter)
    cross = (air.cross_y, air.cross_height)
    return AirCoefficients(factor, velocity, air.buffet, air.buffet_length, spacing, *cross)


def air_acts(air: Air, diameter: Scalar) -> Scalar:
    """Return whether a law of this module acts: 1 or 0.  Each law has its condition.

    If none does, no element is computed in air, no model is needed for it, and the reference rope
    may have such parameters.
    """
    return where(drag_factor(air, diameter) > 0, 1.0, 0.0)


def drag_factor(air: Air, diameter: Scalar) -> Scalar:
    """Return the drag per length over the squared speed (kg/m2)."""
    return 0.5 * air.density * air.drag * diameter


def flow(
    air: AirCoefficients, conveyances: Sequence[Passing], point: Vector, l: Scalar
) -> list[Scalar]:
    """Return the velocity (m/s) of the air at ``point`` of an element of length l."""
    x, y, z = air.velocity
    up = point[1] - air.cross_y
    half = 0.5 * air.cross_height
    edge = EDGE + l
    # rounding may make the difference of two steps near 1 negative
    fraction = sqrt(abs(_smooth_step((up + half) / edge) - _smooth_step((up - half) / edge)))
    x = fraction * x
    z = fraction * z
    for underside, speed in conveyances:
        h = point[1] - underside[1]
        aside = (
            air.buffet
            * speed
            / air.spacing
            * (_bell((h - air.height) / air.spacing) - _bell(h / air.spacing))
        )
        x = x + aside * (point[0] - underside[0])
        z = z + aside * (point[2] - underside[2])
    return [x, y, z]


def _smooth_step(x: Scalar) -> Scalar:
    within = 1.0 - _ramp(1.0 - _ramp(x + 0.5))
    return within * within * (3.0 - 2.0 * within)


def _ramp(x: Scalar) -> Scalar:
    return 0.5 * (x + abs(x))


def _bell(h: Scalar) -> Scalar:
    square = 1.0 + h * h
    return 1.0 / (square * sqrt(square))


def drag(
    air: AirCoefficients, velocity: Vector, slope: Vector, speed: Vector
) -> tuple[list[Scalar], list[list[Scalar]]]:
    """Return the force per length in air of this ``velocity``, and -df/dv (3, 3); r' is ``slope``, r_t is ``speed``."""
    relative = [speed[i] - velocity[i] for i in range(3)]
    square = dot(slope, slope)
    along = dot(relative, slope) / square
    across = [relative[i] - along * slope[i] for i in range(3)]
    size = sqrt(dot(across, across) + SMOOTHED_SPEED**2)
    force = [-air.factor * size * x for x in across]
    normal = [[float(i == j) - slope[i] * slope[j] / square for j in range(3)] for i in range(3)]
    return force, [
        [air.factor * (size * normal[i][j] + across[i] * across[j] / size) for j in range(3)]
        for i in range(3)
    ]
