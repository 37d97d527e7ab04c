"""Friction that sticks and slips: of the brake, and of a conveyance that jams in its guides.

With the elastic deflection z of what sticks, after P. R. Dahl (Aerospace Corp. TOR-0158, 1968),

    F = F_max z / z_max ,   z' = v - |v| z / z_max .

It holds without creeping. The brake's F_max is its torque times the pressure p; a jam's is that of a narrow place,
F_j (1 - ((y - y_j) / d)^2)^2 within d of its middle and 0 beyond, and there z + tau z' stands for z in F: what is stuck
swings with damping (C. Canudas de Wit et al., IEEE Transactions on Automatic Control 40, 1995), what slides has none.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from hoist_demo.parameters import Hoist
from hoist_demo.parameters.components import Jam


class BrakeFriction:
    """Torque, states and rates of the brake; nothing where there is none."""

    def __init__(self, hoist: Hoist, asked: Any, rim_speed: Any) -> None:
        self.torque: Any = 0.0
        self.states: tuple[Any, ...] = ()
        self.rates: tuple[Any, ...] = ()
        if hoist.brake is not None:
            pressure, z = ca.SX.sym("brake_pressure"), ca.SX.sym("brake_deflection")
            travel = hoist.brake.travel
            self.torque = hoist.brake.torque * pressure * z / travel
            self.states = (pressure, z)
            self.rates = (
                (ca.fmin(ca.fmax(asked, 0.0), 1.0) - pressure) / hoist.brake.lag,
                rim_speed - ca.fabs(rim_speed) * z / travel,
            )


class JamFriction:
    """Force along the guides [N], state and rate of the narrow place of one side; nothing where there is none."""

    def __init__(self, jam: Jam | None, side: str, y: Any, vy: Any) -> None:
        self.force: Any = 0.0
        self.states: tuple[Any, ...] = ()
        self.rates: tuple[Any, ...] = ()
        if jam is not None:
            z = ca.SX.sym(f"jam_deflection_{side}")
            grip = ca.fmax(1.0 - ((y - jam.height) / jam.distance) ** 2, 0.0) ** 2
            rate = vy - ca.fabs(vy) * z / jam.travel
            self.force = jam.force * grip * (z + jam.damping * rate) / jam.travel
            self.states, self.rates = (z,), (rate,)
