"""Guarded quantities of the present rope, for physics.guard."""

import numpy as np

from rope_model.arrays import Array
from rope_model.parameters import Scene
from rope_model.physics.centreline import nearest_turn, turns
from rope_model.physics.guard import has_guards, loop_height, off_plumb, sideways, watch
from rope_model.physics.node import POSITION
from rope_model.physics.shaft import KINDS
from rope_model.rules.end_paths import END_NODE
from rope_model.rules.messages.result_warnings import ends_yaw
from rope_model.rules.state import Nearest, RopeState
from rope_model.shaft_parameters import FAR
from rope_model.simulation.contact.shaft import nearer
from rope_model.simulation.ends.ends import HangingEnds
from rope_model.simulation.outputs.diagnostics import LoopBottom, loop_bottom


def rise(scene: Scene, state: RopeState, bottom: LoopBottom) -> float:
    """Return the height (m) of the loop's lowest point above its quasi-static position."""
    left, right = state.motion.q[[0, -1], 1].tolist()
    return float(
        loop_height(scene.rope, scene.layout, float(bottom.position[1]), left, right)
        - state.guard.rest
    )


def set_rise_reference(scene: Scene, state: RopeState) -> RopeState:
    """Return the state with its height as the reference of the loop's rise."""
    bottom = loop_bottom(state.motion.q, state.partition.lengths)
    return state._replace(guard=state.guard._replace(rest=rise(scene, state, bottom)))


def update_guards(scene: Scene, state: RopeState, ends: HangingEnds) -> RopeState:
    """Return the state with its guards updated to its instant."""
    guard = scene.shaft.guard
    if has_guards(guard) == 0:
        return state
    q, lengths = state.motion.q, state.partition.lengths
    bottom, known = loop_bottom(q, lengths), (Nearest(guard.clearance),) * len(KINDS)
    values = (
        rise(scene, state, bottom)
        if guard.rise_y <= -FAR
        else float(bottom.position[1]) - guard.rise_y,
        _sideways(q[:, POSITION], guard.window_y, bottom),
        min(nearest.clearance for nearest in nearer(scene, state, known)),
        abs(turns(nearest_turn(bottom.yaw, state.loop_yaw), ends_yaw(q), state.crossing.net)),
        max(abs(ends.moment(side, state.motion.q, state.motion.reaction)) for side in (0, 1)),
    )
    return state._replace(guard=watch(guard, state.guard, state.motion.t, values))


def _sideways(r: Array, height: float, bottom: LoopBottom) -> float:
    """Return the distance (m) of the lowest point from midway between the ends, or of a leg from plumb at a switch."""
    if height <= -FAR:
        return float(sideways(bottom.position, r[0], r[-1]))
    below, lowest = r[:, 1] < height, int(np.argmin(r[:, 1]))
    passing = np.flatnonzero(below[1:] != below[:-1])
    return max(
        (float(off_plumb(height, r[k], r[k + 1], r[END_NODE[int(k >= lowest)]])) for k in passing),
        default=0.0,
    )
