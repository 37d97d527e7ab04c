"""Linear models of hoist and balance ropes at rest or at constant speed, anywhere along the trip.

The coordinates x of ``linear_model`` are those of the hoist, of the ropes' nodes, and of what lags
behind: motor torque and brake. The rope's part is ``rope_model.analysis.linear``, the hoist's
``linear_hoist``. Ropes and conveyances share the heights of the ends; each of n equal ropes counts
n times. Rows of M are 0 for what lags. Sideways motion and yaw of the conveyances are given: their
accelerations are inputs.

At constant speed the lengths of head ropes and legs are frozen.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
import scipy.sparse as sp

from hoist_demo.cases.case import Case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.design.linear_hoist import HeldBy, LinearHoist, linear_hoist, smooth_hoist
from hoist_demo.design.linear_model import LinearModel
from hoist_demo.parameters import SIDES, Hoist
from hoist_demo.parameters.suspension import SuspensionOffset
from rope_model import EndMotion, Level, Scene
from rope_model.analysis.linear import LinearRope, linear_rope
from rope_model.engine import NativeRope
from rope_model.physics.elementary import sum_of
from rope_model.physics.node import NODE_DOF

Swivels = Literal["as given", "locked", "free", "sticking"]
_MODES = {"locked": 0, "free": 1, "sticking": 2}  #: codes of swivel.mode
#: Coordinates of an end, and places in a node's row; their accelerations are inputs but for the shared height.
_END = {"x": 0, "y": 1, "z": 2, "yaw": 6}


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
    hoist = smooth_hoist(case.hoist, held_by)
    specs = _rope_specs(case, swivels, level)
    return tuple(_assembled(x, *_parts(hoist, specs, x, held_by, speed)) for x in at)


def linearise_hoist(
    case: Case, at: float, held_by: HeldBy = "motor", level: Level = "standard"
) -> LinearModel:
    """Return the model of a hoist under the constant forces of ropes at rest: what a controller sees without them."""
    _, drive = _parts(
        smooth_hoist(case.hoist, held_by), _rope_specs(case, level=level), at, held_by
    )
    M, D, K = (sp.csc_matrix(A) for A in drive.matrices)
    C, C_v, C_a = (sp.csr_matrix(A) for A in drive.maps)
    return LinearModel(
        at,
        names=(*drive.coordinates, *drive.lags),
        held=0,
        lags=len(drive.lags),
        mass=M,
        damping=D,
        stiffness=K,
        inputs=drive.inputs,
        B=drive.B,
        outputs=drive.outputs,
        maps=(C, C_v, C_a),
        through=drive.through,
        rest_inputs=drive.rest_inputs,
        rest_outputs=drive.rest_outputs,
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
    known: dict[Scene, NativeRope] = {}
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


_Hung = Sequence[tuple[LinearRopeSpec, LinearRope]]


def _parts(
    hoist: Hoist, specs: Iterable[LinearRopeSpec], at: float, held_by: HeldBy, speed: float = 0.0
) -> tuple[_Hung, LinearHoist]:
    """Return ropes and hoist at this part of the travel."""
    if not 0.0 <= at <= 1.0:
        raise ValueError(f"at = {at:g} must be within 0 and 1: it is a part of the travel")
    left = at * hoist.shaft_travel
    right = (1.0 - at) * hoist.shaft_travel
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
    return hung, linear_hoist(hoist, (left, right), (pulls[0], pulls[1]), held_by, speed)


def _end_coordinates(rope: LinearRope) -> dict[str, int]:
    """Return the coordinates of a rope's ends by name."""
    firsts = {"left": 0, "right": rope.free.size - NODE_DOF}
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
    """Return a rope's coordinates by the model's: own from ``first`` on, the ends' ``shared``."""
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


class _Layout(NamedTuple):
    """Order of the coordinates: the drive's, those of the ropes, held ones, those that lag."""

    drives: int  # number of the drive's
    firsts: list[int]  # first coordinate of each rope
    heights: dict[str, int]  # shared heights of the ends, by name
    held: list[str]
    first_held: int
    first_lag: int
    total: int

    @property
    def shared(self) -> dict[str, int]:
        """Coordinates that move ends of several ropes, by the ends' names."""
        return self.heights | {name: self.first_held + k for k, name in enumerate(self.held)}

    @property
    def of_hoist(self) -> list[int]:
        """Coordinates of the hoist's part, in its order."""
        return [*range(self.drives), *range(self.first_lag, self.total)]


def _layout(hung: _Hung, hoist: LinearHoist) -> _Layout:
    heights: dict[str, int] = {}
    if hoist.coordinates:
        heights = {f"{side}.y": hoist.coordinates.index(f"y_{side}") for side in SIDES}
    ropes = [rope for _, rope in hung]
    held = [
        name
        for name in _end_coordinates(ropes[0])
        if name not in heights and any(_is_moved(spec, rope, name) for spec, rope in hung)
    ]
    drives = len(hoist.coordinates)
    sizes = [np.count_nonzero(rope.free) for rope in ropes]
    firsts = (drives + np.cumsum([0, *sizes])).tolist()
    first_held = firsts.pop()
    first_lag = first_held + len(held)
    return _Layout(
        drives,
        firsts,
        heights,
        held,
        first_held=first_held,
        first_lag=first_lag,
        total=first_lag + len(hoist.lags),
    )


def _assembled(at: float, hung: _Hung, hoist: LinearHoist) -> LinearModel:
    """Return hoist and ropes, joined at the heights of the ends."""
    layout = _layout(hung, hoist)
    total = layout.total
    held = range(layout.first_held, layout.first_lag)
    of_hoist = layout.of_hoist
    ropes = [rope for _, rope in hung]
    Ts = [
        _carried(spec, rope, first, layout.shared, total)
        for (spec, rope), first in zip(hung, layout.firsts, strict=True)
    ]
    ones = np.ones(len(of_hoist))
    S = sp.csc_matrix((ones, (range(len(of_hoist)), of_hoist)), shape=(len(of_hoist), total))
    keep = sp.diags([0.0 if k in held else 1.0 for k in range(total)])
    matrices = []
    for part, H in zip(("mass", "damping", "stiffness"), hoist.matrices, strict=True):
        whole = keep @ (S.T @ sp.csc_matrix(H) @ S)
        for (spec, rope), T in zip(hung, Ts, strict=True):
            whole = whole + keep @ (spec.number * (T.T @ getattr(rope, part) @ T))
        matrices.append(whole.tocsc())
    maps = []
    for k, H in enumerate(hoist.maps):
        of_ropes = [rope.maps[k] @ T for rope, T in zip(ropes, Ts, strict=True)]
        maps.append(sp.vstack([sp.csr_matrix(H) @ S, *of_ropes]).tocsr())
    M, D, K = matrices
    C, C_v, C_a = maps
    inputs = (*hoist.inputs, *layout.held)
    B = np.zeros((total, len(inputs)))
    B[of_hoist, : len(hoist.inputs)] = hoist.B
    B[held, len(hoist.inputs) :] = np.eye(len(held))
    rope_outputs = [f"{_prefix(spec)}{name}" for spec, rope in hung for name in rope.outputs]
    through = np.zeros((len(hoist.outputs) + len(rope_outputs), len(inputs)))
    through[: len(hoist.outputs), : len(hoist.inputs)] = hoist.through
    return LinearModel(
        at,
        names=(*hoist.coordinates, *_rope_coordinates(hung), *layout.held, *hoist.lags),
        held=len(held),
        lags=len(hoist.lags),
        mass=(M + sp.eye(total) - keep).tocsc(),
        damping=D,
        stiffness=K,
        inputs=inputs,
        B=B,
        outputs=(*hoist.outputs, *rope_outputs),
        maps=(C, C_v, C_a),
        through=through,
        rest_inputs=np.concatenate((hoist.rest_inputs, np.zeros(len(held)))),
        rest_outputs=np.concatenate((hoist.rest_outputs, *(rope.rest for rope in ropes))),
    )


def _prefix(spec: LinearRopeSpec) -> str:
    """Return what names of one of several ropes begin with."""
    if spec.name:
        return f"{spec.name}."
    return ""


def _rope_coordinates(hung: _Hung) -> list[str]:
    """Return the names of the ropes' free coordinates, see LinearModel."""
    names = []
    for spec, rope in hung:
        for place in np.flatnonzero(rope.free).tolist():
            node, k = divmod(place, NODE_DOF)
            names.append(f"rope.{_prefix(spec)}{node}.{k}")
    return names
