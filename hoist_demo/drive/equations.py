"""Equations of motion of a hoist, written once in CasADi from its energies.

Generalised coordinates q = (phi, y_L, y_R) and, where the hoist has the part: the motor's angle against the sheave,
the head ropes' modes eta_j of either side, and x, z, yaw of either conveyance. With Lagrange's equation,

    d/dt dK/dq' - dK/dq + dV/dq + dD/dq' = Q ,

    K = 1/2 (m_s - m_m) (R phi')^2 + 1/2 m_m (R phi' + R delta')^2 + sum_i K_i ,   V = 1/2 k delta^2 + sum_i V_i
    K_i = 1/2 m v_y^2 + 1/2 mu l int_0^1 v(zeta)^2 dzeta + 1/2 (m + mu l/3) (v_x^2 + v_z^2) + 1/2 m r^2 yaw'^2
    V_i = 1/2 EA [(s - l)^2 + sum_j (j pi)^2 eta_j^2 / 2] / l - mu g l [H/2 - sum_j (1 - cos j pi)/(j pi) eta_j] + m g y
          + contact ,     s = H + (x^2 + z^2 + b^2 yaw^2) / (2 H) ,     H = y_s - y

A point of the head ropes at the part zeta of their free length l, from the conveyance up, is at the height
y + H zeta + sum_j eta_j sin(j pi zeta): linear, with fixed-interface modes (R. R. Craig and M. C. C. Bampton, AIAA
Journal 6, 1968). The rope flows through that field, zeta' = zeta w / l, as the sheave takes it in with the speed w =
+-R phi', so that

    v(zeta) = (1 - zeta) v_y + zeta (H/l) w + sum_j [eta_j' sin(j pi zeta) + eta_j j pi cos(j pi zeta) zeta w / l] .

Material damping is proportional to strain rates, with the damping ratio zeta_h for a conveyance on massless ropes. The
ropes hold on the sheave; those of a hoist with a lining are sliding on it, as `sliding.py` has it.

Head ropes that are too long for their leg hang slack from the sheave, at their own weight's stretch and without a pull
on the conveyance: s, and H in the weight's term, are not below l + mu g l^2 / (2 EA). What the damping pulls or gives
way is never more than the elastic pull on the conveyance, so that the two together never push. The ropes' inertia, and
their modes, stay those of a straight rope.
A row of Lagrange's equation holds a leg up to the sheave's top point, through which mu |w| kg/s flow: what it puts on
the sheave is the tension less mu w^2 / 2, on both sides alike.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from itertools import repeat
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from hoist_demo.drive.friction import BrakeFriction, JamFriction, SlidingFriction
from hoist_demo.parameters import GRAVITY, Hoist
from hoist_demo.parameters.components import Jam, Play

STATE_NAMES = ("torque", "phi", "y_left", "y_right", "phi_rate", "v_left", "v_right")  #: First entries of every state.

SIDES = ("left", "right")
INPUT_NAMES = (
    *("torque_command", "force_left", "force_right", "brake"),
    *(f"{name}_{side}" for side in SIDES for name in ("fx", "fz", "my")),
)
WORK_NAMES = ("motor", "losses", "ropes", "left", "right")
LOSS_NAMES = ("rim", "guides", "brake", "shaft", "lining")  #: The parts of the losses.


FORCES = tuple(INPUT_NAMES.index(f"force_{side}") for side in SIDES)  #: Places of the two vertical forces in an input.
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

    Ropes that slide have the way slip [m] that they have slid, positive as the sheave's rotation, and their sense.
    """
    extra = extra_coordinates(hoist)
    brake = ("brake_pressure", "brake_deflection") if hoist.brake is not None else ()
    jams = tuple(f"jam_deflection_{side}" for side in SIDES if _jam_of(hoist, side) is not None)
    sense = ("sense",) if hoist.lining is not None else ()
    return STATE_NAMES + extra + tuple(f"{name}_rate" for name in extra) + brake + jams + sense


def _jam_of(hoist: Hoist, side: str) -> Jam | None:
    return hoist.jam_left if side == "left" else hoist.jam_right


@dataclass(frozen=True)
class _Leg:
    """One side's share of the equations; forces are generalised, one per coordinate."""

    kinetic: Any
    potential: Any
    rope_damping: Any  # dissipation function of the head ropes
    rope_power: Any  # W, that it takes
    play_damping: Any  # of the conveyance's motion between its guides
    friction: Any  # N, of the guides along y, the jam's included
    jam: JamFriction
    pull: Any  # N, of the head ropes on the conveyance, without their inertia
    slack: Any  # m, of the head ropes
    side_force: Any  # generalised forces of the balance ropes on (y, x, z, yaw)
    static_tension: Any  # N at the sheave, were everything at rest here


@dataclass(frozen=True)
class Equations:
    """CasADi functions of hoists with the same parts.

    x is the state, u the input in the order of INPUT_NAMES, l0 the free lengths, p the hoist's numbers (`numbers_of`).
    """

    rates: Any  # (x, u, l0, p) -> dx/dt
    powers: Any  # the same arguments -> W, in the order of WORK_NAMES and LOSS_NAMES
    outputs: Any  # the same arguments -> OUTPUTS
    mobility: Any  # the same arguments -> change of the conveyances' accelerations per force on either, (2, 2) [1/kg]
    hold: Any  # (x, l0, p) -> motor torque that holds the state at rest
    lagrange: Any  # (x, a, u, l0, p) -> mass matrix times accelerations less forces, tensions; of ropes that hold


class _Coordinates:
    """Symbols of q and q' by name."""

    def __init__(self, hoist: Hoist) -> None:
        self.names = ("phi", "y_left", "y_right", *extra_coordinates(hoist))
        self.q, self.v = ca.SX.sym("q", len(self.names)), ca.SX.sym("v", len(self.names))

    def __call__(self, name: str) -> tuple[Any, Any]:
        """Coordinate and its rate; zeros where the hoist has not got it."""
        if name not in self.names:
            return 0.0, 0.0
        k = self.names.index(name)
        return self.q[k], self.v[k]


def parts_of(hoist: Hoist) -> Hoist:
    """The hoist with all its numbers 0 but the count of modes: what it shares with those of the same equations."""
    alike: Hoist = _with_numbers(hoist, repeat(0.0))
    return alike


def numbers_of(hoist: Any) -> list[float]:
    """The numbers that `parts_of` leaves out, those of the parts in their places."""
    found: list[float] = []
    for _, value in _items(hoist):
        found += numbers_of(value) if is_dataclass(value) else [float(value)]
    return found


def _with_numbers(data: Any, numbers: Iterator[Any]) -> Any:
    """A hoist or a part of it with other numbers, or symbols, in their places; none of them is checked."""
    made = object.__new__(type(data))
    changed = {name: _with_numbers(v, numbers) if is_dataclass(v) else next(numbers) for name, v in _items(data)}
    made.__dict__.update({**vars(data), **changed})
    return made


def _items(data: Any) -> list[tuple[str, Any]]:
    """Numbers and parts of a hoist or of a part of it, by name; counts of equations and what is None are none."""
    pairs = ((field.name, getattr(data, field.name)) for field in fields(data))
    return [(name, value) for name, value in pairs if value is not None and name != "head_rope_modes"]


@cache
def equations(parts: Hoist) -> Equations:
    """The equations of motion of all hoists with these parts, `parts_of` one of them."""
    p = ca.SX.sym("p", len(numbers_of(parts)))
    hoist: Hoist = _with_numbers(parts, iter(ca.vertsplit(p)))
    at = _Coordinates(hoist)
    q, v, R = at.q, at.v, hoist.sheave_radius
    torque, l0 = ca.SX.sym("M"), ca.SX.sym("l0", 2)
    u = ca.SX.sym("u", len(INPUT_NAMES))
    given = dict(zip(INPUT_NAMES, ca.vertsplit(u), strict=True))
    (phi, rate), (_, twist_rate), (_, slip_rate) = at("phi"), at("twist"), at("slip")
    rim_speed, rope_speed = R * rate, R * rate + slip_rate
    along_slip = ca.DM(np.array([name == "slip" for name in at.names], dtype=float))

    # motor: the torque follows its command with a lag, both within the limits
    available = hoist.torque_available(rate + twist_rate)
    motor = torque if hoist.power_limit is None else ca.fmin(ca.fmax(torque, -available), available)
    command = ca.fmin(ca.fmax(given["torque_command"], -hoist.torque_limit), hoist.torque_limit)

    # energies of the legs, of the sheave and of the shaft
    legs = [_leg(hoist, at, side, l0[i], given) for i, side in enumerate(SIDES)]
    K, V, shaft_damping = _rotation(hoist, at)
    K, V = K + sum(leg.kinetic for leg in legs), V + sum(leg.potential for leg in legs)
    rope_damping, rope_power = sum(leg.rope_damping for leg in legs), sum(leg.rope_power for leg in legs)
    play_damping = sum(leg.play_damping for leg in legs)
    D = shaft_damping + rope_damping + play_damping

    # what acts from outside and the dry friction, as generalised forces
    rim = hoist.loss_coulomb * ca.tanh(rim_speed / hoist.loss_speed) + hoist.loss_viscous * rim_speed
    brake = BrakeFriction(hoist, given["brake"], rim_speed)
    outside = {"phi": motor - R * rim - brake.torque, "twist": motor}
    for side, leg in zip(SIDES, legs, strict=True):
        y, x, z, yaw = ca.vertsplit(leg.side_force)
        outside |= {f"y_{side}": y - leg.friction, f"x_{side}": x, f"z_{side}": z, f"yaw_{side}": yaw}
    Q = ca.vertcat(*(outside.get(name, 0.0) for name in at.names))

    # Lagrange's equation: mass matrix times acceleration = everything else
    momentum = ca.gradient(K, v)
    mass_matrix = ca.jacobian(momentum, v)
    carried = ca.jtimes(momentum, q, v)
    forces = Q - carried + ca.gradient(K, q) - ca.gradient(V, q) - ca.gradient(D, v)
    factors = ca.ldl(mass_matrix)

    def accelerations(forces: Any) -> Any:
        return ca.ldl_solve(forces, *factors)

    def tensions(a: Any) -> list[Any]:
        return [_tension(hoist, at, sign, leg, a, rope_speed) for sign, leg in zip((1.0, -1.0), legs, strict=True)]

    lining = SlidingFriction(hoist, accelerations(forces), accelerations(along_slip), tensions, rope_speed)
    a = lining.accelerations

    deflections, sliding = brake.states, brake.rates
    for leg in legs:
        deflections, sliding = deflections + leg.jam.states, sliding + leg.jam.rates
    deflections, sliding = deflections + lining.states, sliding + lining.rates
    x = ca.vertcat(torque, q[:3], v[:3], q[3:], v[3:], *deflections)
    rates = ca.vertcat((command - torque) / hoist.torque_lag, v[:3], a[:3], v[3:], a[3:], *sliding)
    ends = [ca.dot(leg.side_force, ca.vertcat(*(at(f"{n}_{s}")[1] for n in ("y", "x", "z", "yaw"))))
            for s, leg in zip(SIDES, legs, strict=True)]  # fmt: skip
    guides = sum(leg.friction * at(f"y_{side}")[1] for side, leg in zip(SIDES, legs, strict=True)) + 2 * play_damping
    losses = ca.vertcat(rim * rim_speed, guides, brake.torque * rate, 2 * shaft_damping, lining.power(slip_rate))
    powers = ca.vertcat(motor * (rate + twist_rate), ca.sum1(losses), rope_power, *ends, losses)

    shown = ca.vertcat(
        *_upright(at, a), phi, rate, motor, *tensions(a), K, V,
        rate + twist_rate, brake.torque, *(leg.static_tension for leg in legs), *_lateral_motion(at, a),
        *(leg.pull for leg in legs), *(leg.slack for leg in legs), *(leg.jam.force for leg in legs),
    )  # fmt: skip
    mobility = ca.jacobian(rates, u)[list(ACCELERATIONS), list(FORCES)]
    arguments, given_a = [x, u, l0, p], ca.SX.sym("a", len(at.names))
    return Equations(
        rates=_function("rates", arguments, rates),
        powers=_function("powers", arguments, powers),
        outputs=_function("outputs", arguments, shown),
        mobility=_function("mobility", arguments, mobility),
        hold=_function("hold", [x, l0, p], ca.gradient(V, q)[0]),
        lagrange=_function(
            "lagrange", [x, given_a, *arguments[1:]], ca.vertcat(mass_matrix @ given_a - forces, *tensions(given_a))
        ),
    )


def _function(name: str, arguments: list[Any], value: Any) -> Any:
    return ca.Function(name, arguments, [ca.cse(value)])


def _tension(hoist: Hoist, at: _Coordinates, sign: float, leg: _Leg, a: Any, rope_speed: Any) -> Any:
    """Return the tension of a leg's head ropes at the sheave [N]: Lagrange's row of the leg is its moment there."""
    phi, rate = at("phi")
    row = ca.gradient(leg.kinetic, rate)
    change = ca.jtimes(row, at.q, at.v) + ca.jtimes(row, at.v, a) - ca.gradient(leg.kinetic, phi)
    moment = change + ca.gradient(leg.potential, phi) + ca.gradient(leg.rope_damping, rate)
    return sign * moment / hoist.sheave_radius + hoist.rope_mass * rope_speed**2 / 2


def _upright(at: _Coordinates, a: Any) -> list[Any]:
    """Heights of both sides, their rates, their second derivatives."""
    places = [at.names.index(f"y_{side}") for side in SIDES]
    return [ca.vertcat(*(values[k] for k in places)) for values in (at.q, at.v, a)]


def _lateral_motion(at: _Coordinates, a: Any) -> list[Any]:
    """Place, rate and second derivative in x, z and yaw, left then right; zeros where the hoist has no play."""
    shown: list[Any] = []
    for name in (f"{n}_{s}" for s in SIDES for n in ("x", "z", "yaw")):
        k = at.names.index(name) if name in at.names else None
        shown += [0.0, 0.0, 0.0] if k is None else [at.q[k], at.v[k], a[k]]
    return shown


def _rotation(hoist: Hoist, at: _Coordinates) -> tuple[Any, Any, Any]:
    """Kinetic and potential energy and Rayleigh's function of sheave, shaft and motor."""
    (_, rate), (twist, twist_rate) = at("phi"), at("twist")
    R, shaft = hoist.sheave_radius, hoist.drive_shaft
    if shaft is None:
        return hoist.sheave_mass * (R * rate) ** 2 / 2, 0.0, 0.0
    motor, sheave = shaft.motor_mass * R**2, (hoist.sheave_mass - shaft.motor_mass) * R**2
    kinetic = sheave * rate**2 / 2 + motor * (rate + twist_rate) ** 2 / 2
    damping = 2 * shaft.damping * (shaft.stiffness * motor * sheave / (motor + sheave)) ** 0.5
    return kinetic, shaft.stiffness * twist**2 / 2, damping * twist_rate**2 / 2


def _leg(hoist: Hoist, at: _Coordinates, side: str, l0: Any, given: dict[str, Any]) -> _Leg:
    """Energies and forces of the head ropes and the conveyance of one side."""
    sign, mass = (1.0, hoist.mass_left) if side == "left" else (-1.0, hoist.mass_right)
    other = "right" if side == "left" else "left"
    EA, mu, g, R, n = hoist.rope_stiffness, hoist.rope_mass, GRAVITY, hoist.sheave_radius, hoist.head_rope_modes
    (phi, rate), (slip, slip_rate), (y, vy) = at("phi"), at("slip"), at(f"y_{side}")
    modes = [(j * np.pi, *at(f"eta{j}_{side}")) for j in range(1, n + 1)]
    length, height, w = l0 - sign * (R * phi + slip), hoist.sheave_height - y, sign * (R * rate + slip_rate)

    # head ropes: the square of their velocity, integrated over zeta for each pair of its shapes
    flow = w / length
    speeds = [vy, height * flow, *(rate for _, _, rate in modes), *(eta * flow for _, eta, _ in modes)]
    kinetic, potential = mass * vy**2 / 2, mass * g * y
    speed_vector = ca.vertcat(*speeds)
    kinetic += mu * length / 2 * ca.bilin(ca.DM(_shape_products(n)), speed_vector, speed_vector)
    stretched, contact, play_damping, normal = height, 0.0, 0.0, 0.0
    if hoist.play is not None:
        lateral = _lateral(hoist.play, at, side, mass, mu * length)
        stretched += lateral.pull / (2 * height)
        kinetic, contact = kinetic + lateral.kinetic, lateral.potential
        play_damping, normal = lateral.damping, lateral.normal
    # slack ones hang as far down as their weight stretches them
    hanging_free = length + mu * g * length**2 / (2 * EA)
    slack, elastic = ca.fmax(hanging_free - stretched, 0.0), EA * ca.fmax(stretched - hanging_free, 0.0) / length
    potential -= mu * g * length * (height + slack) / 2
    potential += contact + EA * (stretched + slack - length) ** 2 / (2 * length)

    # with the rate cut where damping reaches the elastic pull; fmax for a damping of 0
    c = 2.0 * hoist.head_rope_damping * ca.sqrt(mass * EA / length)
    stretching, most = w - vy, elastic / ca.fmax(c, 1.0)
    damped = ca.fmin(ca.fmax(stretching, -most), most)
    damping, damping_power = c * (damped * stretching - damped**2 / 2), c * (damped * stretching)
    for k, eta, eta_rate in modes:
        potential += EA * (k * eta) ** 2 / (4 * length) + mu * g * length * (1 - np.cos(k)) / k * eta
        damping += c * (k * eta_rate) ** 2 / 4
        damping_power += c * (k * eta_rate) ** 2 / 2

    jam = JamFriction(_jam_of(hoist, side), side, y, vy)
    friction = jam.force
    if hoist.guides is not None:
        friction += hoist.guides.coulomb * ca.tanh(vy / hoist.loss_speed) + hoist.guides.viscous * vy
    if hoist.play is not None:
        friction += hoist.play.friction * normal * ca.tanh(vy / hoist.loss_speed)
    pulls = [given[f"force_{side}"], *(given[f"{name}_{side}"] for name in ("fx", "fz", "my"))]
    hanging = (hoist.tail_rope_length + y - at(f"y_{other}")[0]) / 2
    return _Leg(
        kinetic=kinetic,
        potential=potential,
        rope_damping=damping,
        rope_power=damping_power,
        play_damping=play_damping,
        friction=friction,
        jam=jam,
        pull=ca.fmax(elastic + c * damped, 0.0),  # of rounding
        slack=slack,
        side_force=hoist.tail_rope_number * ca.vertcat(*pulls),
        static_tension=g * (mass + mu * length + hoist.tail_mass * hanging),
    )


def _shape_products(modes: int) -> NDArray[np.float64]:
    """int_0^1 f_i f_j dzeta of 1 - zeta, zeta, sin k_j zeta ..., k_j zeta cos k_j zeta ..., with k_j = j pi."""
    points, weights = np.polynomial.legendre.leggauss(4 * modes + 12)  # exact to rounding
    zeta, k = (points + 1) / 2, np.pi * np.arange(1, modes + 1)[:, None]
    shapes = np.vstack([1 - zeta, zeta, np.sin(k * zeta), k * zeta * np.cos(k * zeta)])
    products: NDArray[np.float64] = (shapes * weights / 2) @ shapes.T
    return products


@dataclass(frozen=True)
class _Lateral:
    """Motion of a conveyance between its guides."""

    kinetic: Any
    potential: Any
    damping: Any
    pull: Any  # m^2, x^2 + z^2 + b^2 yaw^2
    normal: Any  # N, sum of the contact forces' sizes


def _lateral(play: Play, at: _Coordinates, side: str, mass: float, rope_mass: Any) -> _Lateral:
    """Energies in x, z and yaw; a shoe at the arm a has the play c / a and the stiffness k a^2 in yaw."""
    k, c, arm = play.stiffness, play.clearance, play.arm
    freedoms = (
        ("x", mass + rope_mass / 3, 1.0, 1.0),
        ("z", mass + rope_mass / 3, 1.0, 1.0),
        ("yaw", mass * play.gyration**2, arm, play.rope_spread),
    )
    kinetic, potential, damping, pull, normal = 0.0, 0.0, 0.0, 0.0, 0.0
    for name, inertia, lever, spread in freedoms:
        place, speed = at(f"{name}_{side}")
        force = k * ca.fmax(lever * ca.fabs(place) - c, 0.0)
        kinetic += inertia * speed**2 / 2
        potential += force**2 / (2 * k)
        damping += (play.damping + play.contact_damping * force) * (lever * speed) ** 2 / 2
        pull += (spread * place) ** 2
        normal += force
    return _Lateral(kinetic, potential, damping, pull, normal)
