"""Drag of the air on the rope, per length of its centre line.

With the unit tangent t and the rope's velocity w against the air, whose part across the rope is w_n = w - (w . t) t,

    f = -1/2 rho_a c_d d |w_n| w_n

the drag of a cylinder across a flow; the flow along it is left out, as are vortices and what a passing conveyance
pushes before it.  |w_n| is rounded off below ROUNDING, where nothing is left of it.

The tangent -df/dv is symmetric: it leaves out that t turns.

Works on numbers and CasADi expressions; vectors have their components first.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from .elementary import dot, sqrt

#: m/s
ROUNDING = 1e-6


class AirLaw(NamedTuple):
    """Numbers of the law: force per length and square of the speed, and the air's velocity (m/s)."""

    factor: float  # kg/m2
    velocity: tuple[float, float, float]


def air_law(air: Any, diameter: Any) -> AirLaw:
    """Of a rope of this diameter, m; without air the factor is 0."""
    return AirLaw(0.5 * air.density * air.drag * diameter, (air.vx, air.vy, air.vz))


def drag(law: AirLaw, slope: Any, speed: Any) -> tuple[list[Any], list[list[Any]]]:
    """Force per length where r' and r_t are ``slope`` and ``speed``, and -df/dv (3, 3)."""
    against = [speed[i] - law.velocity[i] for i in range(3)]
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
