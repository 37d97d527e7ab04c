"""Linear models of hoist and balance ropes at rest or at constant speed, anywhere along the trip.

The coordinates x of `linear_model` are those of the hoist, of the ropes' nodes, and of what lags behind: motor torque
and brake. The rope's part is `rope_model.analysis.linear`, the hoist's the derivative of Lagrange's equation
in `drive/equations.py`. Ropes and conveyances share the heights of the ends; each of n equal ropes counts n times. Rows
of M are 0 for what lags. Sideways motion and yaw of the conveyances are given: their accelerations are inputs.

The hoist is left without what has no derivative: Coulomb friction, jams, slip on the lining, play between the guides.
A sticking brake is a spring. At constant speed the lengths of head ropes and legs are frozen.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np
import scipy.sparse as sp

from hoist_demo.cases.case import Case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.design.linear_model import Array, LinearModel
from hoist_demo.drive.equations import INPUT_NAMES, equations, extra_coordinates, state_names
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.drive.plant import HoistPlant
from hoist_demo.parameters import SIDES, Hoist
from hoist_demo.parameters.suspension import SuspensionOffset
from rope_model import EndMotion, Level, Scene
from rope_model.analysis.linear import LinearRope, linear_rope
from rope_model.engine import NativeRope
from rope_model.physics.elementary import sum_of

Swivels = Literal["as given", "locked", "free", "sticking"]
HeldBy = Literal["motor", "brake"]
_MODES = {"locked": 0, "free": 1, "sticking": 2}  #: codes of swivel.mode
#: Coordinates of an end, and places in a node's row; their accelerations are inputs but for the shared height.
_END = {"x": 0, "y": 1, "z": 2, "yaw": 6}
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


def linearise(
    case: Case,
    at: Iterable[float] = (0.0, 0.25, 0.5, 0.75, 1.0),
    swivels: Swivels = "as given",
    held_by: HeldBy = "motor",
    level: Level = "standard",
    speed: float = 0.0,
) -> tuple[LinearModel, ...]:
    """Return the linear models of a hoist with its balance ropes at places along the trip.

    Parameters
    ----------
    case : Case
        Hoist and ropes; trip and gains do not matter.
    at : iterable of float
        Heights of the left conveyance over the travel, 0 to 1.
    swivels : {"as given", "locked", "free", "sticking"}
        Both swivels; "sticking" ones hold where the rope was hung, by friction.
    held_by : {"motor", "brake"}
        What holds the imbalance: the motor, its brake open, or the brake, its motor without torque.
    level : Level
        Accuracy of the rope.
    speed : float
        Constant speed of the left conveyance [m/s], upwards. The rope flows through its shape, and the motor holds the
        speed; lengths of ropes are frozen.

    Returns
    -------
    tuple of LinearModel
        One for each place.

    Raises
    ------
    ValueError
        If the rope does not hang there, or touches a body; if the motor or the brake cannot hold.
    """
    if speed and held_by == "brake":
        raise ValueError(f"speed = {speed:g} m/s must be 0 with held_by = 'brake': take 'motor'")
    hoist = _smooth(case.hoist, held_by)
    specs = _rope_specs(case, swivels, level)
    return tuple(_assembled(x, *_parts(hoist, specs, x, held_by, speed)) for x in at)


def linearise_hoist(
    case: Case, at: float, held_by: HeldBy = "motor", level: Level = "standard"
) -> LinearModel:
    """Return the model of a hoist under the constant forces of ropes at rest: what a controller sees without them."""
    _, drive = _parts(_smooth(case.hoist, held_by), _rope_specs(case, level=level), at, held_by)
    M, D, K = (sp.csc_matrix(A) for A in drive.matrices)
    C, C_v, C_a = (sp.csr_matrix(A) for A in drive.maps)
    return LinearModel(
        at,
        (*drive.coordinates, *drive.lags),
        0,
        len(drive.lags),
        M,
        D,
        K,
        drive.inputs,
        drive.B,
        drive.outputs,
        (C, C_v, C_a),
        drive.through,
        drive.rest_inputs,
        drive.rest_outputs,
    )


def linearise_rope(scene: Scene, left: EndMotion, right: EndMotion) -> LinearModel:
    """Return the linear model of a rope alone, at rest between these ends, whose accelerations are the inputs."""
    spec = LinearRopeSpec(_rope(scene))
    return _assembled(0.0, [(spec, _hung(spec.rope, left, right))], LinearHoist.none())


class LinearRopeSpec(NamedTuple):
    """One balance rope, or several equal ones."""

    rope: NativeRope
    number: int = 1
    name: str = ""  # name of one of several ropes that differ
    suspension: SuspensionOffset = SuspensionOffset()


def _rope_specs(
    case: Case, swivels: Swivels = "as given", level: Level = "standard"
) -> list[LinearRopeSpec]:
    """Return the balance ropes of a hoist, ready to hang."""
    if not case.distinct_ropes:
        scene = rope_scene({**case.rope, **_swivels(swivels)}, level)
        return [LinearRopeSpec(_rope(scene), case.hoist.tail_rope_number)]
    specs = []
    # ropes that differ in their places alone hang alike: they are hung, and have their derivatives, once
    known = dict[Scene, NativeRope]()
    for rope in case.distinct_ropes:
        suspension = SuspensionOffset(**rope.suspension)
        scene = rope_scene({**rope.parameters, **_swivels(swivels)}, level, suspension)
        if scene not in known:
            known[scene] = _rope(scene)
        specs.append(LinearRopeSpec(known[scene], rope.number, rope.name, suspension))
    return specs


def _swivels(wanted: Swivels) -> dict[str, int]:
    if wanted == "as given":
        return {}
    if wanted not in _MODES:
        raise ValueError(
            f"swivels = {wanted!r} must be 'as given', {', '.join(map(repr, _MODES))}: choose one"
        )
    return dict.fromkeys(("left.swivel.mode", "right.swivel.mode"), _MODES[wanted])


def _rope(scene: Scene) -> NativeRope:
    return NativeRope(scene.with_(model=replace(scene.model, fidelity="torsional")))


def _hung(rope: NativeRope, left: EndMotion, right: EndMotion, speed: float = 0.0) -> LinearRope:
    status = rope.initialize(0.0, left, right)
    if status.valid:
        status = rope.release_free_swivels()
    if not status.valid:
        raise ValueError(
            f"rope at rest with left.y = {left.y:g} m and right.y = {right.y:g} m: {status.message}"
        )
    return linear_rope(rope, speed)


def _smooth(hoist: Hoist, held_by: HeldBy) -> Hoist:
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
    x, a = (
        ca.SX.sym("x", len(state_names(structure))),
        ca.SX.sym("a", 3 + len(extra_coordinates(structure))),
    )
    u, l0, p = (
        ca.SX.sym("u", len(INPUT_NAMES)),
        ca.SX.sym("l0", 2),
        ca.SX.sym("p", len(structure.numbers)),
    )
    rows = ca.vertcat(of.lagrange(x, a, u, l0, p), of.rates(x, u, l0, p))
    outputs = of.outputs(x, u, l0, p)
    values = ca.vertcat(rows, *(outputs[OUTPUT_INDEX[name]] for name in _DRIVE_OUTPUTS))
    jacobians = [ca.densify(ca.jacobian(values, z)) for z in (x, a, u)]
    return ca.Function("derivatives", [x, a, u, l0, p], [ca.cse(y) for y in (*jacobians, values)])


def _linear_hoist(
    hoist: Hoist,
    heights: tuple[float, float],
    forces: tuple[float, float],
    held_by: HeldBy,
    speed: float,
) -> LinearHoist:
    """Return the hoist's part with its conveyances at these heights and this speed, under forces of one rope."""
    plant = HoistPlant(hoist, "portable")
    if held_by == "motor":
        state = plant.equilibrium(*heights, *forces)
    else:
        state = plant.hanging_state(*heights, *forces)
    x, names, torque = state.x.copy(), list(state_names(hoist)), float(state.x[0])
    u = np.zeros(len(INPUT_NAMES))
    # the asked pressure counts as within its limits, where it acts
    u[INPUT_NAMES.index("brake")] = 0.5
    u[INPUT_NAMES.index("force_left")], u[INPUT_NAMES.index("force_right")] = forces
    if held_by == "brake":
        assert hoist.brake is not None
        if abs(torque) > hoist.brake.torque:
            raise ValueError(
                f"the imbalance of {abs(torque):.6g} N m must be within brake.torque = {hoist.brake.torque:g} N m: "
                "take a stronger brake"
            )
        x[0], x[names.index("brake_pressure")] = 0.0, 1.0
        x[names.index("brake_deflection")] = -torque / hoist.brake.torque * hoist.brake.travel
        if hoist.drive_shaft is not None:
            x[names.index("twist")] = 0.0
    u[0] = x[0]

    coordinates = ("phi", "y_left", "y_right", *extra_coordinates(hoist))
    n = len(coordinates)
    short = {"phi": "phi_rate", "y_left": "v_left", "y_right": "v_right"}
    q = [names.index(name) for name in coordinates]
    v = [names.index(short.get(name, f"{name}_rate")) for name in coordinates]
    deflection = "brake_deflection"
    x[v[:3]] = speed / hoist.sheave_radius, speed, -speed
    lag = [k for k, name in enumerate(names) if k not in (*q, *v) and name != deflection]
    numbers = hoist.numbers
    derivatives = _derivatives(hoist.equation_structure)
    still = np.zeros(n)
    if speed:  # the motor makes up for the losses
        by_x, _, _, values = (
            np.array(part) for part in derivatives(x, still, u, state.free_lengths, numbers)
        )
        u[0] = x[0] = x[0] - values[0, 0] / by_x[0, 0]
    by_x, by_a, by_u, values = (
        np.array(part) for part in derivatives(x, still, u, state.free_lengths, numbers)
    )
    # rows: Lagrange's, tensions, rates, what is shown
    rates, shown = n + 2, n + 2 + len(names)
    late = [rates + k for k in lag]
    if deflection in names:  # it follows the rim: a spring
        k = names.index(deflection)
        by_x[:, q] += np.outer(by_x[:, k], by_x[rates + k, v])
    size = n + len(lag)
    M, D, K = (np.zeros((size, size)) for _ in range(3))
    M[:n, :n], D[:n, :n], K[:n, :n], K[:n, n:] = by_a[:n], by_x[:n, v], by_x[:n, q], by_x[:n, lag]
    D[n:, :n], D[n:, n:] = -by_x[late][:, v], np.eye(len(lag))
    K[n:, :n], K[n:, n:] = -by_x[late][:, q], -by_x[late][:, lag]
    commands = ["torque_command", *(["brake"] if held_by == "brake" else [])]
    B = np.zeros((size, len(commands) + 3))
    B[n:, : len(commands)] = by_u[late][:, [INPUT_NAMES.index(name) for name in commands]]
    B[:n, len(commands)] = -by_x[:n, 0]
    B[1, -2] = B[2, -1] = 1.0
    seen = [*range(n, n + 2), *range(shown, shown + len(_DRIVE_OUTPUTS))]
    C = by_x[seen][:, [*q, *lag]]
    C_v, C_a = (np.hstack((by[seen], np.zeros((len(seen), len(lag))))) for by in (by_x[:, v], by_a))
    return LinearHoist(
        coordinates,
        tuple(names[k] for k in lag),
        (M, D, K),
        (*commands, "torque", "force_left", "force_right"),
        B,
        (*_TENSIONS, *_DRIVE_OUTPUTS),
        (C, C_v, C_a),
        np.zeros((len(seen), B.shape[1])),
        np.array([x[0], *([1.0] if held_by == "brake" else []), 0.0, 0.0, 0.0]),
        values[seen].ravel(),
    )


_Hung = Sequence[tuple[LinearRopeSpec, LinearRope]]


def _parts(
    hoist: Hoist, specs: Iterable[LinearRopeSpec], at: float, held_by: HeldBy, speed: float = 0.0
) -> tuple[_Hung, LinearHoist]:
    """Return ropes and hoist at this part of the travel."""
    if not 0.0 <= at <= 1.0:
        raise ValueError(f"at = {at:g} must be within 0 and 1: it is a part of the travel")
    left, right = at * hoist.shaft_travel, (1.0 - at) * hoist.shaft_travel
    specs = list(specs)
    ends = EndMotion(y=left), EndMotion(y=right)
    ropes = {
        id(rope): _hung(rope, *ends, speed)
        for rope in {id(spec.rope): spec.rope for spec in specs}.values()
    }
    hung = [(spec, ropes[id(spec.rope)]) for spec in specs]
    # the hoist takes its ropes for so many equal ones
    pulls = [
        sum_of(
            spec.number * float(rope.rest[rope.outputs.index(f"{side}.fy")]) for spec, rope in hung
        )
        / hoist.tail_rope_number
        for side in SIDES
    ]
    return hung, _linear_hoist(hoist, (left, right), (pulls[0], pulls[1]), held_by, speed)


def _end_coordinates(rope: LinearRope) -> dict[str, int]:
    """Return the coordinates of a rope's ends by name."""
    firsts = {"left": 0, "right": rope.free.size - 7}
    return {f"{side}.{name}": firsts[side] + k for side in SIDES for name, k in _END.items()}


def _is_moved(spec: LinearRopeSpec, rope: LinearRope, name: str) -> bool:
    """Return True if a conveyance that moves so takes the rope's end along."""
    side, _, direction = name.partition(".")
    return not rope.free[_end_coordinates(rope)[name]] or (
        direction == "yaw" and any(spec.suspension.at(side))
    )


def _carried(
    spec: LinearRopeSpec, rope: LinearRope, first: int, shared: Mapping[str, int], size: int
) -> sp.csc_matrix:
    """Return a rope's coordinates by those of the model: its own from `first` on, its ends' by the `shared` ones."""
    ends = _end_coordinates(rope)
    entries = [(k, first + j, 1.0) for j, k in enumerate(np.flatnonzero(rope.free).tolist())]
    # yaw turns the left end against theta; a swivel that turns freely does not feel it
    entries += [
        (ends[name], column, -1.0 if name == "left.yaw" else 1.0)
        for name, column in shared.items()
        if not rope.free[ends[name]]
    ]
    # the derivative of suspension.motion_at
    for side in SIDES if spec.name else ():
        if (yaw := shared.get(f"{side}.yaw")) is not None:
            x, z = spec.suspension.at(side)
            entries += [(ends[f"{side}.x"], yaw, z), (ends[f"{side}.z"], yaw, -x)]
    rows, columns, values = zip(*entries, strict=True)
    return sp.csc_matrix((values, (rows, columns)), shape=(rope.free.size, size))


def _assembled(at: float, hung: _Hung, hoist: LinearHoist) -> LinearModel:
    """Return hoist and ropes, joined at the heights of the ends."""
    drives, n_lags, ropes = len(hoist.coordinates), len(hoist.lags), [rope for _, rope in hung]
    if drives:
        heights = {f"{side}.y": hoist.coordinates.index(f"y_{side}") for side in SIDES}
    else:
        heights = {}
    held = [
        name
        for name in _end_coordinates(ropes[0])
        if name not in heights and any(_is_moved(spec, rope, name) for spec, rope in hung)
    ]
    firsts = drives + np.cumsum([0, *(np.count_nonzero(rope.free) for rope in ropes)])
    first_held = int(firsts[-1])
    first_lag = first_held + len(held)
    total, shared = (
        first_lag + n_lags,
        heights | dict(zip(held, range(first_held, first_lag), strict=True)),
    )
    Ts = [
        _carried(*one, first, shared, total)
        for one, first in zip(hung, firsts.tolist(), strict=False)
    ]
    mine = [*range(drives), *range(first_lag, total)]
    S = sp.csc_matrix((np.ones(len(mine)), (range(len(mine)), mine)), shape=(len(mine), total))
    keep = sp.diags([0.0 if first_held <= k < first_lag else 1.0 for k in range(total)])
    M, D, K = (
        sum(
            (
                keep @ (spec.number * (T.T @ getattr(rope, part) @ T))
                for (spec, rope), T in zip(hung, Ts, strict=True)
            ),
            keep @ (S.T @ sp.csc_matrix(H) @ S),
        ).tocsc()
        for part, H in zip(("mass", "damping", "stiffness"), hoist.matrices, strict=True)
    )
    B = np.zeros((total, len(hoist.inputs) + len(held)))
    B[mine, : len(hoist.inputs)] = hoist.B
    B[first_held:first_lag, len(hoist.inputs) :] = np.eye(len(held))
    C = [
        sp.vstack(
            [sp.csr_matrix(H) @ S, *(rope.maps[k] @ T for rope, T in zip(ropes, Ts, strict=True))]
        ).tocsr()
        for k, H in enumerate(hoist.maps)
    ]
    prefixed = [(f"{spec.name}." if spec.name else "", rope) for spec, rope in hung]
    rope_coordinates = [
        f"rope.{prefix}{k // 7}.{k % 7}"
        for prefix, rope in prefixed
        for k in np.flatnonzero(rope.free)
    ]
    names = (*hoist.coordinates, *rope_coordinates, *held, *hoist.lags)
    outputs = [f"{prefix}{name}" for prefix, rope in prefixed for name in rope.outputs]
    return LinearModel(
        at,
        names,
        len(held),
        n_lags,
        (M + sp.eye(total) - keep).tocsc(),
        D,
        K,
        (*hoist.inputs, *held),
        B,
        (*hoist.outputs, *outputs),
        (C[0], C[1], C[2]),
        np.vstack(
            (
                np.hstack((hoist.through, np.zeros((len(hoist.outputs), len(held))))),
                np.zeros((len(outputs), B.shape[1])),
            )
        ),
        np.concatenate((hoist.rest_inputs, np.zeros(len(held)))),
        np.concatenate((hoist.rest_outputs, *(rope.rest for rope in ropes))),
    )
