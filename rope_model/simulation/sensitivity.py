"""Derivatives of the end loads at the end of a step to one number of an end's motion there.

The rope is linearised about the present state, and one generalized-alpha step as long as the last carries the change;
rope_derivative in rope_model.native is its C port.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ..physics.frame import conveyance_load
from . import messages
from .ends import YAW_SENSE, Phase
from .paths import SIDES, EndMotion, ends_at
from .rigid import tension_change
from .rope_system import ANGLE, Array
from .simulator import RopeSimulator

#: m, m/s, m/s^2, and the same in rad: small against what bends the rope, large against rounding
_SIZES = (1e-7, 1e-5, 1e-3)
#: names of the signals that are differentiated
LOADS = tuple(f"{side}.{kind}{axis}" for side in SIDES for kind in "fm" for axis in "xyz")
_NAMES = tuple(field.name for field in dataclasses.fields(EndMotion))


def load_derivative(rope: RopeSimulator, side: int, name: str) -> Array:
    """(12,): of LOADS to the field ``name`` of an end's EndMotion."""
    state, place = rope.state, _NAMES.index(name)
    kind, dof = divmod(place, 3) if place < 9 else (place - 9, ANGLE)
    size = _SIZES[kind]
    if state.fidelity == "rigid":
        # no side forces, no moments
        out, ends = np.zeros((2, 6)), ends_at(state.paths, state.motion.t)
        out[:, 1] = -tension_change(rope.scene, ends, side, {name: size}) / size
        return out.ravel()
    if dof == ANGLE and state.swivels[side].phase is Phase.SLIP:
        return np.zeros(12)  # the friction does not know the yaw
    change = np.zeros(3)
    change[kind] = size * (YAW_SENSE[side] if dof == ANGLE else 1.0)
    if dof == ANGLE and kind == 1:  # a path takes its yaw acceleration from the rates
        change[2] = change[1] / state.last_interval
    before, after = (end_loads(rope, *rope.answer(side, dof, part * change)) for part in (0.0, 1.0))
    derivative: Array = (after - before) / size
    if not np.isfinite(derivative).all():
        raise ValueError(messages.no_finite_derivative())
    return derivative


def end_loads(rope: RopeSimulator, q: Array, reaction: Array) -> Array:
    """(12,): LOADS with other coordinates and reactions."""
    rows = ((q[-side].tolist(), reaction[-side].tolist(), rope.ends.moment(side, reaction)) for side in (0, 1))
    return np.ravel([conveyance_load(*row) for row in rows])
