"""Values of the rope's outputs, by the names of rules.signal_table."""

from collections.abc import Callable
from typing import Protocol

import numpy as np

from rope_model.arrays import Array
from rope_model.parameters import Scene
from rope_model.physics.accuracy import end_force_error, loop_error
from rope_model.physics.centreline import nearest_turn, turns
from rope_model.physics.contact_error import (
    add_contact_end_error,
    add_contact_loop_error,
    contact_error,
)
from rope_model.physics.estimates import loop_width
from rope_model.physics.frame import conveyance_load
from rope_model.physics.guard import sideways
from rope_model.physics.node import ANGLE, POSITION, arc_lengths
from rope_model.physics.shaft import KINDS
from rope_model.physics.stress import material_values
from rope_model.rules.audit import signal_values as audit_values
from rope_model.rules.end_paths import END_NODE, SIDES
from rope_model.rules.input_misfit import add_drift_error, add_misfit_error
from rope_model.rules.messages import messages
from rope_model.rules.messages.result_warnings import ends_yaw
from rope_model.rules.signal_table import SHAPE_POINTS, SIGNALS
from rope_model.rules.state import RopeState
from rope_model.rules.state_signals import STATE_SIGNALS, remembered
from rope_model.rules.swivel_phases import Phase
from rope_model.simulation.contact.shaft import clearances
from rope_model.simulation.ends.ends import HangingEnds
from rope_model.simulation.mesh.transfer import interpolate
from rope_model.simulation.outputs import diagnostics
from rope_model.simulation.outputs.guards import rise
from rope_model.simulation.rigid import rigid_tension
from rope_model.simulation.rope_system import RopeSystem


class SignalSource(Protocol):
    """Source of the signals: simulation.simulator.RopeSimulator."""

    @property
    def scene(self) -> Scene: ...
    @property
    def state(self) -> RopeState: ...
    @property
    def ends(self) -> HangingEnds: ...
    @property
    def loop(self) -> diagnostics.LoopBottom: ...
    @property
    def system(self) -> RopeSystem: ...


def group_of(name: str) -> Callable[[SignalSource], dict[str, float]]:
    """Return the function that computes the signal ``name`` together with related ones."""
    if name in STATE_SIGNALS:
        return state_signals
    if name.endswith(".added_mass"):
        return added_mass_signals
    if name.endswith(".twist"):
        return stress_signals
    if name.startswith(("shape.s", "shape.tension", "shape.bending", "shape.torsion")):
        return along_signals
    groups = {
        "loop": loop_signals,
        "stress": stress_signals,
        "shape": shape_signals,
        "station": station_signals,
    }
    groups |= {"status": error_signals, "audit": audit_signals}
    groups |= {"contact": contact_signals, "clearance": clearance_signals}
    return groups.get(name.partition(".")[0], end_signals)


def added_mass_signals(rope: SignalSource) -> dict[str, float]:
    """Refuse: the native rope alone takes a step again to differentiate it."""
    raise ValueError(messages.native_alone("left.added_mass and right.added_mass"))


def state_signals(rope: SignalSource) -> dict[str, float]:
    """Return the signals that the state contains."""
    return {name: float(value) for name, value in remembered(rope.state).items()}


_OF_A_SWIVEL = ("swivel.angle", "swivel.rate", "swivel.torque", "swivel.slipping")
_OF_AN_END = ("fx", "fy", "fz", "mx", "my", "mz", "fy_mean", *_OF_A_SWIVEL)


def end_signals(rope: SignalSource) -> dict[str, float]:
    """Return forces, moments and swivels of both ends."""
    m, ends, means = rope.state.motion, rope.ends, rope.state.force_mean
    out: dict[str, float] = {}
    for side, (name, node) in enumerate(zip(SIDES, END_NODE, strict=True)):
        q, torque = m.q[node].tolist(), ends.moment(side, m.q, m.reaction)
        load, slips = (
            conveyance_load(q, m.reaction[node].tolist(), torque),
            ends.states[side].phase is Phase.SLIP,
        )
        values = (
            *load,
            means[side],
            *ends.relative(side, m.t, q[ANGLE], m.v[node, ANGLE]),
            torque,
            slips,
        )
        out |= {
            f"{name}.{key}": float(value) for key, value in zip(_OF_AN_END, values, strict=True)
        }
    return out


def loop_signals(rope: SignalSource) -> dict[str, float]:
    """Return position, yaw and clearance of the loop."""
    state, scene = rope.state, rope.scene
    bottom = rope.loop
    out = {f"loop.{axis}": float(x) for axis, x in zip("xyz", bottom.position, strict=True)}
    q, lengths, yaw = (
        state.motion.q,
        state.partition.lengths,
        nearest_turn(bottom.yaw, state.loop_yaw),
    )
    clearance = diagnostics.leg_clearance(
        q, lengths, bottom, loop_width(scene), scene.rope.diameter, scene.layout.spacing
    )
    return out | {
        "loop.yaw": yaw,
        "loop.clearance": clearance,
        "loop.turns": turns(yaw, ends_yaw(q), state.crossing.net),
        "loop.rise": rise(scene, state, bottom),
        "loop.sideways": float(sideways(bottom.position, q[0], q[-1])),
    }


def clearance_signals(rope: SignalSource) -> dict[str, float]:
    """Return the distances of the rope from the bodies of its scene."""
    nearest_of_kind = clearances(rope.scene, rope.state)
    return {
        f"clearance.{kind}": nearest.clearance
        for kind, nearest in zip(KINDS, nearest_of_kind, strict=True)
    }


def stress_signals(rope: SignalSource) -> dict[str, float]:
    """Return the largest stresses, and the twist."""
    bending, torsion, _, _, tau = _material(rope)
    at_bottom = int(np.searchsorted(np.cumsum(rope.state.partition.lengths), rope.loop.s))
    return {
        "left.twist": float(tau[0]),
        "right.twist": float(tau[-1]),
        "loop.twist": float(tau[min(at_bottom, tau.size - 1)]),
        "stress.bending_max": float(bending.max()),
        "stress.torsion_max": float(torsion.max()),
    }


def contact_signals(rope: SignalSource) -> dict[str, float]:
    """Return the forces between the rope and bodies in the shaft, and those on itself."""
    kinds = *KINDS, "rope"
    m, forces = rope.state.motion, dict.fromkeys(kinds, 0.0)
    if rope.state.fidelity != "rigid":
        forces |= rope.system.external_sums(m.q, m.v)
    return {f"contact.{kind}": forces[kind] for kind in kinds}


def error_signals(rope: SignalSource) -> dict[str, float]:
    """Return the error estimates of the run so far."""
    scene, errors, cells, contact = (
        rope.scene,
        rope.state.errors,
        rope.state.partition,
        rope.state.contact,
    )
    at_ends = add_contact_end_error(
        end_force_error(scene.rope, errors), contact, errors.time, errors.force
    )
    at_loop = add_contact_loop_error(
        scene, loop_error(scene, errors, cells.fine_length, cells.grading_length), contact
    )
    return {
        "status.end_force_error": float(add_misfit_error(at_ends, errors, *rope.state.filters)),
        "status.loop_error": float(add_drift_error(at_loop, *rope.state.filters)),
        "status.contact_error": float(contact_error(contact)),
    }


def audit_signals(rope: SignalSource) -> dict[str, float]:
    """Return the worst values of the audit so far; 0 before anything was computed."""
    names = (name for name in SIGNALS if name.startswith("audit."))
    return dict(zip(names, audit_values(rope.state.audit), strict=True))


def shape_signals(rope: SignalSource) -> dict[str, float]:
    """Return points along the rope."""
    q, lengths = rope.state.motion.q, rope.state.partition.lengths
    points = diagnostics.shape(q, lengths, rope.loop.s, loop_width(rope.scene), SHAPE_POINTS)
    return _rows("shape", dict(zip("xyz", points.T, strict=True)))


def along_signals(rope: SignalSource) -> dict[str, float]:
    """Return arc lengths, tension and stresses at the points of the shape."""
    lengths = rope.state.partition.lengths
    s = diagnostics.shape_places(lengths, rope.loop.s, loop_width(rope.scene), SHAPE_POINTS)
    bending, torsion = (
        diagnostics.interpolate_midpoints(stress, lengths, s) for stress in _material(rope)[:2]
    )
    return _rows(
        "shape", {"s": s, "tension": pull_at(rope, s), "bending": bending, "torsion": torsion}
    )


def station_signals(rope: SignalSource) -> dict[str, float]:
    """Return tension, curvature, torque and position of points that stay in the rope."""
    where, lengths = rope.scene.station, rope.state.partition.lengths
    s = float(np.sum(lengths)) * np.linspace(where.first, where.last, SHAPE_POINTS)
    curvature, torque = (
        diagnostics.interpolate_midpoints(values, lengths, s) for values in _material(rope)[2:4]
    )
    points = dict(
        zip(
            "xyz",
            interpolate(rope.state.motion.q, arc_lengths(lengths), s)[:, POSITION].T,
            strict=True,
        )
    )
    return _rows(
        "station", {"tension": pull_at(rope, s), "curvature": curvature, "torque": torque} | points
    )


def pull_at(rope: SignalSource, s: Array) -> Array:
    """Return the tension (N) at arc lengths ``s`` (m)."""
    m, lengths = rope.state.motion, rope.state.partition.lengths
    rho, gravity = rope.scene.rope.mass_per_length, rope.scene.layout.gravity
    if rope.state.fidelity == "rigid":
        return rigid_tension(m, s, interpolate(m.q, arc_lengths(lengths), s)[:, 1], rho, gravity)
    return diagnostics.tension(m, lengths, s, rho, gravity)


def _rows(group: str, rows: dict[str, Array]) -> dict[str, float]:
    return {
        f"{group}.{name}[{i}]": float(x)
        for name, row in rows.items()
        for i, x in enumerate(row, start=1)
    }


def _material(rope: SignalSource) -> tuple[Array, ...]:
    """Return bending and torsional stress (Pa), curvature (1/m), torque (N m) and twist (rad/m) of each element.

    Stresses are those of a solid round bar; bending is root mean square along it.  Without torsion there is no torque.
    """
    strains = rope.system.strains(rope.state.motion.q, rope.state.motion.v)
    return *material_values(
        rope.scene.rope, float(rope.state.fidelity == "torsional"), strains.T
    ), strains[:, 1]
