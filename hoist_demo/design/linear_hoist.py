"""The hoist's part of the linear models: the derivative of Lagrange's equation in the drive.

The equation is that of ``drive/equations.py``. The coordinates are those of the drive, and behind
them what lags: motor torque and brake. The hoist is left without what has no derivative: Coulomb
friction, jams, slip on the lining, play between the guides. A sticking brake is a spring.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np

from hoist_demo.drive.coordinates import (
    FORCES,
    INPUT_NAMES,
    STATE_NAMES,
    TORQUE,
    TORQUE_COMMAND,
    extra_coordinates,
    state_names,
)
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
_RELEASED = 1.0  #: Command of the brake at rest.
_LOADS = ("torque", "force_left", "force_right")  #: Inputs that act on coordinates.
_ANGLE = 0  #: Row of Lagrange's equation of phi.


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
    """Linear model of the hoist: ``coordinates`` first, then ``lags``, in dense matrices."""

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
    deflection: int  # of the brake; -1 without one


def _places(hoist: Hoist) -> _Places:
    states = list(state_names(hoist))
    coordinates = ("phi", "y_left", "y_right", *extra_coordinates(hoist))
    short = {"phi": "phi_rate", "y_left": "v_left", "y_right": "v_right"}
    q = [states.index(name) for name in coordinates]
    v = [states.index(short.get(name, f"{name}_rate")) for name in coordinates]
    lag = [k for k, name in enumerate(states) if k not in (*q, *v) and name != _DEFLECTION]
    deflection = states.index(_DEFLECTION) if _DEFLECTION in states else -1
    return _Places(coordinates, q, v, lag, deflection)


class _Rows(NamedTuple):
    """Rows of the values of ``_derivatives``."""

    lagrange: range
    tensions: range
    rates: range  # of all states
    outputs: range  # _DRIVE_OUTPUTS


def _rows(hoist: Hoist) -> _Rows:
    lagrange = range(len(_places(hoist).names))
    tensions = range(lagrange.stop, lagrange.stop + len(_TENSIONS))
    rates = range(tensions.stop, tensions.stop + len(state_names(hoist)))
    outputs = range(rates.stop, rates.stop + len(_DRIVE_OUTPUTS))
    return _Rows(lagrange, tensions, rates, outputs)


def _held_by_brake(hoist: Hoist, x: Array) -> Array:
    """Return the state in which the brake holds instead of the motor; ValueError if it cannot."""
    brake = hoist.brake
    assert brake is not None
    torque = float(x[TORQUE])
    if abs(torque) > brake.torque:
        raise ValueError(
            f"the imbalance of {abs(torque):.6g} N m must be within brake.torque = {brake.torque:g} N m: "
            "take a stronger brake"
        )
    names = list(state_names(hoist))
    x = x.copy()
    x[TORQUE] = 0.0
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
    u[list(FORCES)] = forces
    u[TORQUE_COMMAND] = x[TORQUE]
    places = _places(hoist)
    x[STATE_NAMES.index("phi_rate")] = speed / hoist.sheave_radius
    x[STATE_NAMES.index("v_left")] = speed
    x[STATE_NAMES.index("v_right")] = -speed
    derivatives = _derivatives(hoist.equation_structure)
    still = np.zeros(len(places.names))
    if speed:  # the motor makes up for the losses
        by_x, _, _, values = map(
            np.array, derivatives(x, still, u, state.free_lengths, hoist.numbers)
        )
        x[TORQUE] -= values[_ANGLE, 0] / by_x[_ANGLE, TORQUE]
        u[TORQUE_COMMAND] = x[TORQUE]
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
    point = _working_point(hoist, heights, forces, held_by, speed)
    places = _places(hoist)
    rows = _rows(hoist)
    commands = ["torque_command"]
    rest_commands = [point.x[TORQUE]]
    if held_by == "brake":
        commands.append("brake")
        rest_commands.append(_RELEASED)
    inputs = (*commands, *_LOADS)
    if _DEFLECTION in state_names(hoist):
        point = _with_brake_spring(point, places, rows)
    seen = [*rows.tensions, *rows.outputs]
    return LinearHoist(
        places.names,
        lags=tuple(state_names(hoist)[k] for k in places.lag),
        matrices=_matrices(point, places, rows),
        inputs=inputs,
        B=_input_matrix(point, places, rows, inputs),
        outputs=(*_TENSIONS, *_DRIVE_OUTPUTS),
        maps=_maps(point, places, seen),
        through=np.zeros((len(seen), len(inputs))),
        rest_inputs=np.array([*rest_commands, *(0.0 for _ in _LOADS)]),
        rest_outputs=point.values[seen].ravel(),
    )


def _with_brake_spring(point: _WorkingPoint, places: _Places, rows: _Rows) -> _WorkingPoint:
    """Return the derivatives with the brake's deflection, which follows the rim, as a spring."""
    deflection = places.deflection
    by_x = point.by_x.copy()
    follows = by_x[rows.rates[deflection], places.v]
    by_x[:, places.q] += np.outer(by_x[:, deflection], follows)
    return point._replace(by_x=by_x)


def _matrices(point: _WorkingPoint, places: _Places, rows: _Rows) -> tuple[Array, Array, Array]:
    """Return M, D and K of coordinates and lags; a lag's row is its rate less the derivative of it."""
    n = len(places.q)
    size = n + len(places.lag)
    late = [rows.rates[k] for k in places.lag]
    M, D, K = (np.zeros((size, size)) for _ in range(3))
    M[:n, :n] = point.by_a[rows.lagrange]
    D[:n, :n] = point.by_x[rows.lagrange][:, places.v]
    D[n:, :n] = -point.by_x[late][:, places.v]
    D[n:, n:] = np.eye(len(places.lag))
    K[:n, :n] = point.by_x[rows.lagrange][:, places.q]
    K[:n, n:] = point.by_x[rows.lagrange][:, places.lag]
    K[n:, :n] = -point.by_x[late][:, places.q]
    K[n:, n:] = -point.by_x[late][:, places.lag]
    return M, D, K


def _input_matrix(
    point: _WorkingPoint, places: _Places, rows: _Rows, inputs: Sequence[str]
) -> Array:
    """Return B: commands move what lags, the motor's torque and the ropes' forces the coordinates."""
    n = len(places.q)
    late = [rows.rates[k] for k in places.lag]
    B = np.zeros((n + len(places.lag), len(inputs)))
    for column, name in enumerate(inputs):
        if name in INPUT_NAMES and name not in _LOADS:
            B[n:, column] = point.by_u[late, INPUT_NAMES.index(name)]
    B[:n, inputs.index("torque")] = -point.by_x[rows.lagrange, TORQUE]
    B[places.names.index("y_left"), inputs.index("force_left")] = 1.0
    B[places.names.index("y_right"), inputs.index("force_right")] = 1.0
    return B


def _maps(point: _WorkingPoint, places: _Places, seen: Sequence[int]) -> tuple[Array, Array, Array]:
    """Return C, C_v and C_a of the rows ``seen``; rates and accelerations of lags do not show."""
    by_x = point.by_x[seen]
    no_lags = np.zeros((len(seen), len(places.lag)))
    return (
        by_x[:, [*places.q, *places.lag]],
        np.hstack((by_x[:, places.v], no_lags)),
        np.hstack((point.by_a[seen], no_lags)),
    )
