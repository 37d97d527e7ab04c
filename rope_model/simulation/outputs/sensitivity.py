"""Derivatives of the end loads at the end of a step with respect to an input of an end, at its start or end.

The rope is linearised about the present state, and one generalized-alpha step as long as the last carries the change;
rope_load_derivative in rope_model/csrc is its C port.
"""

from typing import Protocol

import numpy as np

from rope_model.parameters import Scene
from rope_model.physics.frame import conveyance_load
from rope_model.simulation.ends.ends import YAW_SENSE, HangingEnds
from rope_model.simulation.ends.input_filter import MIN_AIM_TIME, MIN_MEAN_TIME, lean_moves, sample_moves, settings_of
from rope_model.simulation.ends.paths import END_NODE, SIDES, ends_at
from rope_model.simulation.ends.swivel_phases import Phase
from rope_model.simulation.messages import messages
from rope_model.simulation.rigid import tension_change
from rope_model.simulation.rope_system import ANGLE, Array
from rope_model.simulation.state import RopeState

#: changes in m, m/s, m/s^2, or in rad: too small to bend the rope, large against rounding
_SIZES = (1e-7, 1e-5, 1e-3)
#: names of the signals that are differentiated
LOADS = tuple(f"{side}.{kind}{axis}" for side in SIDES for kind in "fm" for axis in "xyz")
#: order of the time derivative, and degree of freedom, of each field of EndMotion
INPUTS = {f"{prefix}{axis}": (order, k) for order, prefix in enumerate(("", "v", "a")) for k, axis in enumerate("xyz")}
INPUTS |= {"yaw": (0, ANGLE), "yaw_rate": (1, ANGLE), "lean": (0, ANGLE + 1), "lean_z": (0, ANGLE + 2)}


class Linearised(Protocol):
    """Rope with responses to motions of its ends: simulation.simulator.RopeSimulator."""

    @property
    def scene(self) -> Scene: ...
    @property
    def state(self) -> RopeState: ...
    @property
    def ends(self) -> HangingEnds: ...
    def answer(self, side: int, dof: int, change: Array) -> tuple[Array, Array]: ...


def load_derivative(rope: Linearised, side: int, name: str, at_step_end: bool = True) -> Array:
    """Return the derivatives (12,) of LOADS with respect to the field ``name`` of an end's EndMotion.

    They are 0 if inputs.given does not trust the field.
    """
    state, (order, dof) = rope.state, INPUTS[name]
    h, size, sample = max(state.last_interval, MIN_AIM_TIME), _SIZES[order], [0.0, 0.0, 0.0]
    sample[order] = size * (YAW_SENSE[side] if dof == ANGLE else 1.0)
    if dof == ANGLE and order == 1:  # a path takes its yaw acceleration from the rates
        sample[2] = sample[1] / max(h, MIN_MEAN_TIME)
    settings, ahead = settings_of(rope.scene), 0.0 if at_step_end else h
    explained = state.filters[side].explained[min(dof, 3)]
    change = np.array(
        lean_moves(h, ahead, size) if dof > ANGLE else sample_moves(settings, h, ahead, sample, explained)
    )
    # the rigid rope does not depend on yaw and leans, friction not on the yaw
    unfelt = dof >= ANGLE and state.fidelity == "rigid"
    unfelt |= dof == ANGLE and state.swivels[side].phase is Phase.SLIP
    unfelt |= dof > ANGLE and rope.ends.swivels[side].attachment != "clamped"
    if unfelt or not change.any():
        return np.zeros(12)
    derivative: Array = _change_of_loads(rope, side, dof, change) / size
    if not np.isfinite(derivative).all():
        raise ValueError(messages.no_finite_derivative())
    return derivative


def added_mass_signals(rope: Linearised) -> dict[str, float]:
    """Return the added masses of both ends."""
    # one step of that length carries the change y = a h^2 / 2, v = a h
    h, size = rope.state.last_interval, 1e-3
    change = np.array([0.5 * h * h * size, h * size, size])
    masses = (-float(_change_of_loads(rope, side, 1, change)[6 * side + 1]) / size for side in (0, 1))
    return {f"{side}.added_mass": mass for side, mass in zip(SIDES, masses, strict=True)}


def _change_of_loads(rope: Linearised, side: int, dof: int, change: Array) -> Array:
    """Return the change of LOADS (12,) if a coordinate of an end is moved as in ``answer``."""
    state = rope.state
    if state.fidelity == "rigid":  # no side forces, no moments
        change_of_loads = np.zeros((2, 6))
        change_of_loads[:, 1] = -tension_change(rope.scene, ends_at(state.paths, state.motion.t), side, dof, change)
        return change_of_loads.ravel()
    before, after = (_end_loads(rope.ends, *rope.answer(side, dof, fraction * change)) for fraction in (0.0, 1.0))
    return after - before


def _end_loads(ends: HangingEnds, q: Array, reaction: Array) -> Array:
    """Return LOADS (12,) for these coordinates and reactions."""
    nodes = enumerate(END_NODE)
    rows = ((q[node].tolist(), reaction[node].tolist(), ends.moment(side, q, reaction)) for side, node in nodes)
    return np.ravel([conveyance_load(*row) for row in rows])
