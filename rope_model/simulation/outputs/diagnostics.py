"""Shape of the rope for hoist engineers: lowest point, clearance and turns of the legs, tension along the rope."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rope_model.arrays import Array
from rope_model.physics import centreline
from rope_model.physics.hermite import integral, integral_to
from rope_model.physics.node import POSITION, SLOPE, arc_lengths
from rope_model.rules.generalized_alpha import Motion
from rope_model.rules.messages.result_warnings import ends_yaw
from rope_model.rules.sampling import FINE, OUTLINE, PIECES
from rope_model.simulation.mesh.transfer import interpolate


@dataclass(frozen=True)
class LoopBottom:
    """Lowest point of the rope: arc length from the left end, position (3,), m, and yaw of the tangent, rad.

    Yaw is 0 when the tangent points to +X, and positive towards -Z (about Y, up).
    """

    s: float
    position: Array
    yaw: float


def loop_bottom(q: Array, lengths: Array) -> LoopBottom:
    """Return the lowest point of the interpolated centre line."""
    s = arc_lengths(lengths)
    i = int(np.clip(np.argmin(q[:, 1]), 1, s.size - 2))
    fine = np.linspace(s[i - 1], s[i + 1], FINE)
    y = interpolate(q, s, fine)[:, 1]
    j = int(np.clip(np.argmin(y), 1, FINE - 2))
    bend = y[j - 1] - 2 * y[j] + y[j + 1]
    shift = 0.5 * (y[j - 1] - y[j + 1]) / bend if bend > 0 else 0.0
    s_lowest = fine[j] + min(max(shift, -1.0), 1.0) * (fine[1] - fine[0])
    point = interpolate(q, s, np.array([s_lowest]))[0]
    d = point[SLOPE]
    return LoopBottom(float(s_lowest), point[POSITION], math.atan2(-d[2], d[0]))


def leg_clearance(
    q: Array, lengths: Array, bottom: LoopBottom, loop: float, diameter: float, above: float
) -> float:
    """Return the smallest free distance (m) between the legs, from ``above`` (m) over the lowest point upwards.

    Points of each leg are compared with straight pieces of the other, both denser near the loop.
    """
    points = shape(q, lengths, bottom.s, loop, OUTLINE)
    middle = points.shape[0] // 2
    height = float(bottom.position[1]) + above
    left, right = _part_above(points[middle::-1], height), _part_above(points[middle:], height)
    if min(len(left), len(right)) < 2:
        return math.inf
    return min(_distance(left, right), _distance(right, left)) - diameter


def legs_apart(q: Array, lengths: Array, diameter: float, above: float) -> bool:
    """Return whether the legs are far from each other and turned by less than a quarter against the ends.

    This holds if each leg is nowhere higher than its end and on its own side of a plane through the lowest node, across
    the line from left to right, by a margin that keeps a ``diameter`` (m) between them ``above`` (m) or more over that
    node, and if the rope leads in that line's direction on both sides of it.  The plane leans as the legs do, so that
    it separates the legs of a swinging loop too.
    """
    k, rows, across = int(q[:, 1].argmin()), q.T, centreline.heading(ends_yaw(q))
    if not 0 < k < lengths.size:
        return False
    low, left = rows[:, k], np.arange(lengths.size) < k
    normal, a, b = centreline.plane_between(q[0], q[-1], low, across), rows[:, :-1], rows[:, 1:]
    ends = np.where(left, a, b), np.where(left, b, a), np.where(left, q[0, 1], q[-1, 1])
    gaps = centreline.side_gap(
        np.where(left, -1.0, 1.0), lengths, *ends, low, normal, diameter, above
    )
    advances = (
        centreline.least_advance(lengths[i], rows[:, i], rows[:, i + 1], across) for i in (k - 1, k)
    )
    return bool(gaps.min() >= 0 and min(advances) > 0)


class LoopTurns(NamedTuple):
    """Turns of one side of the rope about the other, and the height (m) around which they change most."""

    number: float
    sharpest_y: float


def loop_turns(q: Array, lengths: Array, bottom: LoopBottom) -> LoopTurns:
    """Return the turns about Y of the right side about the left one; down at the loop they end in its yaw.

    A side is a leg and, straight above it, the conveyance and its head ropes.  The turns are those of the horizontal
    vector between the sides over the height,

        1/(2 pi) int dpsi,    psi from the higher end down to the lowest point, where it is that of the tangent,

    between PIECES of each element, straight from one to the next.  Rope that hangs lower than rope below it is skipped.
    """
    nodes = arc_lengths(lengths)
    s = np.append(
        (nodes[:-1, None] + lengths[:, None] * np.arange(PIECES) / PIECES).ravel(), nodes[-1]
    )
    k, points = (
        int(np.clip(np.searchsorted(s, bottom.s), 1, s.size - 1)),
        interpolate(q, nodes, s)[:, POSITION],
    )
    legs = [
        _rising(np.vstack((bottom.position[None, :], leg)))
        for leg in (points[k - 1 :: -1], points[k:])
    ]
    heights = np.union1d(legs[0][:, 1], legs[1][:, 1])
    left, right = (
        np.array([np.interp(heights[1:], leg[:, 1], leg[:, k]) for k in (0, 2)]) for leg in legs
    )
    across = np.hstack((np.array(centreline.heading(bottom.yaw))[:, None], right - left))
    turned = centreline.angle_between(across[:, :-1], across[:, 1:])
    sharpest = int(np.argmax(np.abs(turned)))
    return LoopTurns(
        -float(np.sum(turned)) / (2 * math.pi),
        float(0.5 * (heights[sharpest] + heights[sharpest + 1])),
    )


def _rising(leg: Array) -> Array:
    """Return the points of a leg (points, 3), from the bottom upwards, that are higher than all before them."""
    return np.asarray(leg[np.append(True, leg[1:, 1] > np.maximum.accumulate(leg[:, 1])[:-1])])


def _distance(points: Array, line: Array) -> float:
    """Return the smallest distance of ``points`` (n, 3) from the pieces of a polygon ``line`` (m, 3)."""
    return math.sqrt(
        centreline.squared_distance(
            points.T[:, :, None], line[:-1].T[:, None], np.diff(line.T)[:, None]
        ).min()
    )


def _part_above(leg: Array, height: float) -> Array:
    """Return the points of a leg (points, 3), from the bottom upwards, from where it first reaches ``height``."""
    high = leg[:, 1] >= height
    if not high.any():
        return leg[:0]
    i = int(np.argmax(high))
    below, first = leg[max(i - 1, 0)], leg[i]
    rise = first[1] - below[1]
    fraction = (height - below[1]) / rise if rise > 0 else 1.0
    return np.vstack((below + fraction * (first - below), leg[i + (fraction >= 1.0) :]))


def shape_places(lengths: Array, bottom_s: float, loop: float, points: int) -> Array:
    """Return arc lengths (points,), m, from end to end, denser around the loop of this width (m) above ``bottom_s``."""
    total = float(np.sum(lengths))
    u = np.linspace(-1.0, 1.0, points)
    s = centreline.sample_s(bottom_s, np.where(u < 0, -bottom_s, total - bottom_s), np.abs(u), loop)
    return np.asarray(np.clip(s, 0.0, total))


def shape(q: Array, lengths: Array, bottom_s: float, loop: float, points: int) -> Array:
    """Return points (points, 3) of the centre line, denser around the loop's lowest point."""
    return interpolate(q, arc_lengths(lengths), shape_places(lengths, bottom_s, loop, points))[
        :, POSITION
    ]


def interpolate_midpoints(values: Array, lengths: Array, s: Array) -> Array:
    """Interpolate ``values`` (elements,) to arc lengths ``s``, linearly between the middles of the elements."""
    return np.interp(s, arc_lengths(lengths)[:-1] + 0.5 * lengths, values)


def tension(motion: Motion, lengths: Array, s: Array, rho: float, gravity: float) -> Array:
    """Return the tension (N) at arc lengths ``s``, from the balance of momentum of the rope to the left of them.

        F(s) = int_0^s rho (a + g Y) dx - reaction at the left end,    T = F . t

    It is exact for the discrete equations without air and contact: F arrives at the right end as its reaction.
    Costello's law with the strains is not, because Qa multiplies the cubic's error in the length of a bent element, 200
    N in the loop of rope-120.
    """
    nodes = arc_lengths(lengths)
    i = np.clip(np.searchsorted(nodes, s, side="right") - 1, 0, lengths.size - 1)
    left, right, l = motion.a[:-1], motion.a[1:], lengths[:, None]
    change = integral(l, left[:, POSITION], left[:, SLOPE], right[:, POSITION], right[:, SLOPE])
    before = np.concatenate((np.zeros((1, 3)), np.cumsum(change, axis=0)))[i]
    left, right, l = left[i], right[i], l[i]
    xi = (s - nodes[i])[:, None] / l
    within = integral_to(
        xi, l, left[:, POSITION], left[:, SLOPE], right[:, POSITION], right[:, SLOPE]
    )
    force = rho * (before + within) - motion.reaction[0, POSITION]
    force[:, 1] += rho * gravity * s
    d = interpolate(motion.q, nodes, s)[:, SLOPE]
    return np.asarray(np.sum(force * d, axis=1) / np.linalg.norm(d, axis=1))
