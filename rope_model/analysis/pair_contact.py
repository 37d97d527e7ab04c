"""Contact detection and law between two ropes, at all points at once: physics.rope_contact.

Points stand along the first rope, evenly, whatever its mesh: a point keeps its number from step to
step.  Each is compared with the nearest point of each strand of the other rope.  Bounding boxes
give the candidate elements.
"""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from rope_model.arrays import Array
from rope_model.boundary.point_forces import at_places, elements_at
from rope_model.interface import BalanceRope
from rope_model.parameters import Scene
from rope_model.physics import hermite, rope_contact
from rope_model.physics.centreline import enclosing_box

#: number of points in a group, which is first checked by its middle
POINTS_IN_GROUP = 16

Numbers = np.ndarray[Any, np.dtype[np.int64]]


class Rows(NamedTuple):
    """Nodes of a rope: arc lengths, r and r' in the shaft (nodes, 6), their rates; lengths and boxes of its elements.

    Boxes (6, elements) have centre and half widths.
    """

    s: Array
    q: Array
    v: Array
    lengths: Array
    boxes: Array

    def positions(self, s: Array) -> Array:
        """Return the positions (n, 3) at arc lengths."""
        return at_places(self.q, *elements_at(s, self.lengths))

    def velocities(self, s: Array) -> Array:
        """Return the velocities (n, 3) at arc lengths."""
        return at_places(self.v, *elements_at(s, self.lengths))


def rows_of(rope: BalanceRope, origin: Array) -> Rows:
    """Return the nodes of a rope whose coordinates count from ``origin`` (3,)."""
    s, q, v = np.split(rope.rows(), (1, 7), axis=1)
    q[:, :3] += origin
    lengths = np.diff(s[:, 0])
    return Rows(s[:, 0], q, v, lengths, np.array(enclosing_box(lengths, q[:-1].T, q[1:].T)))


class PairContact(NamedTuple):
    """Points of two ropes that press each other, in ascending order of their numbers."""

    point_id: Numbers  # (m,)
    s: Array  # (2, m), m, arc lengths on both ropes
    force: Array  # (m, 3), N, on the first rope
    spring: Array  # (m, 3), N, part of the force that stores energy
    tangent: Array  # (m, 3, 3), N/m
    pressure: Array  # (m,), N
    energy: float  # J
    position: Array  # (m, 3), m


_NO = np.zeros((0, 3))
NO_CONTACTS = PairContact(
    np.zeros(0, np.int64), _NO.T[:2], _NO, _NO, np.zeros((0, 3, 3)), np.zeros(0), 0.0, _NO
)


class _NearElements(NamedTuple):
    """Pairs of elements that may touch."""

    mine: Numbers  # (n,), of the first rope
    theirs: Numbers  # (n,), of the other


class _NearPoints(NamedTuple):
    """Points of the first rope, each with the nearest point on one element of the other."""

    number: Numbers  # (m,), of the point along the first rope
    s: Array  # (m,), m
    their_s: Array  # (m,), m, on the other rope
    distance: Array  # (m,), m


class _TouchingPoints(NamedTuple):
    """Pairs of points in contact."""

    number: Numbers  # (m,), of the point along the first rope and of the strand of the other
    s: Array  # (2, m), m, on both ropes


class _Extent(NamedTuple):
    """Box that encloses a whole rope."""

    low: Array  # (3,), m
    high: Array  # (3,), m


def _extent_of(rope: Rows) -> _Extent:
    """Return the box around the boxes of the elements."""
    middle = rope.boxes[:3]
    half = rope.boxes[3:]
    return _Extent((middle - half).min(axis=1), (middle + half).max(axis=1))


class Pair:
    """Two ropes that may touch."""

    def __init__(self, one: Scene, other: Scene) -> None:
        self._law = one.shaft.contact
        self._lossless = replace(self._law, damping=0.0, friction=0.0)
        self.diameter = 0.5 * (one.rope.diameter + other.rope.diameter)
        self._spacing = one.rope.length / math.ceil(
            one.rope.length / (rope_contact.SPACING * self.diameter)
        )

    def find_contacts(self, one: Rows, other: Rows, c: Array, inset: float = 0.0) -> PairContact:
        """Return the points in contact, with the tangent with respect to (c[0], c[1]) times positions and velocities.

        The ropes are taken to be thinner by ``inset`` (m).
        """
        near = self._near(one, other)
        if not near.mine.size:
            return NO_CONTACTS
        diameter = self.diameter - inset
        touching = self._touching(self._nearest(one, other, near), diameter)
        if touching.number.size:
            return self._law_at(touching, one, other, c, diameter)
        return NO_CONTACTS

    def inset(self, one: Rows, other: Rows) -> float:
        """Return the largest penetration depth (m)."""
        near = self._near(one, other)
        if not near.mine.size:
            return 0.0
        distance = self._nearest(one, other, near).distance
        return max(self.diameter - float(distance.min(initial=self.diameter)), 0.0)

    def _near(self, one: Rows, other: Rows) -> _NearElements:
        """Return pairs of elements that may touch (broad phase)."""
        extent = _extent_of(one)
        their_extent = _extent_of(other)
        apart = (extent.low - their_extent.high >= self.diameter).any()
        apart |= (their_extent.low - extent.high >= self.diameter).any()
        if apart:
            return _NearElements(NO_CONTACTS.point_id, NO_CONTACTS.point_id)
        mine = one.boxes[:, :, None]
        theirs = other.boxes[:, None]
        gaps = np.abs(mine[:3] - theirs[:3]) - (mine[3:] + theirs[3:])
        pairs = np.nonzero((gaps < self.diameter).all(axis=0))
        return _NearElements(pairs[0], pairs[1])

    def _nearest(self, one: Rows, other: Rows, near_elements: _NearElements) -> _NearPoints:
        """Return points on near elements of ``one``, each with the nearest point of an element of ``other``."""
        mine = near_elements.mine
        theirs = near_elements.theirs
        # numbers of the points on each of my elements, in groups; far groups are left out by their
        # middles
        first = np.ceil(one.s / self._spacing - 0.5).astype(np.int64)
        groups, start = _expanded(-(-np.diff(first)[mine] // POINTS_IN_GROUP))
        start = first[mine[groups]] + POINTS_IN_GROUP * start
        stop = np.minimum(start + POINTS_IN_GROUP, first[mine[groups] + 1])
        middle: Any = 0.5 * (start + stop) * self._spacing
        theirs = theirs[groups]
        ends = _ends(other, theirs)
        l = other.lengths[theirs]
        probed = rope_contact.PROBES[1] - rope_contact.PROBES[0]
        reach = self.diameter + rope_contact.STRETCH * (
            POINTS_IN_GROUP * self._spacing + 0.5 * probed * l
        )
        near = _probed(ends, l, one.positions(middle)).min(axis=0) < reach
        groups, number = _expanded((stop - start)[near])
        number = start[near][groups] + number
        theirs = theirs[near][groups]
        s: Any = (number + 0.5) * self._spacing
        their_s, distance = _projected(other, theirs, one.positions(s))
        return _NearPoints(number, s, their_s, distance)

    def _touching(self, near: _NearPoints, diameter: float) -> _TouchingPoints:
        """Return the pairs in contact among the near ones, once for each strand, numbered along the other rope."""
        number = near.number
        their_s = near.their_s
        distance = near.distance
        order = np.lexsort((their_s, distance, number))
        order = order[distance[order] < diameter]
        _, begin, counts = np.unique(number[order], return_index=True, return_counts=True)
        alone = (
            np.abs(their_s[order] - their_s[order[begin]].repeat(counts))
            < rope_contact.MIN_ARC * self.diameter
        )
        parts = [(order[begin], 0 * begin)]
        for k in begin[~np.logical_and.reduceat(alone, begin)] if begin.size else ():
            here = order[number[order] == number[order[k]]]
            chosen = here[
                rope_contact.strands(their_s[here].tolist(), rope_contact.MIN_ARC * self.diameter)
            ]
            ranks = np.argsort(np.argsort(their_s[chosen]))
            parts[0][1][parts[0][0] == chosen[0]] = ranks[0]
            parts.append((chosen[1:], ranks[1:]))
        touching, rank = (np.concatenate(x) for x in zip(*parts, strict=True))
        label = number[touching] * rope_contact.MAX_STRANDS + rank
        touching = touching[np.argsort(label)]
        s = np.array((near.s[touching], their_s[touching]))
        return _TouchingPoints(np.sort(label), s)

    def _law_at(
        self, touching: _TouchingPoints, one: Rows, other: Rows, c: Array, diameter: float
    ) -> PairContact:
        number = touching.number
        s = touching.s
        r = one.positions(s[0])
        their_r = other.positions(s[1])
        separation = (r - their_r).T
        velocity = (one.velocities(s[0]) - other.velocities(s[1])).T
        law = rope_contact.self_contact_law(
            self._law, diameter, separation, velocity, float(c[0]), float(c[1])
        )
        spring = rope_contact.self_contact_law(
            self._lossless, diameter, separation, velocity, 1.0, 0.0
        )
        entries = np.array([np.broadcast_to(x, number.shape) for x in law.tangent]).T[
            :, rope_contact.TANGENT_ENTRIES
        ]
        tangent = self._spacing * entries
        pressure = self._spacing * np.asarray(law.sums[-1])
        energy = float(np.sum(law.sums[0]) * self._spacing)
        force, spring_force = (self._spacing * np.array(x.force).T for x in (law, spring))
        return PairContact(
            number, s, force, spring_force, tangent, pressure, energy, 0.5 * (r + their_r)
        )


def _expanded(counts: Numbers) -> tuple[Numbers, Numbers]:
    """Return, for each thing counted, the index of its count and its number within it."""
    owner = np.arange(counts.size).repeat(counts)
    return owner, np.arange(owner.size) - (np.cumsum(counts) - counts).repeat(counts)


def _projected(rope: Rows, elements: Numbers, points: Array) -> tuple[Array, Array]:
    """Return s of the points of elements that are nearest to ``points`` (m, 3), and their distances (m)."""
    l = rope.lengths[elements]
    ends = _ends(rope, elements)
    xi = np.array(rope_contact.PROBES)[_probed(ends, l, points).argmin(axis=0)]
    rows = np.ascontiguousarray(ends.reshape(-1, 12).T)
    for _ in range(rope_contact.CORRECTIONS):
        xi = rope_contact.nearer_xi(xi, l, points.T, rows[:6], rows[6:])
    return rope.s[elements] + xi * l, _distances(ends, l, points, xi)


def _ends(rope: Rows, elements: Numbers) -> Array:
    """Return r, r' at both nodes of elements (m, 4, 3)."""
    return np.concatenate((rope.q[elements], rope.q[elements + 1]), axis=1).reshape(-1, 4, 3)


def _probed(ends: Array, l: Array, points: Array) -> Array:
    """Return the distances (probes, m) of points from the PROBES of elements."""
    return np.array(
        [_distances(ends, l, points, np.full(l.size, xi)) for xi in rope_contact.PROBES]
    )


def _distances(ends: Array, l: Array, points: Array, xi: Array) -> Array:
    """Return the distances (m,) of points from the points ``xi`` of elements with these ``ends``, m."""
    N = np.array(hermite.shape_functions(xi, l))
    return np.asarray(np.linalg.norm(np.einsum("kn,nki->ni", N, ends) - points, axis=1))
