"""Clearances of the rope from the bodies of its scene, and passages of the rope through itself.

The clearance from a kind of bodies is the least distance of the rope's surface from them, over the whole centre line.
A piece of an element is halved as long as the upright box about it is nearer to the body than the nearest known point,
by RESOLUTION or more.  A straight leg along a wall fills no such box, so it costs no more than its nodes.  For a
conveyance and its head ropes only the other leg counts, from the lowest node on: the rope's own end hangs below them.

The rope overlaps itself where contact would press it, or presses it (self_contact).  The legs pass through each other,
or one of them through conveyance or head ropes above the other's end, if the turns over the height
(diagnostics.loop_turns) jump by one, while the loop's yaw, which is counted in time, does not.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from rope_model.parameters import Scene
from rope_model.physics.centreline import enclosing_box, middle, nearest_turn, turns
from rope_model.physics.elementary import nearest_whole
from rope_model.physics.node import SLOPE
from rope_model.physics.shaft import distance, least_distance
from rope_model.rules.bodies import RESOLUTION, TURNED_FAR, Placed, placed_bodies
from rope_model.rules.messages.result_warnings import ends_yaw
from rope_model.rules.state import NOT_NEAR, Crossing, Nearest, RopeState
from rope_model.simulation.contact.self_contact import overlap_of
from rope_model.simulation.outputs.diagnostics import legs_apart, loop_bottom, loop_turns


class _Search:
    """Search for the point of the rope, from one node to another, that is nearest to a body."""

    def __init__(
        self, placed: Placed, nodes: tuple[int, int], radius: float, t: float, known: Nearest
    ) -> None:
        self.kind, self._body, self.nearest = placed.kind, placed.body, known
        self.first, self.last = nodes
        self._radius, self._t = radius, t

    def may_improve(self, box: Any) -> Any:
        """Return whether the contents of this box, or of each of several, may be nearer than the nearest point."""
        return (
            least_distance(box[:3], box[3:], self._body) - self._radius
            < self.nearest.clearance - RESOLUTION
        )

    def compare(self, s: float, point: Any) -> None:
        """Compare the point at arc length ``s`` with the nearest so far."""
        clearance = distance(point, self._body) - self._radius
        if clearance < self.nearest.clearance:
            touched_at = (
                self._t if clearance <= 0 < self.nearest.clearance else self.nearest.touched_at
            )
            self.nearest = Nearest(clearance, self._t, s, point[1], touched_at)

    def refine(self, s: float, length: float, a: Any, b: Any) -> None:
        """Search the piece of this length from ``s`` on, between points ``a`` and ``b`` with their slopes."""
        if not self.may_improve(enclosing_box(length, a, b)):
            return
        half, middle_point = 0.5 * length, middle(length, a, b)
        self.compare(s + half, middle_point)
        self.refine(s, half, a, middle_point)
        self.refine(s + half, half, middle_point, b)


def _searches_of(scene: Scene, state: RopeState, known: Sequence[Nearest]) -> list[_Search]:
    """Return one search for each body, starting from the known clearances."""
    q, t, last = state.motion.q, state.motion.t, state.partition.lengths.size
    bodies = [*placed_bodies(scene.shaft, (q[0].tolist(), q[-1].tolist()))]
    lowest = int(q[:, 1].argmin()) if bodies else 0
    parts = (0, last), (lowest, last), (0, lowest)
    return [
        _Search(
            placed, parts[placed.moves_with + 1], 0.5 * scene.rope.diameter, t, known[placed.kind]
        )
        for placed in bodies
    ]


def _nearest_of(searches: Sequence[_Search], known: Sequence[Nearest]) -> tuple[Nearest, ...]:
    nearest = list(known)
    for search in searches:
        if search.nearest.clearance < nearest[search.kind].clearance:
            nearest[search.kind] = search.nearest
    return tuple(nearest)


def nearer(scene: Scene, state: RopeState, known: tuple[Nearest, ...]) -> tuple[Nearest, ...]:
    """Return the nearest point of the present rope to each kind of bodies, or the ``known`` one if that is nearer."""
    if not (searches := _searches_of(scene, state, known)):
        return known
    lengths, s, rows = (
        state.partition.lengths,
        state.partition.nodes_s.tolist(),
        state.motion.q[:, : SLOPE.stop],
    )
    box = np.array(enclosing_box(lengths, rows[:-1].T, rows[1:].T))
    for search in searches:
        part = slice(search.first, search.last)
        for k in (np.flatnonzero(search.may_improve(box[:, part])) + search.first).tolist():
            if search.may_improve(box[:, k].tolist()):
                a, b = rows[k].tolist(), rows[k + 1].tolist()
                search.compare(s[k], a)
                search.compare(s[k + 1], b)
                search.refine(s[k], float(lengths[k]), a, b)
    return _nearest_of(searches, known)


def clearances(scene: Scene, state: RopeState) -> tuple[Nearest, ...]:
    """Return the nearest point of the present rope to each kind of bodies."""
    searches, s = _searches_of(scene, state, NOT_NEAR), state.partition.nodes_s.tolist()
    for search in searches:
        for k in range(search.first, search.last + 1):
            search.compare(s[k], state.motion.q[k, : SLOPE.stop].tolist())
    return nearer(scene, state, _nearest_of(searches, NOT_NEAR))


def _with_overlap(scene: Scene, state: RopeState) -> Crossing:
    """Return the crossing with the rope's present depth in itself, if it is the largest so far."""
    crossing = state.crossing
    overlap, y = overlap_of(state.motion.q, state.partition.lengths, scene.rope.diameter)
    if not overlap > crossing.overlap:
        return crossing
    touched_at = crossing.touched_at if crossing.overlap > 0 else state.motion.t
    return crossing._replace(overlap=overlap, touched_at=touched_at, touched_y=y)


def update_passages(scene: Scene, state: RopeState) -> RopeState:
    """Return the state with the clearances and passages of its instant.

    It is called at the end of every communication step, and after MONITOR_INTERVAL in longer ones.
    """
    q, lengths, t = state.motion.q, state.partition.lengths, state.motion.t
    near = not legs_apart(q, lengths, scene.rope.diameter, scene.layout.spacing)
    crossing = (
        _with_overlap(scene, state)
        if near or scene.shaft.contact.rope_stiffness > 0
        else state.crossing
    )
    if near or crossing.net != 0 or abs(state.loop_yaw - ends_yaw(q)) > TURNED_FAR:
        bottom = loop_bottom(q, lengths)
        sides, yaw = loop_turns(q, lengths, bottom), nearest_turn(bottom.yaw, state.loop_yaw)
        net = float(nearest_whole(turns(yaw, ends_yaw(q), sides.number)))
        if net != crossing.net:
            since, y = (crossing.since, crossing.y) if crossing.number else (t, sides.sharpest_y)
            crossing = crossing._replace(
                net=net, number=crossing.number + abs(net - crossing.net), since=since, y=y
            )
    return state._replace(
        nearest=nearer(scene, state, state.nearest), crossing=crossing, monitored_at=t
    )
