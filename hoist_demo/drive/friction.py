"""Friction of the brake, of a conveyance that jams in its guides, and of head ropes that slide on the sheave.

Brake and jam stick and slip. With the elastic deflection z of what sticks, after P. R. Dahl (Aerospace Corp.
TOR-0158, 1968),

    F = F_max z / z_max ,   z' = v - |v| z / z_max .

It holds without creeping. The brake's F_max is its torque times the pressure p; a jam's is that of a narrow place,
F_j (1 - ((y - y_j) / d)^2)^2 within d of its middle and 0 beyond, and there z + tau z' stands for z in F: what is stuck
swings with damping (C. Canudas de Wit et al., IEEE Transactions on Automatic Control 40, 1995), what slides has none.

Ropes that slide over the wrap angle alpha, towards the side of the larger tension T_1 (Euler and Eytelwein),

    T_1 - mu_r w^2 = exp(mu alpha) (T_2 - mu_r w^2) ,

where ropes of the mass mu_r per length and the speed w press on the sheave by that much less. The lining takes
F = T_1 - T_2 from them, and the tensions follow F through the accelerations: T_2 = T_20 + T_2' F. So

    F = (exp(mu alpha) - 1) max(T_20 - mu_r w^2, 0) / (1 - (exp(mu alpha) - 1) T_2') ,     T_2' < 0 ,

as F slows the ropes' sliding, which the slack side resists. The mass of the ropes on the sheave itself is neglected.
"""

from __future__ import annotations

from collections.abc import Callable
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


class SlidingFriction:
    """Force of the lining on head ropes that slide [N], and the accelerations under it; 0 where they hold.

    Its state is the sense of their sliding, 1 as the sheave's positive rotation or -1, which does not change.
    """

    def __init__(self, hoist: Hoist, held: Any, per_force: Any, tensions: Callable[[Any], list[Any]], w: Any) -> None:
        """`held` are the accelerations without it, `per_force` those of 1 N along the slip, `tensions` follow them."""
        self.force: Any = 0.0
        self.accelerations = held
        self.states: tuple[Any, ...] = ()
        self.rates: tuple[Any, ...] = ()
        if hoist.lining is not None:
            sense, a = ca.SX.sym("sense"), ca.SX.sym("a", held.numel())
            left, right = (tension - hoist.rope_mass * w**2 for tension in tensions(a))
            low = ((1.0 + sense) * left + (1.0 - sense) * right) / 2.0
            against = -sense * per_force
            gain = ca.exp(hoist.lining.sliding * hoist.friction_coefficient * hoist.wrap_angle) - 1.0
            pressing = ca.fmax(ca.substitute(low, a, held), 0.0)
            self.force = gain * pressing / (1.0 - gain * ca.dot(ca.gradient(low, a), against))
            self.accelerations = held + self.force * against
            self.states, self.rates = (sense,), (0.0,)

    def power(self, slip_rate: Any) -> Any:
        """Power that it takes [W]."""
        return self.force * sum(self.states) * slip_rate
