"""The hoist's part of the linear models: the derivative of Lagrange's equation in the drive.

The equation is that of `drive/equations.py`. The coordinates are those of the drive, and behind
them what lags: motor torque and brake. The hoist is left without what has no derivative: Coulomb
friction, jams, slip on the lining, play between the guides. A sticking brake is a spring.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np

from hoist_demo.drive.coordinates import INPUT_NAMES, extra_coordinates, state_names
from hoist_demo.drive.equations import equations
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.drive.plant import HoistPlant
from hoist_demo.parameters import Hoist
from rope_model.arrays import Array

HeldBy = Literal["motor", "brake"]
_DRIVE_OUTPUTS = (
    "angle",
    "rate",
    "motor_rate",
    "torque",
    "y_left",
    "y_right",
    "v_left",
    "v_right",
    "pull_left",
    "pull_right",
)
_TENSIONS = ("tension_left", "tension_right")
#: Pressure of the brake that counts as within its limits, where it acts.
_WITHIN_LIMITS = 0.5
_DEFLECTION = "brake_deflection"


def smooth_hoist(hoist: Hoist, held_by: HeldBy) -> Hoist:
    """Return the hoist without what has no derivative at rest."""
    if hoist.guides is None:
        guides = None
    else:
        guides = replace(hoist.guides, coulomb=0.0)
    if held_by == "brake" and hoist.brake is None:
        raise ValueError("held_by = 'brake' needs a hoist with a brake: fit one, or take 'motor'")
    brake = hoist.brake if held_by == "brake" else None
    parts: dict[str, Any] = {"guides": guides, "brake": brake, "lining": None, "play": None}
    return replace(hoist, loss_coulomb=0.0, jam_left=None, jam_right=None, **parts)


@dataclass(frozen=True)
class LinearHoist:
    """Linear model of the hoist: `coordinates` first, then `lags`. Matrices are dense, (coordinates + lags) square."""

    coordinates: tuple[str, ...]
    lags: tuple[str, ...]
    matrices: tuple[Array, Array, Array]  # M, D, K
    inputs: tuple[str, ...]
    B: Array
    outputs: tuple[str, ...]
    maps: tuple[Array, Array, Array]
    through: Array
    rest_inputs: Array
    rest_outputs: Array

    @staticmethod
    def none() -> LinearHoist:
        """Return an empty model, for a rope alone."""
        empty = np.zeros((0, 0))
        return LinearHoist(
            (), (), (empty,) * 3, (), empty, (), (empty,) * 3, empty, np.zeros(0), np.zeros(0)
        )


@cache
def _derivatives(structure: Hoist) -> Any:
    """(x, a, u, l0, p) -> derivatives of Lagrange's rows and tensions, rates and outputs to x, a and u; values."""
    of = equations(structure)
    x = ca.SX.sym("x", len(state_names(structure)))
    a = ca.SX.sym("a", 3 + len(extra_coordinates(structure)))
    u = ca.SX.sym("u", len(INPUT_NAMES))
    l0 = ca.SX.sym("l0", 2)
    p = ca.SX.sym("p", len(structure.numbers))
    rows = ca.vertcat(of.lagrange(x, a, u, l0, p), of.rates(x, u, l0, p))
    outputs = of.outputs(x, u, l0, p)
    values = ca.vertcat(rows, *(outputs[OUTPUT_INDEX[name]] for name in _DRIVE_OUTPUTS))
    jacobians = [ca.densify(ca.jacobian(values, z)) for z in (x, a, u)]
    return ca.Function("derivatives", [x, a, u, l0, p], [ca.cse(y) for y in (*jacobians, values)])


class _WorkingPoint(NamedTuple):
    """State about which the hoist is linear, and the derivatives there."""

    x: Array
    values: Array  # rows: Lagrange's, tensions, rates, what is shown
    by_x: Array
    by_a: Array
    by_u: Array


class _Places(NamedTuple):
    """Places of the coordinates of the model among the states of the drive."""

    names: tuple[str, ...]  # of the coordinates
    q: list[int]
    v: list[int]  # their rates
    lag: list[int]


def _places(hoist: Hoist) -> _Places:
    states = list(state_names(hoist))
    coordinates = ("phi", "y_left", "y_right", *extra_coordinates(hoist))
    short = {"phi": "phi_rate", "y_left": "v_left", "y_right": "v_right"}
    q = [states.index(name) for name in coordinates]
    v = [states.index(short.get(name, f"{name}_rate")) for name in coordinates]
    lag = [k for k, name in enumerate(states) if k not in (*q, *v) and name != _DEFLECTION]
    return _Places(coordinates, q, v, lag)


def _held_by_brake(hoist: Hoist, x: Array) -> Array:
    """Return the state in which the brake holds instead of the motor; ValueError if it cannot."""
    brake = hoist.brake
    assert brake is not None
    torque = float(x[0])
    if abs(torque) > brake.torque:
        raise ValueError(
            f"the imbalance of {abs(torque):.6g} N m must be within brake.torque = {brake.torque:g} N m: "
            "take a stronger brake"
        )
    names = list(state_names(hoist))
    x = x.copy()
    x[0] = 0.0
    x[names.index("brake_pressure")] = 1.0
    x[names.index(_DEFLECTION)] = -torque / brake.torque * brake.travel
    if hoist.drive_shaft is not None:
        x[names.index("twist")] = 0.0
    return x


def _working_point(
    hoist: Hoist,
    heights: tuple[float, float],
    forces: tuple[float, float],
    held_by: HeldBy,
    speed: float,
) -> _WorkingPoint:
    """Return the hoist with its conveyances at these heights and this speed."""
    plant = HoistPlant(hoist, "portable")
    if held_by == "motor":
        state = plant.equilibrium(*heights, *forces)
        x = state.x.copy()
    else:
        state = plant.hanging_state(*heights, *forces)
        x = _held_by_brake(hoist, state.x)
    u = np.zeros(len(INPUT_NAMES))
    u[INPUT_NAMES.index("brake")] = _WITHIN_LIMITS
    u[INPUT_NAMES.index("force_left")], u[INPUT_NAMES.index("force_right")] = forces
    u[0] = x[0]
    places = _places(hoist)
    x[places.v[:3]] = speed / hoist.sheave_radius, speed, -speed
    derivatives = _derivatives(hoist.equation_structure)
    still = np.zeros(len(places.names))
    if speed:  # the motor makes up for the losses
        by_x, _, _, values = map(
            np.array, derivatives(x, still, u, state.free_lengths, hoist.numbers)
        )
        u[0] = x[0] = x[0] - values[0, 0] / by_x[0, 0]
    by_x, by_a, by_u, values = map(
        np.array, derivatives(x, still, u, state.free_lengths, hoist.numbers)
    )
    return _WorkingPoint(x, values, by_x, by_a, by_u)


def linear_hoist(
    hoist: Hoist,
    heights: tuple[float, float],
    forces: tuple[float, float],
    held_by: HeldBy,
    speed: float,
) -> LinearHoist:
    """Return the hoist's part with its conveyances at these heights and this speed, under forces of one rope."""
    x, values, by_x, by_a, by_u = _working_point(hoist, heights, forces, held_by, speed)
    places = _places(hoist)
    states = list(state_names(hoist))
    q = places.q
    v = places.v
    lag = places.lag
    n = len(q)
    # rows: Lagrange's, tensions, rates, what is shown
    rates = n + 2
    shown = n + 2 + len(states)
    late = [rates + k for k in lag]
    if _DEFLECTION in states:  # it follows the rim: a spring
        k = states.index(_DEFLECTION)
        by_x[:, q] += np.outer(by_x[:, k], by_x[rates + k, v])
    size = n + len(lag)
    M, D, K = (np.zeros((size, size)) for _ in range(3))
    M[:n, :n] = by_a[:n]
    D[:n, :n] = by_x[:n, v]
    K[:n, :n] = by_x[:n, q]
    K[:n, n:] = by_x[:n, lag]
    D[n:, :n] = -by_x[late][:, v]
    D[n:, n:] = np.eye(len(lag))
    K[n:, :n] = -by_x[late][:, q]
    K[n:, n:] = -by_x[late][:, lag]
    commands = ["torque_command"]
    rest_commands = [x[0]]
    if held_by == "brake":
        commands.append("brake")
        rest_commands.append(1.0)
    B = np.zeros((size, len(commands) + 3))
    B[n:, : len(commands)] = by_u[late][:, [INPUT_NAMES.index(name) for name in commands]]
    B[:n, len(commands)] = -by_x[:n, 0]
    B[1, -2] = B[2, -1] = 1.0
    seen = [*range(n, n + 2), *range(shown, shown + len(_DRIVE_OUTPUTS))]
    C = by_x[seen][:, [*q, *lag]]
    C_v, C_a = (np.hstack((by[seen], np.zeros((len(seen), len(lag))))) for by in (by_x[:, v], by_a))
    return LinearHoist(
        places.names,
        lags=tuple(states[k] for k in lag),
        matrices=(M, D, K),
        inputs=(*commands, "torque", "force_left", "force_right"),
        B=B,
        outputs=(*_TENSIONS, *_DRIVE_OUTPUTS),
        maps=(C, C_v, C_a),
        through=np.zeros((len(seen), B.shape[1])),
        rest_inputs=np.array([*rest_commands, 0.0, 0.0, 0.0]),
        rest_outputs=values[seen].ravel(),
    )
