"""Equations of motion of a hoist, written once in CasADi from its energies.

Generalised coordinates q = (phi, y_L, y_R) and, where the hoist has the part: the motor's angle
against the sheave, the head ropes' modes eta_j of either side, and x, z, yaw of either conveyance.
With Lagrange's equation,

    d/dt dK/dq' - dK/dq + dV/dq + dD/dq' = Q ,

    K = 1/2 (m_s - m_m) (R phi')^2 + 1/2 m_m (R phi' + R delta')^2 + sum_i K_i ,
    V = 1/2 k delta^2 + sum_i V_i

with K_i and V_i of either side from ``legs.py``, and friction from ``friction.py``. The ropes hold
on the sheave, or slide on its lining: ``sliding.py``. A row of Lagrange's equation holds a leg up
to the sheave's top point, through which mu_r |w| kg/s flow: its load on the sheave is the tension
less mu_r w^2 / 2, on both sides alike.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from hoist_demo.drive.coordinates import (
    ACCELERATIONS,
    FORCES,
    INPUT_NAMES,
    LATERAL,
    Coordinates,
)
from hoist_demo.drive.friction import DryFriction, brake_friction, rim_friction
from hoist_demo.drive.legs import Leg, make_leg
from hoist_demo.drive.sliding import Sliding, sliding_friction
from hoist_demo.parameters import SIDES, Hoist
from hoist_demo.parameters.hoist import with_numbers

_ROPE_FORCES = ("y", "x", "z", "yaw")  #: Coordinates on which a balance rope's end acts.


@dataclass(frozen=True)
class HoistEquations:
    """CasADi functions of hoists with the same parts.

    Arguments are the state x, the input u, the free lengths l0 and the hoist's numbers p.
    """

    rates: Any  # (x, u, l0, p) -> dx/dt
    powers: Any  # (x, u, l0, p) -> W, in the order of WORK_NAMES and LOSS_NAMES
    outputs: Any  # (x, u, l0, p) -> OUTPUTS
    #: (x, u, l0, p) -> acceleration of each conveyance per force on either, (2, 2) [1/kg]
    accelerance: Any
    hold: Any  # (x, l0, p) -> motor torque that holds the state at rest
    #: (x, a, u, l0, p) -> mass matrix times accelerations less forces, tensions; of ropes that hold
    lagrange: Any


class _Energies(NamedTuple):
    """Energies of a hoist or of a part of it."""

    kinetic: Any
    potential: Any
    dissipation: Any  # Rayleigh's function


class _Motor(NamedTuple):
    """Motor, whose torque follows its command with a lag, both within the limits."""

    torque: Any
    torque_rate: Any


class _Symbols(NamedTuple):
    """Hoist with symbols for its numbers, and the arguments of its equations."""

    hoist: Hoist
    numbers: Any
    coords: Coordinates
    torque: Any  # N m, of the motor, before its limit of power
    free_lengths: Any  # m, of the head ropes
    u: Any  # input, in the order of INPUT_NAMES
    inputs: dict[str, Any]  # the same by name

    @property
    def rate(self) -> Any:
        """Speed of rotation of the sheave [rad/s]."""
        return self.coords("phi").rate

    @property
    def motor_rate(self) -> Any:
        """Speed of rotation of the motor [rad/s]."""
        return self.rate + self.coords("twist").rate

    @property
    def rim_speed(self) -> Any:
        """Speed of the sheave's rim [m/s]."""
        return self.hoist.sheave_radius * self.rate

    @property
    def rope_speed(self) -> Any:
        """Speed of the head ropes on the sheave [m/s]."""
        return self.hoist.sheave_radius * self.rate + self.coords("slip").rate


class _Parts(NamedTuple):
    """Parts of a hoist, by their energies and forces."""

    motor: _Motor
    legs: Sequence[Leg]
    rotation: _Energies  # of sheave, shaft and motor
    rim: Any  # N, friction at the sheave's rim
    brake: DryFriction

    @property
    def play_damping(self) -> Any:
        """Dissipation function of the conveyances between their guides."""
        return sum(leg.play_damping for leg in self.legs)


class _Lagrange(NamedTuple):
    """Lagrange's equation: mass matrix times accelerations = forces."""

    mass_matrix: Any
    forces: Any


class _StateChange(NamedTuple):
    """State of a hoist, and its rate."""

    x: Any
    rates: Any


@cache
def equations(structure: Hoist) -> HoistEquations:
    """Return the equations of motion of all hoists of this ``Hoist.equation_structure``."""
    symbols = _symbols(structure)
    parts = _parts(symbols)
    energies = _energies(parts)
    lagrange = _lagrange(symbols.coords, energies, _generalised_forces(symbols, parts))
    sliding = _sliding(symbols, lagrange, parts.legs)
    state = _state_change(symbols, parts, sliding)
    accelerance = ca.jacobian(state.rates, symbols.u)[list(ACCELERATIONS), list(FORCES)]
    # of any accelerations, for ropes that hold
    a = ca.SX.sym("a", len(symbols.coords.names))
    residual = ca.vertcat(
        lagrange.mass_matrix @ a - lagrange.forces, *_tensions(symbols, parts.legs, a)
    )
    hold = ca.gradient(energies.potential, symbols.coords.q)[0]
    arguments = [state.x, symbols.u, symbols.free_lengths, symbols.numbers]
    at_rest = [state.x, symbols.free_lengths, symbols.numbers]
    powers = _powers(symbols, parts, sliding.lining)
    outputs = _outputs(symbols, parts, energies, sliding.accelerations)
    return HoistEquations(
        rates=_function("rates", arguments, state.rates),
        powers=_function("powers", arguments, powers),
        outputs=_function("outputs", arguments, outputs),
        accelerance=_function("accelerance", arguments, accelerance),
        hold=_function("hold", at_rest, hold),
        lagrange=_function("lagrange", [state.x, a, *arguments[1:]], residual),
    )


def _symbols(structure: Hoist) -> _Symbols:
    """Return the symbols of all hoists with these parts."""
    numbers = ca.SX.sym("p", len(structure.numbers))
    u = ca.SX.sym("u", len(INPUT_NAMES))
    return _Symbols(
        hoist=with_numbers(structure, ca.vertsplit(numbers)),
        numbers=numbers,
        coords=Coordinates(structure),
        torque=ca.SX.sym("M"),
        free_lengths=ca.SX.sym("l0", 2),
        u=u,
        inputs=dict(zip(INPUT_NAMES, ca.vertsplit(u), strict=True)),
    )


def _parts(symbols: _Symbols) -> _Parts:
    """Return the parts of a hoist."""
    hoist = symbols.hoist
    coords = symbols.coords
    inputs = symbols.inputs
    lengths = ca.vertsplit(symbols.free_lengths)
    return _Parts(
        motor=_motor(hoist, symbols.torque, inputs["torque_command"], symbols.motor_rate),
        legs=[
            make_leg(hoist, coords, side, l0, inputs)
            for side, l0 in zip(SIDES, lengths, strict=True)
        ],
        rotation=_rotation(hoist, coords),
        rim=rim_friction(hoist, symbols.rim_speed),
        brake=brake_friction(hoist, inputs["brake"], symbols.rim_speed),
    )


def _energies(parts: _Parts) -> _Energies:
    """Return the energies of the whole hoist: of its legs, its sheave and its shaft."""
    rotation = parts.rotation
    legs = parts.legs
    rope_damping = sum(leg.rope_damping for leg in legs)
    return _Energies(
        kinetic=rotation.kinetic + sum(leg.kinetic for leg in legs),
        potential=rotation.potential + sum(leg.potential for leg in legs),
        dissipation=rotation.dissipation + rope_damping + parts.play_damping,
    )


def _generalised_forces(symbols: _Symbols, parts: _Parts) -> Any:
    """Return the generalised forces Q: those from outside, and dry friction."""
    at_rim = symbols.hoist.sheave_radius * parts.rim
    forces = {
        "phi": parts.motor.torque - at_rim - parts.brake.force,
        "twist": parts.motor.torque,
        **_conveyance_forces(parts.legs),
    }
    return ca.vertcat(*(forces.get(name, 0.0) for name in symbols.coords.names))


def _lagrange(coords: Coordinates, energies: _Energies, Q: Any) -> _Lagrange:
    """Return Lagrange's equation under the generalised forces Q."""
    q = coords.q
    v = coords.v
    K = energies.kinetic
    V = energies.potential
    D = energies.dissipation
    momentum = ca.gradient(K, v)
    transport = ca.jtimes(momentum, q, v)
    forces = Q - transport + ca.gradient(K, q) - ca.gradient(V, q) - ca.gradient(D, v)
    return _Lagrange(mass_matrix=ca.jacobian(momentum, v), forces=forces)


def _tensions(symbols: _Symbols, legs: Sequence[Leg], a: Any) -> list[Any]:
    """Return the tensions at the sheave [N], left then right, under accelerations."""
    return [
        _tension(symbols.hoist, symbols.coords, sign, leg, a, symbols.rope_speed)
        for sign, leg in zip((1.0, -1.0), legs, strict=True)
    ]


def _sliding(symbols: _Symbols, lagrange: _Lagrange, legs: Sequence[Leg]) -> Sliding:
    """Return the lining's friction, and the accelerations that solve Lagrange's equation."""
    names = symbols.coords.names
    along_slip: Any = ca.DM(np.array([name == "slip" for name in names], dtype=float))
    factors = ca.ldl(lagrange.mass_matrix)
    return sliding_friction(
        symbols.hoist,
        a_stick=ca.ldl_solve(lagrange.forces, *factors),
        a_per_force=ca.ldl_solve(along_slip, *factors),
        tensions=lambda a: _tensions(symbols, legs, a),
        w=symbols.rope_speed,
    )


def _state_change(symbols: _Symbols, parts: _Parts, sliding: Sliding) -> _StateChange:
    """Return the state, in the order of ``state_names``, and its rate."""
    q = symbols.coords.q
    v = symbols.coords.v
    a = sliding.accelerations
    frictions = (parts.brake, *(leg.jam for leg in parts.legs), sliding.lining)
    friction_states: list[Any] = []
    friction_rates: list[Any] = []
    for friction in frictions:
        friction_states += friction.states
        friction_rates += friction.rates
    return _StateChange(
        x=ca.vertcat(symbols.torque, q[:3], v[:3], q[3:], v[3:], *friction_states),
        rates=ca.vertcat(parts.motor.torque_rate, v[:3], a[:3], v[3:], a[3:], *friction_rates),
    )


def _powers(symbols: _Symbols, parts: _Parts, lining: DryFriction) -> Any:
    """Return the powers [W], in the order of WORK_NAMES and LOSS_NAMES."""
    coords = symbols.coords
    guide_losses = [
        leg.friction * coords(f"y_{side}").rate for side, leg in zip(SIDES, parts.legs, strict=True)
    ]
    losses = ca.vertcat(
        parts.rim * symbols.rim_speed,
        sum(guide_losses) + 2 * parts.play_damping,
        parts.brake.force * symbols.rate,
        2 * parts.rotation.dissipation,
        lining.force * sum(lining.states) * coords("slip").rate,
    )
    return ca.vertcat(
        parts.motor.torque * symbols.motor_rate,
        ca.sum1(losses),
        sum(leg.rope_power for leg in parts.legs),
        *_balance_rope_powers(coords, parts.legs),
        losses,
    )


def _outputs(symbols: _Symbols, parts: _Parts, energies: _Energies, a: Any) -> Any:
    """Return the outputs under accelerations, in the order of OUTPUTS."""
    coords = symbols.coords
    q = coords.q
    v = coords.v
    legs = parts.legs
    return ca.vertcat(
        q[1:3],
        v[1:3],
        a[1:3],
        coords("phi").value,
        symbols.rate,
        parts.motor.torque,
        *_tensions(symbols, legs, a),
        energies.kinetic,
        energies.potential,
        symbols.motor_rate,
        parts.brake.force,
        *(leg.static_tension for leg in legs),
        *_lateral_motion(coords, a),
        *(leg.pull for leg in legs),
        *(leg.slack for leg in legs),
        *(leg.jam.force for leg in legs),
    )


def _function(name: str, arguments: list[Any], value: Any) -> Any:
    return ca.Function(name, arguments, [ca.cse(value)])


def _motor(hoist: Hoist, torque: ca.SX, torque_command: ca.SX, rate: ca.SX) -> _Motor:
    """Return the motor, by the state of its torque [N m] and its speed [rad/s]."""
    command = ca.fmin(ca.fmax(torque_command, -hoist.torque_limit), hoist.torque_limit)
    lag = (command - torque) / hoist.torque_lag
    if hoist.power_limit is None:
        return _Motor(torque, lag)
    available = hoist.torque_available(rate)
    return _Motor(ca.fmin(ca.fmax(torque, -available), available), lag)


def _rotation(hoist: Hoist, coords: Coordinates) -> _Energies:
    """Return the energies of sheave, shaft and motor."""
    rate = coords("phi").rate
    twist, twist_rate = coords("twist")
    R = hoist.sheave_radius
    shaft = hoist.drive_shaft
    if shaft is None:
        return _Energies(hoist.sheave_mass * (R * rate) ** 2 / 2, 0.0, 0.0)
    motor = shaft.motor_mass * R**2
    sheave = (hoist.sheave_mass - shaft.motor_mass) * R**2
    damping = 2 * shaft.damping * (shaft.stiffness * motor * sheave / (motor + sheave)) ** 0.5
    return _Energies(
        kinetic=sheave * rate**2 / 2 + motor * (rate + twist_rate) ** 2 / 2,
        potential=shaft.stiffness * twist**2 / 2,
        dissipation=damping * twist_rate**2 / 2,
    )


def _conveyance_forces(legs: Sequence[Leg]) -> dict[str, Any]:
    """Return the forces of balance ropes and guides, by the coordinate on which they act."""
    forces: dict[str, Any] = {}
    for side, leg in zip(SIDES, legs, strict=True):
        y, x, z, yaw = ca.vertsplit(leg.side_force)
        forces[f"y_{side}"] = y - leg.friction
        forces[f"x_{side}"] = x
        forces[f"z_{side}"] = z
        forces[f"yaw_{side}"] = yaw
    return forces


def _balance_rope_powers(coords: Coordinates, legs: Sequence[Leg]) -> list[Any]:
    """Return the power of the balance ropes on either conveyance [W]."""
    powers = []
    for side, leg in zip(SIDES, legs, strict=True):
        rates = [coords(f"{name}_{side}").rate for name in _ROPE_FORCES]
        powers.append(ca.dot(leg.side_force, ca.vertcat(*rates)))
    return powers


def _tension(
    hoist: Hoist, coords: Coordinates, sign: float, leg: Leg, a: Any, rope_speed: Any
) -> Any:
    """Return the tension of a leg's head ropes at the sheave [N].

    Lagrange's row of the leg is the moment of the tension there; ``a`` are the accelerations.
    """
    phi, rate = coords("phi")
    row = ca.gradient(leg.kinetic, rate)
    change = (
        ca.jtimes(row, coords.q, coords.v)
        + ca.jtimes(row, coords.v, a)
        - ca.gradient(leg.kinetic, phi)
    )
    moment = change + ca.gradient(leg.potential, phi) + ca.gradient(leg.rope_damping, rate)
    return sign * moment / hoist.sheave_radius + hoist.rope_mass * rope_speed**2 / 2


def _lateral_motion(coords: Coordinates, a: ca.SX) -> list[Any]:
    """Place, rate and second derivative in x, z and yaw, left then right; zeros without play."""
    outputs: list[Any] = []
    for side, axis in product(SIDES, LATERAL):
        name = f"{axis}_{side}"
        if name in coords.names:
            k = coords.names.index(name)
            outputs += [coords.q[k], coords.v[k], a[k]]
        else:
            outputs += [0.0, 0.0, 0.0]
    return outputs
