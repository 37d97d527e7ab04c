"""Passages of the rope's legs through each other.

Contact is no part of the published system: the legs of a rope that is twisted too far pass through
each other, or one of them through the conveyance and head ropes above the other's end.  The loop's
yaw, which is counted in time, then stays, and the turns of one leg about the other over the height
jump by one.  The rule is the engine's (csrc/monitoring/shaft.c).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from rope_model.arrays import Array
from rope_model.method.sampling import PIECES
from rope_model.physics.centreline import angle_between, heading, line_yaw, nearest_turn, turns
from rope_model.physics.elementary import nearest_whole
from rope_model.physics.hermite import interpolate
from rope_model.physics.node import POSITION, SLOPE
from rope_model.reference.equations import HEIGHT
from rope_model.reference.outputs import LowestPoint, lowest_point
from rope_model.reference.state import State

HORIZONTAL = (0, 2)  #: columns of X and Z


@dataclass(frozen=True)
class LoopTurns:
    """Turns of the right leg about the left one, from the lowest point up."""

    number: float
    sharpest_y: float  #: m, height at which the legs turn about each other most


def with_passages(state: State) -> State:
    """Return the state with the passages that have led to its shape."""
    crossing = state.crossing
    q = state.motion.q
    s = state.mesh.nodes_s
    lowest = lowest_point(q, s)
    over_height = loop_turns(q, s, lowest)
    yaw = nearest_turn(lowest.yaw, state.loop_yaw)
    net = float(nearest_whole(turns(yaw, line_yaw(q[0], q[-1]), over_height.number)))
    if net == crossing.net:
        return state
    if crossing.number == 0:
        crossing = crossing._replace(since=state.motion.t, y=over_height.sharpest_y)
    number = crossing.number + abs(net - crossing.net)
    return replace(state, crossing=crossing._replace(net=net, number=number))


def loop_turns(q: Array, s: Array, lowest: LowestPoint) -> LoopTurns:
    """Return the turns of the legs of the rope ``q`` (nodes, 7) with nodes at ``s`` (m).

    They are those of the line from leg to leg at equal height.  Where one leg has ended, that line
    begins at the vertical above its end.
    """
    points_s, points = _points(q, s)
    is_right = points_s >= lowest.s
    left = _climb(lowest.position, points[~is_right][::-1])
    right = _climb(lowest.position, points[is_right])
    heights = np.union1d(left[1:, HEIGHT], right[1:, HEIGHT])
    across = [
        np.interp(heights, right[:, HEIGHT], right[:, axis])
        - np.interp(heights, left[:, HEIGHT], left[:, axis])
        for axis in HORIZONTAL
    ]
    start = heading(lowest.yaw)
    lines = np.array([np.append(first, rest) for first, rest in zip(start, across, strict=True)])
    turned = np.asarray(angle_between(lines[:, :-1], lines[:, 1:]))
    sharpest = int(np.argmax(np.abs(turned)))
    below = np.append(lowest.position[HEIGHT], heights)[sharpest]
    return LoopTurns(
        number=-float(turned.sum()) / (2.0 * math.pi),
        sharpest_y=0.5 * float(below + heights[sharpest]),
    )


def _points(q: Array, s: Array) -> tuple[Array, Array]:
    """Return arc lengths (points,) and positions (points, 3) of PIECES places in each element."""
    l = np.diff(s)[:, None]
    one = q[:-1]
    other = q[1:]
    pieces = [
        interpolate(
            k / PIECES, l, one[:, POSITION], one[:, SLOPE], other[:, POSITION], other[:, SLOPE]
        )
        for k in range(PIECES)
    ]
    positions = np.stack([r for r, _ in pieces], axis=1).reshape(-1, 3)
    places = (s[:-1, None] + l * np.arange(PIECES) / PIECES).ravel()
    return np.append(places, s[-1]), np.vstack((positions, q[-1, POSITION]))


def _climb(lowest: Array, points: Array) -> Array:
    """Return the ``lowest`` point, and those of a leg that are higher than all before them."""
    way = np.vstack((lowest, points))
    highest = np.maximum.accumulate(way[:, HEIGHT])
    return np.asarray(way[np.append(True, way[1:, HEIGHT] > highest[:-1])])
