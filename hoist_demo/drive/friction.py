"""Dry friction of a hoist: at the sheave's rim, in its brake, and of a conveyance that jams.

A brake and a jam stick and slip. With the elastic deflection z of what sticks, after P. R. Dahl
(Aerospace Corp. TOR-0158, 1968),

    F = F_max z / z_max ,   z' = v - |v| z / z_max .

It holds without creeping. The brake's F_max is its torque times the pressure p. A jam's is that of a
narrow place, F_j (1 - ((y - y_j) / d)^2)^2 within d of its middle and 0 beyond, and there z + tau z'
stands for z in F: what is stuck swings with damping (C. Canudas de Wit et al., IEEE Transactions on
Automatic Control 40, 1995), what slides has none.
"""

from typing import Any, NamedTuple

import casadi as ca

from hoist_demo.parameters import Hoist
from hoist_demo.parameters.components import Jam


class DryFriction(NamedTuple):
    """Dry friction with states of its own; nothing where the hoist has no such part."""

    force: Any = 0.0  # N, or a torque [N m]
    states: tuple[Any, ...] = ()
    rates: tuple[Any, ...] = ()


def rim_friction(hoist: Hoist, rim_speed: ca.SX) -> ca.SX:
    """Return the friction at the sheave's rim [N]."""
    coulomb = hoist.loss_coulomb * ca.tanh(rim_speed / hoist.loss_speed)
    return coulomb + hoist.loss_viscous * rim_speed


def brake_friction(hoist: Hoist, command: ca.SX, rim_speed: ca.SX) -> DryFriction:
    """Return the brake's friction, its torque in N m."""
    brake = hoist.brake
    if brake is None:
        return DryFriction()
    pressure = ca.SX.sym("brake_pressure")
    z = ca.SX.sym("brake_deflection")
    pressure_rate = (ca.fmin(ca.fmax(command, 0.0), 1.0) - pressure) / brake.lag
    z_rate = rim_speed - ca.fabs(rim_speed) * z / brake.travel
    torque = brake.torque * pressure * z / brake.travel
    return DryFriction(torque, states=(pressure, z), rates=(pressure_rate, z_rate))


def jam_friction(jam: Jam | None, side: str, y: Any, vy: Any) -> DryFriction:
    """Return the force along the guides [N] in the narrow place of one side."""
    if jam is None:
        return DryFriction()
    z = ca.SX.sym(f"jam_deflection_{side}")
    grip = ca.fmax(1.0 - ((y - jam.height) / jam.distance) ** 2, 0.0) ** 2
    rate = vy - ca.fabs(vy) * z / jam.travel
    force = jam.force * grip * (z + jam.damping * rate) / jam.travel
    return DryFriction(force, states=(z,), rates=(rate,))
