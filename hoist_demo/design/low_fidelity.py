"""The hoist with its controller on the lowest fidelity that serves the drive: a balance rope without elasticity.

The drive's own equations, without shaft, brake, lining, guides, play, jams and modes of the head ropes, under balance
ropes that are only mass: their legs, of length (L + y_L - y_R) / 2 and (L - y_L + y_R) / 2, move and weigh with the
conveyances,

    K = rho / 2 (leg_L v_L^2 + leg_R v_R^2) ,   V = rho g [ leg_L (y_L - leg_L / 2) + leg_R (y_R - leg_R / 2) ] ,

so that their forces are F = -(M a + c) with the M and c of Lagrange's equation. The drive's
accelerations are linear in the forces, a = a_0 + B F. The controller is that of
``hoist_demo.control``, continuous in time, and the motor torque lags. Bending, waves and all
lateral motion of the rope are left out; a trip that was designed here is verified on the complete
rope.

State x = (s, v, a of the reference; p, y_L, y_R; p', v_L, v_R; torque / R; integral part), measured from the start at
rest, with p = R phi at the sheave's rim; the heights' deviations are those from the start. The input is the
reference's jerk.
"""

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from hoist_demo.control.controller import Gains, SpeedController
from hoist_demo.drive.coordinates import FORCES, INPUT_NAMES, STATE_NAMES, TORQUE
from hoist_demo.drive.equations import equations
from hoist_demo.drive.plant import HoistPlant, PlantState
from hoist_demo.parameters import GRAVITY, Hoist
from rope_model.arrays import Array

#: Names of the states, in their order.
STATES = (
    "s",
    "v",
    "a",
    "p",
    "y_left",
    "y_right",
    "p_rate",
    "v_left",
    "v_right",
    "motor",
    "integral",
)
V_LEFT = STATES.index("v_left")
V_RIGHT = STATES.index("v_right")
_MOTOR = STATES.index("motor")
#: Places in the drive's states of the conveyances' heights, and of their speeds.
_HEIGHTS = slice(STATE_NAMES.index("y_left"), STATE_NAMES.index("y_right") + 1)
_SPEEDS = slice(STATE_NAMES.index("v_left"), STATE_NAMES.index("v_right") + 1)
#: Places in the drive's rates of the accelerations of sheave and conveyances.
_ACCELERATIONS = slice(STATE_NAMES.index("phi_rate"), STATE_NAMES.index("v_right") + 1)


@dataclass(frozen=True)
class LowFidelityModel:
    """x' = f(x, jerk), the force that is fed forward, and the start at rest."""

    rates: Any  # ca.Function (x, jerk) -> x'
    # ca.Function (s, v, a of the reference) -> force at the rim of a full feed-forward [N]
    feed_forward: Any
    start: Array  # by STATES


def low_fidelity(hoist: Hoist, gains: Gains, y_left: float, y_right: float) -> LowFidelityModel:
    """Return the closed loop for a trip that begins at rest with the conveyances at these heights [m]."""
    hoist = replace(
        hoist, head_rope_modes=0, drive_shaft=None, brake=None, lining=None, power_limit=None
    )
    hoist = replace(hoist, guides=None, play=None, jam_left=None, jam_right=None)
    plant = HoistPlant(hoist)
    R = hoist.sheave_radius
    weights = [-GRAVITY * hoist.tail_rope_mass * leg for leg in _legs(hoist, y_left, y_right)]
    rest = plant.hanging_state(y_left, y_right, *weights)
    held = float(rest.x[TORQUE]) / R

    # the controller; forces at the rim
    reference = ca.SX.sym("r", 3)
    q = ca.SX.sym("q", 3)
    v = ca.SX.sym("v", 3)
    motor = ca.SX.sym("m")
    integral = ca.SX.sym("I")
    jerk = ca.SX.sym("j")
    controller = SpeedController(hoist, held, gains)
    motion = ca.vertsplit(reference)
    force, error = controller.force(motion, q[1], v[0], integral)

    drive = ca.vertcat(R * motor, q[0] / R, y_left + q[1], y_right + q[2], v[0] / R, v[1:])
    acceleration = _accelerations(plant, rest)(drive)
    rates = ca.vertcat(
        reference[1],
        reference[2],
        jerk,
        v,
        R * acceleration[0],
        acceleration[1:],
        (held + force - motor) / hoist.torque_lag,
        gains.speed * error / gains.integral_time,
    )
    start = np.zeros(len(STATES))
    start[_MOTOR] = held
    x = ca.vertcat(reference, q, v, motor, integral)
    fed = ca.Function(
        "feed_forward",
        motion,
        [held + controller.feed_forward(motion)],
        ["r0", "r1", "r2"],
        ["force"],
    )
    rates = ca.cse(rates)  # the mass matrix is in the accelerations and in B
    return LowFidelityModel(ca.Function("low_fidelity", [x, jerk], [rates]), fed, start)


def _accelerations(plant: HoistPlant, rest: PlantState) -> Any:
    """(state of the drive) -> (phi'', a_L, a_R) under balance ropes that are only mass."""
    x = ca.SX.sym("x", len(STATE_NAMES))
    F = ca.SX.sym("F", 2)
    u = ca.SX.zeros(len(INPUT_NAMES))
    u[list(FORCES)] = F
    moved = equations(plant.hoist.equation_structure).rates(
        x, u, rest.free_lengths, plant.hoist.numbers
    )[_ACCELERATIONS]
    B = ca.jacobian(moved, F)
    M, c = _mass_and_load(plant.hoist)(x[_HEIGHTS], x[_SPEEDS])
    a_0 = ca.substitute(moved, F, -c)
    ends = ca.solve(ca.SX.eye(2) + B[1:, :] @ M, a_0[1:])
    return ca.Function("accelerations", [x], [a_0 - B @ M @ ends])


def _mass_and_load(hoist: Hoist) -> Any:
    """(heights, speeds) -> M, c of the legs of one balance rope."""
    y = ca.SX.sym("y", 2)
    v = ca.SX.sym("v", 2)
    legs = ca.vertcat(*_legs(hoist, y[0], y[1]))
    rho = hoist.tail_rope_mass
    kinetic = rho / 2 * ca.dot(legs, v**2)
    potential = rho * GRAVITY * ca.dot(legs, y - legs / 2)
    momentum = ca.gradient(kinetic, v)
    c = ca.jtimes(momentum, y, v) - ca.gradient(kinetic, y) + ca.gradient(potential, y)
    return ca.Function("legs", [y, v], [ca.jacobian(momentum, v), c])


def _legs(hoist: Hoist, y_left: Any, y_right: Any) -> tuple[Any, Any]:
    """Return the lengths of a balance rope's legs [m]."""
    return (hoist.tail_rope_length + y_left - y_right) / 2, (
        hoist.tail_rope_length - y_left + y_right
    ) / 2
