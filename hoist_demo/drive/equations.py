"""Equations of motion of a hoist, written once in CasADi from its energies.

Generalised coordinates q = (phi, y_L, y_R) and, where the hoist has the part: the motor's angle against the sheave,
the head ropes' modes eta_j of either side, and x, z, yaw of either conveyance. With Lagrange's equation,

    d/dt dK/dq' - dK/dq + dV/dq + dD/dq' = Q ,

    K = 1/2 (m_s - m_m) (R phi')^2 + 1/2 m_m (R phi' + R delta')^2 + sum_i K_i ,   V = 1/2 k delta^2 + sum_i V_i

with K_i and V_i of either side from `legs.py`, and the brake's F_max z / z_max, of its torque times the pressure p. The
ropes hold on the sheave; where a hoist has a lining, `plant.py` tells when they slide over the wrap angle alpha,
towards the side of the larger tension T_1 (Euler and Eytelwein),

    T_1 - mu_r w^2 = exp(mu alpha) (T_2 - mu_r w^2) ,

where ropes of the mass mu_r per length and the speed w press on the sheave by that much less. The lining takes
F = T_1 - T_2 from them, and the tensions follow F through the accelerations: T_2 = T_20 + T_2' F. So

    F = (exp(mu alpha) - 1) max(T_20 - mu_r w^2, 0) / (1 - (exp(mu alpha) - 1) T_2') ,     T_2' < 0 ,

as F slows the ropes' sliding, which the slack side resists. The mass of the ropes on the sheave itself is neglected.
A row of Lagrange's equation holds a leg up to the sheave's top point, through which mu_r |w| kg/s flow: what it puts
on the sheave is the tension less mu_r w^2 / 2, on both sides alike.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from hoist_demo.drive.legs import Friction, Leg, make_leg
from hoist_demo.parameters import SIDES, Hoist
from hoist_demo.parameters.hoist import with_numbers

STATE_NAMES = (
    "torque",
    "phi",
    "y_left",
    "y_right",
    "phi_rate",
    "v_left",
    "v_right",
)  #: First entries of every state.

INPUT_NAMES = (
    *("torque_command", "force_left", "force_right", "brake"),
    *(f"{name}_{side}" for side in SIDES for name in ("fx", "fz", "my")),
)
WORK_NAMES = ("motor", "losses", "ropes", "left", "right")
LOSS_NAMES = ("rim", "guides", "brake", "shaft", "lining")  #: The parts of the losses.
FORCES = tuple(
    INPUT_NAMES.index(f"force_{side}") for side in SIDES
)  #: Places of the two vertical forces in an input.
#: Places of the two vertical accelerations in the rates.
ACCELERATIONS = tuple(STATE_NAMES.index(f"v_{side}") for side in SIDES)


def extra_coordinates(hoist: Hoist) -> tuple[str, ...]:
    """Names of the coordinates that the hoist has beyond phi, y_left and y_right."""
    names = ["twist"] if hoist.drive_shaft is not None else []
    names += [f"eta{j}_{side}" for side in SIDES for j in range(1, hoist.head_rope_modes + 1)]
    if hoist.play is not None:
        names += [f"{name}_{side}" for side in SIDES for name in ("x", "z", "yaw")]
    if hoist.lining is not None:
        names.append("slip")
    return tuple(names)


def state_names(hoist: Hoist) -> tuple[str, ...]:
    """Names of all states: STATE_NAMES, further coordinates, their rates, the brake's pressure, all deflections.

    Ropes that slide have the distance slip [m] that they have slid, positive as the sheave's rotation, and their sense.
    """
    extra = extra_coordinates(hoist)
    brake = ("brake_pressure", "brake_deflection") if hoist.brake is not None else ()
    jams = tuple(
        f"jam_deflection_{side}" for side in SIDES if getattr(hoist, f"jam_{side}") is not None
    )
    sense = ("sense",) if hoist.lining is not None else ()
    return STATE_NAMES + extra + tuple(f"{name}_rate" for name in extra) + brake + jams + sense


@dataclass(frozen=True)
class Equations:
    """CasADi functions of hoists with the same parts; x: state, u: input, l0: free lengths, p: the hoist's numbers."""

    rates: Any  # (x, u, l0, p) -> dx/dt
    powers: Any  # the same arguments -> W, in the order of WORK_NAMES and LOSS_NAMES
    outputs: Any  # the same arguments -> OUTPUTS
    accelerance: Any  # the same arguments -> acceleration of each conveyance per force on either, (2, 2) [1/kg]
    hold: Any  # (x, l0, p) -> motor torque that holds the state at rest
    lagrange: Any  # (x, a, u, l0, p) -> mass matrix times accelerations less forces, tensions; of ropes that hold


class Coordinates:
    """Symbols of q and q' by name."""

    def __init__(self, structure: Hoist) -> None:
        self.names = ("phi", "y_left", "y_right", *extra_coordinates(structure))
        self.q, self.v = ca.SX.sym("q", len(self.names)), ca.SX.sym("v", len(self.names))

    def __call__(self, name: str) -> tuple[Any, Any]:
        """Coordinate and its rate; zeros where the hoist lacks it."""
        if name not in self.names:
            return 0.0, 0.0
        k = self.names.index(name)
        return self.q[k], self.v[k]


@cache
def equations(structure: Hoist) -> Equations:
    """Return the equations of motion of all hoists of this `Hoist.equation_structure`."""
    coords, p = Coordinates(structure), ca.SX.sym("p", len(structure.numbers))
    hoist = with_numbers(structure, ca.vertsplit(p))
    q, v, R = coords.q, coords.v, hoist.sheave_radius
    torque, l0 = ca.SX.sym("M"), ca.SX.sym("l0", 2)
    u = ca.SX.sym("u", len(INPUT_NAMES))
    inputs = dict(zip(INPUT_NAMES, ca.vertsplit(u), strict=True))
    (phi, rate), (_, twist_rate), (_, slip_rate) = coords("phi"), coords("twist"), coords("slip")
    rim_speed, rope_speed = R * rate, R * rate + slip_rate
    along_slip = ca.DM(np.array([name == "slip" for name in coords.names], dtype=float))

    # motor: the torque follows its command with a lag, both within the limits
    available = hoist.torque_available(rate + twist_rate)
    motor = torque if hoist.power_limit is None else ca.fmin(ca.fmax(torque, -available), available)
    command = ca.fmin(ca.fmax(inputs["torque_command"], -hoist.torque_limit), hoist.torque_limit)

    # energies of the legs, of the sheave and of the shaft
    legs = [make_leg(hoist, coords, side, l0[i], inputs) for i, side in enumerate(SIDES)]
    K, V, shaft_damping = _rotation(hoist, coords)
    K, V = K + sum(leg.kinetic for leg in legs), V + sum(leg.potential for leg in legs)
    rope_damping, rope_power = (
        sum(leg.rope_damping for leg in legs),
        sum(leg.rope_power for leg in legs),
    )
    play_damping = sum(leg.play_damping for leg in legs)
    D = shaft_damping + rope_damping + play_damping

    # generalised forces: what acts from outside, and dry friction
    rim = (
        hoist.loss_coulomb * ca.tanh(rim_speed / hoist.loss_speed) + hoist.loss_viscous * rim_speed
    )
    brake = _brake_friction(hoist, inputs["brake"], rim_speed)
    outside = {"phi": motor - R * rim - brake.force, "twist": motor}
    for side, leg in zip(SIDES, legs, strict=True):
        y, x, z, yaw = ca.vertsplit(leg.side_force)
        outside |= {
            f"y_{side}": y - leg.friction,
            f"x_{side}": x,
            f"z_{side}": z,
            f"yaw_{side}": yaw,
        }
    Q = ca.vertcat(*(outside.get(name, 0.0) for name in coords.names))

    # Lagrange's equation: mass matrix times acceleration = everything else
    momentum = ca.gradient(K, v)
    mass_matrix = ca.jacobian(momentum, v)
    carried = ca.jtimes(momentum, q, v)
    forces = Q - carried + ca.gradient(K, q) - ca.gradient(V, q) - ca.gradient(D, v)
    factors = ca.ldl(mass_matrix)

    def accelerations(forces: Any) -> Any:
        return ca.ldl_solve(forces, *factors)

    def tensions(a: Any) -> list[Any]:
        return [
            _tension(hoist, coords, sign, leg, a, rope_speed)
            for sign, leg in zip((1.0, -1.0), legs, strict=True)
        ]

    lining, a = _sliding_friction(
        hoist, accelerations(forces), accelerations(along_slip), tensions, rope_speed
    )

    dry = (brake, *(leg.jam for leg in legs), lining)
    x = ca.vertcat(torque, q[:3], v[:3], q[3:], v[3:], *(z for one in dry for z in one.states))
    lag = (command - torque) / hoist.torque_lag
    rates = ca.vertcat(
        lag, v[:3], a[:3], v[3:], a[3:], *(rate for one in dry for rate in one.rates)
    )
    ends = [
        ca.dot(leg.side_force, ca.vertcat(*(coords(f"{n}_{s}")[1] for n in ("y", "x", "z", "yaw"))))
        for s, leg in zip(SIDES, legs, strict=True)
    ]
    guides = (
        sum(leg.friction * coords(f"y_{s}")[1] for s, leg in zip(SIDES, legs, strict=True))
        + 2 * play_damping
    )
    losses = ca.vertcat(
        rim * rim_speed,
        guides,
        brake.force * rate,
        2 * shaft_damping,
        lining.force * sum(lining.states) * slip_rate,
    )
    powers = ca.vertcat(motor * (rate + twist_rate), ca.sum1(losses), rope_power, *ends, losses)

    outputs = ca.vertcat(
        q[1:3],
        v[1:3],
        a[1:3],
        phi,
        rate,
        motor,
        *tensions(a),
        K,
        V,
        rate + twist_rate,
        brake.force,
        *(leg.static_tension for leg in legs),
        *_lateral_motion(coords, a),
        *(leg.pull for leg in legs),
        *(leg.slack for leg in legs),
        *(leg.jam.force for leg in legs),
    )
    accelerance = ca.jacobian(rates, u)[list(ACCELERATIONS), list(FORCES)]
    arguments, a_in = [x, u, l0, p], ca.SX.sym("a", len(coords.names))
    return Equations(
        rates=_function("rates", arguments, rates),
        powers=_function("powers", arguments, powers),
        outputs=_function("outputs", arguments, outputs),
        accelerance=_function("accelerance", arguments, accelerance),
        hold=_function("hold", [x, l0, p], ca.gradient(V, q)[0]),
        lagrange=_function(
            "lagrange",
            [x, a_in, *arguments[1:]],
            ca.vertcat(mass_matrix @ a_in - forces, *tensions(a_in)),
        ),
    )


def _function(name: str, arguments: list[Any], value: Any) -> Any:
    return ca.Function(name, arguments, [ca.cse(value)])


def _tension(
    hoist: Hoist, coords: Coordinates, sign: float, leg: Leg, a: Any, rope_speed: Any
) -> Any:
    """Return the tension of a leg's head ropes at the sheave [N]: Lagrange's row of the leg is its moment there."""
    phi, rate = coords("phi")
    row = ca.gradient(leg.kinetic, rate)
    change = (
        ca.jtimes(row, coords.q, coords.v)
        + ca.jtimes(row, coords.v, a)
        - ca.gradient(leg.kinetic, phi)
    )
    moment = change + ca.gradient(leg.potential, phi) + ca.gradient(leg.rope_damping, rate)
    return sign * moment / hoist.sheave_radius + hoist.rope_mass * rope_speed**2 / 2


def _lateral_motion(coords: Coordinates, a: Any) -> list[Any]:
    """Place, rate and second derivative in x, z and yaw, left then right; zeros where the hoist has no play."""
    outputs: list[Any] = []
    for name in (f"{n}_{s}" for s in SIDES for n in ("x", "z", "yaw")):
        k = coords.names.index(name) if name in coords.names else None
        outputs += [0.0, 0.0, 0.0] if k is None else [coords.q[k], coords.v[k], a[k]]
    return outputs


def _rotation(hoist: Hoist, coords: Coordinates) -> tuple[Any, Any, Any]:
    """Kinetic and potential energy and Rayleigh's function of sheave, shaft and motor."""
    (_, rate), (twist, twist_rate) = coords("phi"), coords("twist")
    R, shaft = hoist.sheave_radius, hoist.drive_shaft
    if shaft is None:
        return hoist.sheave_mass * (R * rate) ** 2 / 2, 0.0, 0.0
    motor, sheave = shaft.motor_mass * R**2, (hoist.sheave_mass - shaft.motor_mass) * R**2
    kinetic = sheave * rate**2 / 2 + motor * (rate + twist_rate) ** 2 / 2
    damping = 2 * shaft.damping * (shaft.stiffness * motor * sheave / (motor + sheave)) ** 0.5
    return kinetic, shaft.stiffness * twist**2 / 2, damping * twist_rate**2 / 2


def _brake_friction(hoist: Hoist, command: Any, rim_speed: Any) -> Friction:
    """Return the brake's friction, its torque in N m."""
    if (brake := hoist.brake) is None:
        return Friction()
    pressure, z = ca.SX.sym("brake_pressure"), ca.SX.sym("brake_deflection")
    rates = (
        (ca.fmin(ca.fmax(command, 0.0), 1.0) - pressure) / brake.lag,
        rim_speed - ca.fabs(rim_speed) * z / brake.travel,
    )
    return Friction(brake.torque * pressure * z / brake.travel, (pressure, z), rates)


def _sliding_friction(
    hoist: Hoist, a_stick: Any, per_force: Any, tensions: Callable[[Any], list[Any]], w: Any
) -> tuple[Friction, Any]:
    """Force of the lining on head ropes that slide [N], and the accelerations under it; 0 where they hold.

    Its state is the sense of their sliding, 1 as the sheave's positive rotation or -1, which does not change. `a_stick`
    are the accelerations without it, `per_force` those of 1 N along the slip, `tensions` follow them.
    """
    if hoist.lining is None:
        return Friction(), a_stick
    sense, a = ca.SX.sym("sense"), ca.SX.sym("a", a_stick.numel())
    left, right = (tension - hoist.rope_mass * w**2 for tension in tensions(a))
    low = ((1.0 + sense) * left + (1.0 - sense) * right) / 2.0
    against = -sense * per_force
    gain = ca.exp(hoist.lining.sliding * hoist.friction_coefficient * hoist.wrap_angle) - 1.0
    pressing = ca.fmax(ca.substitute(low, a, a_stick), 0.0)
    force = gain * pressing / (1.0 - gain * ca.dot(ca.gradient(low, a), against))
    return Friction(force, (sense,), (0.0,)), a_stick + force * against
