"""The hoist with its controller on the lowest rung that serves the drive: a balance rope without elasticity.

Three masses, sheave rim p = R phi and suspension heights y_L, y_R, on head ropes of changing length; the balance
rope's legs, of length (L + y_L - y_R) / 2 and (L - y_L + y_R) / 2, move and weigh with the conveyances. Energies as in
`hoist_demo.drive`, with the legs' added,

    K += rho / 2 (leg_L v_L^2 + leg_R v_R^2) ,   V += rho g [ leg_L (y_L - leg_L / 2) + leg_R (y_R - leg_R / 2) ] ,

and Lagrange's equation gives the motion. The controller is that of `hoist_demo.control`, continuous in time, and the
motor torque lags. Bending, waves and all lateral motion of the rope are left out; a trip that was designed here
is verified on the complete rope.

State x = (s, v, a of the reference; p, y_L, y_R; p', v_L, v_R; torque / R; integral part), measured from the start at
rest; the heights' deviations are those from the start. The input is the reference's jerk.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from hoist_demo.control.controller import Gains
from hoist_demo.parameters import GRAVITY, Hoist

Vector = NDArray[np.float64]

STATES = 11


@dataclass(frozen=True)
class LowRung:
    """x' = f(x, jerk), the force that is fed forward, and the start at rest."""

    rates: Any  # ca.Function (x, jerk) -> x'
    ahead: Any  # ca.Function (s, v, a of the reference) -> force at the rim that a full feed-forward asks for [N]
    start: Vector  # shape (STATES,)


def low_rung(hoist: Hoist, gains: Gains, y_left: float, y_right: float) -> LowRung:
    """The closed loop for a trip that begins at rest with the conveyances at the given heights [m]."""
    EA, mu, rho, g = hoist.rope_stiffness, hoist.rope_mass, hoist.tail_rope_number * hoist.tail_rope_mass, GRAVITY
    q, v = ca.SX.sym("q", 3), ca.SX.sym("v", 3)
    y, l0 = (y_left + q[1], y_right + q[2]), _free_lengths(hoist, y_left, y_right)
    legs = ((hoist.tail_rope_length + y[0] - y[1]) / 2, (hoist.tail_rope_length - y[0] + y[1]) / 2)

    kinetic, potential = hoist.sheave_mass * v[0] ** 2 / 2, ca.SX(0)
    damping = ca.SX(0)
    for i, (sign, mass) in enumerate(((1.0, hoist.mass_left), (-1.0, hoist.mass_right))):
        w, vy, leg = sign * v[0], v[1 + i], legs[i]
        length, s = l0[i] - sign * q[0], hoist.sheave_height - y[i]
        flow = s / length * w  # the head rope is stretched where it runs on the sheave
        kinetic += (mass + rho * leg) * vy**2 / 2 + mu * length * (flow**2 + flow * vy + vy**2) / 6
        potential += EA * (s - length) ** 2 / (2 * length) - mu * g * length * s / 2 + mass * g * y[i]
        potential += rho * g * leg * (y[i] - leg / 2)
        damping += hoist.head_rope_damping * ca.sqrt(mass * EA / length) * (w - vy) ** 2
    momentum = ca.gradient(kinetic, v)
    carried = ca.jtimes(momentum, q, v)
    conservative = ca.gradient(kinetic, q) - ca.gradient(potential, q) - ca.gradient(damping, v) - carried
    hold = ca.Function("hold", [q], [ca.gradient(potential, q)[0]])

    # the controller, and the motor behind it; forces at the rim
    reference, motor, integral = ca.SX.sym("r", 3), ca.SX.sym("m"), ca.SX.sym("I")
    error = reference[1] + gains.position * (reference[0] - q[1]) - v[0]
    ahead = hoist.moving_mass * reference[2] + 2.0 * g * (rho - mu) * reference[0] + _loss(hoist, reference[1])
    held = hold(ca.DM.zeros(3))
    command = held + gains.feed_forward * ahead + gains.speed * error + integral

    jerk = ca.SX.sym("j")
    force = ca.vertcat(motor - _loss(hoist, v[0]), 0, 0)
    acceleration = ca.solve(ca.jacobian(momentum, v), force + conservative)
    x = ca.vertcat(reference, q, v, motor, integral)
    rates = ca.vertcat(
        reference[1],
        reference[2],
        jerk,
        v,
        acceleration,
        (command - motor) / hoist.torque_lag,
        gains.speed * error / gains.integral_time,
    )
    start = np.zeros(STATES)
    start[9] = float(held)
    fed = ca.Function("ahead", ca.vertsplit(reference), [held + ahead], ["r0", "r1", "r2"], ["force"])
    return LowRung(ca.Function("low_rung", [x, jerk], [rates]), fed, start)


def _loss(hoist: Hoist, speed: Any) -> Any:
    return hoist.loss_coulomb * ca.tanh(speed / hoist.loss_speed) + hoist.loss_viscous * speed


def _free_lengths(hoist: Hoist, y_left: float, y_right: float) -> tuple[float, float]:
    """Free lengths of the head ropes at rest [m]: positive roots of s = l (1 + (W + mu g l / 2) / EA)."""
    legs = ((hoist.tail_rope_length + y_left - y_right) / 2, (hoist.tail_rope_length - y_left + y_right) / 2)
    lengths = []
    for y, mass, leg in zip((y_left, y_right), (hoist.mass_left, hoist.mass_right), legs, strict=True):
        s = hoist.sheave_height - y
        b = 1.0 + (mass + hoist.tail_rope_number * hoist.tail_rope_mass * leg) * GRAVITY / hoist.rope_stiffness
        c = hoist.rope_mass * GRAVITY / (2.0 * hoist.rope_stiffness)
        lengths.append(2.0 * s / (b + float(np.sqrt(b * b + 4.0 * c * s))))
    return lengths[0], lengths[1]
