"""Natural frequencies and the yaw of the twisted loop, in both codes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rope_model.parameters import Mesh, Scene
from rope_model.simulation.diagnostics import loop_bottom, observation_points
from rope_model.simulation.modal import natural_modes
from rope_model.simulation.paths import EndMotion
from rope_model.simulation.simulator import RopeSimulator

from .elements import ELEMENTS
from .exudyn_rope import PeerRope
from .runs import TORSION_FREE, UNCOUPLED, hanging_shape

Array = NDArray[np.float64]
FINE = Mesh(kind="eem", elements=600)
MODES = 4
#: theory, Hz, from a discrete-rod model whose two meshes agree to 0.2 %: (height, plane) -> four modes
REFERENCE = {
    (0.0, "out"): (0.06518, 0.07751, 0.17880, 0.18815),
    (0.0, "in"): (0.07759, 0.11735, 0.18137, 0.24060),
    (80.0, "out"): (0.05267, 0.13533, 0.13791, 0.22317),
    (80.0, "in"): (0.07244, 0.13822, 0.19542, 0.26189),
}
#: the peer's element and count for a plane; in plane also its others
PEER_MODES = {"in": (("beam-quadratic", 240), ("ancf-lobatto", 240), ("beam", 480)), "out": (("ancf-3d", 480),)}
#: rad, turned into the rope at its right end in steps that Exudyn's static solver follows
TWIST_STEP, TWISTS = 0.01, (8, 16, 36)


@dataclass(frozen=True)
class Frequencies:
    """One row: height, m, plane, whose, and the lowest MODES frequencies, Hz."""

    height: float
    plane: str
    code: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Yaw:
    """Loop of legs of 60 m with locked ends: installed twist, rad, torque, N m, yaw, deg, and legs' offset, m."""

    code: str
    twist: float
    torque: float
    yaw: float
    left: float
    right: float


def frequencies() -> list[Frequencies]:
    """Of the rope without coupling and torsion, both planes and heights."""
    rows = []
    for (height, plane), values in REFERENCE.items():
        rows.append(Frequencies(height, plane, "reference", values))
        rows.append(Frequencies(height, plane, "ours, 600 elements", _ours(height, plane)))
        for key, count in PEER_MODES[plane]:
            label = f"Exudyn {ELEMENTS[key].label}, {count}"
            rows.append(Frequencies(height, plane, label, peer_frequencies(key, count, height, plane)))
    return rows


def _ours(height: float, plane: str) -> tuple[float, ...]:
    rope = _at_rest(TORSION_FREE.with_(mesh=FINE), height)
    # the swivel is let go with the first step
    status = rope.advance_to(1e-3, EndMotion(y=height), EndMotion())
    if not status.valid:
        raise RuntimeError(status.message)
    modes = natural_modes(rope.system, rope.state.motion.q, 12)
    chosen = (modes.out_of_plane > 0.5) == (plane == "out")
    # a swivel that spins freely is a mode without frequency
    values = modes.frequencies[chosen & (modes.frequencies > 1e-2)]
    return tuple(float(f) for f in values[:MODES])


def peer_frequencies(element: str, count: int, height: float, plane: str) -> tuple[float, ...]:
    """Exudyn's lowest MODES in or out of plane."""
    rope = PeerRope(UNCOUPLED, element, count, hanging_shape(UNCOUPLED, (height, 0.0)), (height, 0.0))
    rope.rest()
    values, out = rope.frequencies(12)
    return tuple(float(f) for f in values[(out > 0.5) == (plane == "out")][:MODES])


def yaws() -> list[Yaw]:
    """Both codes at each of TWISTS; Exudyn's follow each other."""
    rows = []
    theirs = PeerRope(UNCOUPLED, "beam-3d", 240, hanging_shape(UNCOUPLED, (0.0, 0.0)), (0.0, 0.0))
    theirs.rest()
    for k in range(1, max(TWISTS) + 1):
        theirs.twist_right_end(k * TWIST_STEP)
        if k in TWISTS:
            twist = k * TWIST_STEP
            twisted = UNCOUPLED.with_(rope=replace(UNCOUPLED.rope, installed_twist=twist), mesh=FINE)
            ours = _at_rest(twisted, 0.0)
            motion, lengths = ours.state.motion, ours.state.partition.lengths
            rows.append(_yaw("ours, 600 elements", twist, float(motion.reaction[-1, 6]), motion.q, lengths))
            torque = float(np.mean(theirs.torques()))
            rows.append(_yaw("Exudyn, 240 elements", twist, torque, theirs.configuration(), theirs.lengths))
    return rows


def _yaw(code: str, twist: float, torque: float, q: Array, lengths: Array) -> Yaw:
    bottom = loop_bottom(q, lengths)
    left, right = observation_points(q, bottom.position)[:, 2]
    return Yaw(code, twist, torque, float(np.degrees(bottom.yaw)), float(left), float(right))


def _at_rest(scene: Scene, height: float) -> RopeSimulator:
    rope = RopeSimulator(scene)
    status = rope.initialize(0.0, EndMotion(y=height), EndMotion())
    if not status.valid:
        raise RuntimeError(status.message)
    return rope
