"""One side of a hoist: energies and forces of its head ropes and its conveyance.

Coordinates are y, x, z, yaw and modes eta_j.

    K_i = 1/2 m v_y^2 + 1/2 mu l int_0^1 v(zeta)^2 dzeta + 1/2 (m + mu l/3) (v_x^2 + v_z^2)
          + 1/2 m r^2 yaw'^2
    V_i = 1/2 EA [(s - l)^2 + sum_j (j pi)^2 eta_j^2 / 2] / l
          - mu g l [H/2 - sum_j (1 - cos j pi)/(j pi) eta_j] + m g y + contact ,
    s = H + (x^2 + z^2 + b^2 yaw^2) / (2 H) ,     H = y_s - y

A point of the head ropes at the part zeta of their free length l, from the conveyance up, is at the
height y + H zeta + sum_j eta_j sin(j pi zeta): linear, with fixed-interface modes (R. R. Craig and
M. C. C. Bampton, AIAA Journal 6, 1968). The rope flows through that field, zeta' = zeta w / l, as
the sheave takes it in with the speed w = +-R phi', so that

    v(zeta) = (1 - zeta) v_y + zeta (H/l) w + sum_j [eta_j' sin(j pi zeta) + eta_j j pi cos(j pi
    zeta) zeta w / l] .

Material damping is proportional to strain rates, with the damping ratio zeta_h for a conveyance on
massless ropes.

Head ropes that are too long for their leg hang slack from the sheave, at their own weight's stretch
and without a pull on the conveyance: s, and H in the weight's term, are not below l + mu g l^2 / (2
EA). What the damping pulls or gives way is never more than the elastic pull on the conveyance, so
that the two together never push. The ropes' inertia, and their modes, stay those of a straight
rope.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from hoist_demo.drive.coordinates import CoordinateLookup
from hoist_demo.drive.friction import DryFriction, jam_friction
from hoist_demo.parameters import GRAVITY, Hoist


@dataclass(frozen=True)
class Leg:
    """Energies and forces of one side; forces are generalised, one per coordinate."""

    kinetic: Any
    potential: Any
    rope_damping: Any  # dissipation function of the head ropes
    rope_power: Any  # W, that it takes
    play_damping: Any  # dissipation function of the conveyance between its guides
    friction: Any  # N, of the guides along y, the jam's included
    jam: DryFriction
    pull: Any  # N, of the head ropes on the conveyance, without their inertia
    slack: Any  # m, of the head ropes
    side_force: Any  # generalised forces of the balance ropes on (y, x, z, yaw)
    static_tension: Any  # N at the sheave, were everything at rest here


def make_leg(
    hoist: Hoist, coords: CoordinateLookup, side: str, l0: Any, inputs: dict[str, Any]
) -> Leg:
    """Return the head ropes and the conveyance of one side, under the inputs by name."""
    if side == "left":
        mass = hoist.mass_left
        other = "right"
    else:
        mass = hoist.mass_right
        other = "left"
    g = GRAVITY
    mu = hoist.rope_mass
    y, vy = coords(f"y_{side}")
    ropes = _head_ropes(hoist, coords, side, l0)
    lateral = _lateral(hoist, coords, side, mass, mu * ropes.length)
    stretch = _stretch(hoist, ropes, lateral.pull)
    damper = _damper(hoist, ropes, stretch.force, vy, mass)
    jam = jam_friction(getattr(hoist, f"jam_{side}"), side, y, vy)
    potential = mass * g * y - stretch.weight + (lateral.potential + stretch.strain)
    pulls = [inputs[f"{name}_{side}"] for name in ("force", "fx", "fz", "my")]
    hanging = (hoist.tail_rope_length + y - coords(f"y_{other}").value) / 2
    return Leg(
        kinetic=mass * vy**2 / 2 + _rope_kinetic_energy(ropes, vy, mu) + lateral.kinetic,
        potential=sum(_mode_potentials(hoist, ropes), potential),
        rope_damping=damper.dissipation,
        rope_power=damper.power,
        play_damping=lateral.damping,
        friction=_friction_along_guides(hoist, jam, lateral.normal, vy),
        jam=jam,
        pull=ca.fmax(stretch.force + damper.force, 0.0),  # rounding could make it negative
        slack=stretch.slack,
        side_force=hoist.tail_rope_number * ca.vertcat(*pulls),
        static_tension=g * (mass + mu * ropes.length + hoist.tail_mass * hanging),
    )


class _Mode(NamedTuple):
    """A mode of the head ropes."""

    k: float  # j pi
    eta: Any
    eta_rate: Any


class _HeadRopes(NamedTuple):
    """Head ropes of one side between the sheave and the conveyance."""

    length: Any  # m, free, l
    height: Any  # m, of the sheave above the suspension, H
    w: Any  # m/s, at which the sheave takes them in
    modes: Sequence[_Mode]


def _head_ropes(hoist: Hoist, coords: CoordinateLookup, side: str, l0: Any) -> _HeadRopes:
    """Return the head ropes that have the free length l0 [m] at the angle 0."""
    sign = 1.0 if side == "left" else -1.0
    R = hoist.sheave_radius
    phi, rate = coords("phi")
    slip, slip_rate = coords("slip")
    numbers = range(1, hoist.head_rope_modes + 1)
    return _HeadRopes(
        length=l0 - sign * (R * phi + slip),
        height=hoist.sheave_height - coords(f"y_{side}").value,
        w=sign * (R * rate + slip_rate),
        modes=[_Mode(j * np.pi, *coords(f"eta{j}_{side}")) for j in numbers],
    )


class _Stretch(NamedTuple):
    """Elastic force and energies of the head ropes, without those of their modes."""

    force: Any  # N
    slack: Any  # m
    strain: Any  # J
    weight: Any  # J, below their energy at the sheave


def _stretch(hoist: Hoist, ropes: _HeadRopes, pull: Any) -> _Stretch:
    """Return the head ropes' stretch; slack ones hang as far down as their weight stretches them."""
    EA = hoist.rope_stiffness
    mu = hoist.rope_mass
    g = GRAVITY
    length = ropes.length
    height = ropes.height
    stretched = height + pull / (2 * height)
    hanging_free = length + mu * g * length**2 / (2 * EA)
    slack = ca.fmax(hanging_free - stretched, 0.0)
    return _Stretch(
        force=EA * ca.fmax(stretched - hanging_free, 0.0) / length,
        slack=slack,
        strain=EA * (stretched + slack - length) ** 2 / (2 * length),
        weight=mu * g * length * (height + slack) / 2,
    )


def _mode_potentials(hoist: Hoist, ropes: _HeadRopes) -> list[Any]:
    """Return strain energy and energy of weight of each mode [J]."""
    length = ropes.length
    potentials = []
    for k, eta, _ in ropes.modes:
        weight = hoist.rope_mass * GRAVITY * length * (1 - np.cos(k)) / k * eta
        potentials.append(hoist.rope_stiffness * (k * eta) ** 2 / (4 * length) + weight)
    return potentials


class _Damper(NamedTuple):
    """Material damping of the head ropes."""

    force: Any  # N
    dissipation: Any  # W, dissipation function
    power: Any  # W, that it takes


def _damper(hoist: Hoist, ropes: _HeadRopes, elastic: Any, vy: Any, mass: float) -> _Damper:
    """Return the damping, whose rate is cut where its force reaches the elastic one."""
    c = 2.0 * hoist.head_rope_damping * ca.sqrt(mass * hoist.rope_stiffness / ropes.length)
    stretching = ropes.w - vy
    largest_rate = elastic / ca.fmax(c, 1.0)  # fmax for a damping of 0
    damped = ca.fmin(ca.fmax(stretching, -largest_rate), largest_rate)
    dissipation = c * (damped * stretching - damped**2 / 2)
    power = c * (damped * stretching)
    for k, _, eta_rate in ropes.modes:
        dissipation += c * (k * eta_rate) ** 2 / 4
        power += c * (k * eta_rate) ** 2 / 2
    return _Damper(c * damped, dissipation, power)


def _friction_along_guides(hoist: Hoist, jam: DryFriction, normal: Any, vy: Any) -> Any:
    """Return the friction along y [N] of the guides, pressed by ``normal`` (N), and of a jam."""
    friction = jam.force
    if hoist.guides is not None:
        coulomb = hoist.guides.coulomb * ca.tanh(vy / hoist.loss_speed)
        friction += coulomb + hoist.guides.viscous * vy
    if hoist.play is not None:
        friction += hoist.play.friction * normal * ca.tanh(vy / hoist.loss_speed)
    return friction


def _rope_kinetic_energy(ropes: _HeadRopes, vy: Any, mu: Any) -> Any:
    """Return the kinetic energy of the head ropes, which the sheave takes in with the speed w.

    The square of their velocity is integrated over zeta for each pair of its shapes.
    """
    flow = ropes.w / ropes.length
    speeds = [
        vy,
        ropes.height * flow,
        *(mode.eta_rate for mode in ropes.modes),
        *(mode.eta * flow for mode in ropes.modes),
    ]
    v = ca.vertcat(*speeds)
    return mu * ropes.length / 2 * ca.bilin(ca.DM(_shape_products(len(ropes.modes))), v, v)


def _shape_products(modes: int) -> NDArray[np.float64]:
    """Return int_0^1 f_i f_j dzeta of the shapes of the velocity, with k_j = j pi.

    They are 1 - zeta, zeta, sin k_j zeta ..., k_j zeta cos k_j zeta ...
    """
    points, weights = np.polynomial.legendre.leggauss(4 * modes + 12)  # exact to rounding
    zeta = (points + 1) / 2
    k = np.pi * np.arange(1, modes + 1)[:, None]
    shapes = np.vstack([1 - zeta, zeta, np.sin(k * zeta), k * zeta * np.cos(k * zeta)])
    return np.asarray((shapes * weights / 2) @ shapes.T)


class _Lateral(NamedTuple):
    """Motion of a conveyance between its guides."""

    kinetic: Any = 0.0
    potential: Any = 0.0
    damping: Any = 0.0
    pull: Any = 0.0  # m^2, x^2 + z^2 + b^2 yaw^2
    normal: Any = 0.0  # N, sum of the contact forces' sizes


def _lateral(
    hoist: Hoist, coords: CoordinateLookup, side: str, mass: float, rope_mass: Any
) -> _Lateral:
    """Return the energies in x, z and yaw.

    A shoe at the arm a has the play c / a and the stiffness k a^2 in yaw.
    """
    play = hoist.play
    if play is None:
        return _Lateral()
    k = play.stiffness
    freedoms = (
        _Freedom("x", inertia=mass + rope_mass / 3),
        _Freedom("z", inertia=mass + rope_mass / 3),
        _Freedom("yaw", mass * play.gyration**2, lever=play.arm, spread=play.rope_spread),
    )
    total = _Lateral()
    for name, inertia, lever, spread in freedoms:
        displacement, speed = coords(f"{name}_{side}")
        force = k * ca.fmax(lever * ca.fabs(displacement) - play.clearance, 0.0)
        rate = (play.damping + play.contact_damping * force) * (lever * speed) ** 2
        total = _Lateral(
            kinetic=total.kinetic + inertia * speed**2 / 2,
            potential=total.potential + force**2 / (2 * k),
            damping=total.damping + rate / 2,
            pull=total.pull + (spread * displacement) ** 2,
            normal=total.normal + force,
        )
    return total


class _Freedom(NamedTuple):
    """Direction in which a conveyance moves between its guides."""

    name: str
    inertia: Any  # kg, or kg m^2
    lever: float = 1.0  # m of a shoe per m, or per rad
    spread: float = 1.0  # m of a head rope per m, or per rad
