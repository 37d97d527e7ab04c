"""Partitions of the rope into elements: EEM and TMN-ETM.

EEM, the equal-length element mesh, is fixed on the rope: the baseline against which the other is checked.

TMN-ETM, time-varying multi-segment non-equal-length elements, has seven segments with element lengths

    I: l    II: l/2    III: l/4    IV: l/8    V: l/4    VI: l/2    VII: l

with IV around the loop's lowest point.  For every l that the loop travels along the rope a transformation moves the
pattern by l: segment I gains one element and VII loses one, or the reverse; the other counts stay.  Where the pattern
becomes coarser, elements merge; where it becomes finer, they split (see transfer).  Without III and V the elements of
IV are l/4 long, without II and VI too l/2: IV then covers less between transformations.  Near an end of the rope the
pattern continues beyond it.  The outermost l stays, with the loop's elements where they are shorter.  The part cut off
by the end, up to half of the pattern, halves the other leg's longest elements: the number of elements stays.

Two additions are ours.  The outermost element at each end is halved towards the end ``end_levels`` times and stays so:
the rope is clamped there with a vertical tangent, and the bending layer below the clamp, sqrt(EI / T) = 0.2 to 0.5 m
long, is shorter than l; unresolved, it leans the whole leg.  And in I and VII the pattern continues upwards with 2 l, 3
l, 4 l, 6 l ..., as far as the distances from end and loop allow: the tension grows with the distance x from the loop,
so waves of a swaying leg travel at sqrt(g x).  An element may be as long as sqrt(``grading_length`` x).  Their number
is the same for every position of the loop and grows with the root of the rope's length for a given ``grading_length``.

Where a leg faces a divider that may press it, WINDOW elements of l are divided into WINDOW_PARTS each.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from rope_model.arrays import Array
from rope_model.parameters import Scene
from rope_model.physics.elementary import nearest_whole
from rope_model.physics.node import arc_lengths
from rope_model.rules import mesh_pattern as tmn
from rope_model.rules.mesh_fit import FADE_ERROR, MESH_SHARE, divider_positions, fit_elements
from rope_model.rules.mesh_pattern import GRADING, LEG_LENGTHS, NO_DIVIDERS
from rope_model.rules.messages import messages
from rope_model.rules.partition import Partition
from rope_model.solver_parameters import MAX_ELEMENTS, Mesh


def fit_mesh(scene: Scene) -> Mesh:
    """Return the scene's mesh, or a fitted one if it is 'auto': see mesh_fit."""
    mesh = scene.mesh
    if mesh.kind != "auto":
        return mesh
    loop_error = mesh.loop_error or MESH_SHARE * scene.accuracy.loop
    fitted, mesh = (
        fit_elements(scene, loop_error, math.log10(FADE_ERROR / loop_error)),
        replace(mesh, loop_error=0.0),
    )
    if fitted.equal:
        return replace(mesh, kind="eem", elements=int(fitted.equal))
    return replace(
        mesh,
        kind="tmn",
        coarse_length=fitted.coarse,
        counts=(2, 0, int(fitted.fine), 0, 2),
        end_levels=int(fitted.end_levels),
        grading_length=fitted.grading,
    )


def mesh_dividers(scene: Scene, left: float, right: float) -> Sequence[float]:
    """Return mesh_fit.divider_positions for a fitted mesh, and NO_DIVIDERS for a prescribed one."""
    return divider_positions(scene, left, right) if scene.mesh.kind == "auto" else NO_DIVIDERS


def mesh_elements(scene: Scene) -> int:
    """Return the number of elements of the scene's rope; ValueError if the mesh does not fit it."""
    length = scene.rope.length
    return int(
        partition(
            fit_mesh(scene), length, 0.5 * length, mesh_dividers(scene, 0.0, 0.0)
        ).lengths.size
    )


def partition(
    mesh: Mesh, length: float, bottom_s: float, divider_s: Sequence[float] = NO_DIVIDERS
) -> Partition:
    """Return the partition of a rope of ``length``, its loop at ``bottom_s`` (m) and dividers where ``divider_s``."""
    if mesh.kind == "auto":
        raise ValueError(
            "mesh.kind = 'auto' needs the rope's data: fit the mesh first with fit_mesh(scene)"
        )
    if mesh.kind == "eem":
        return Partition(np.full(mesh.elements, length / mesh.elements))
    inner = float(tmn.inner_length(mesh.counts))
    outer = float(nearest_whole(length / mesh.coarse_length - inner))
    if outer > MAX_ELEMENTS:
        raise ValueError(messages.too_many_lengths(mesh.coarse_length, length, outer, MAX_ELEMENTS))
    if outer < 2:
        raise ValueError(messages.too_few_lengths(inner * mesh.coarse_length, length))
    coarse = length / (outer + inner)
    elements = (
        _leg_elements(int(outer), mesh.grading_length / coarse)
        + 2 * mesh.end_levels
        + sum(mesh.counts)
    )
    elements += tmn.WINDOW * (tmn.WINDOW_PARTS - 1) * int(np.isfinite(divider_s).sum())
    if elements > MAX_ELEMENTS:
        raise ValueError(messages.too_many_elements(elements, MAX_ELEMENTS))
    least = tmn.min_outer(mesh.counts)
    first = int(np.clip(nearest_whole(bottom_s / coarse - 0.5 * inner), least, outer - least))
    counts = (first, *mesh.counts, int(outer) - first)
    return _tmn(
        Partition(np.empty(elements), counts, coarse, mesh.end_levels, mesh.grading_length),
        divider_s,
    )


def transform(
    old: Partition, direction: float, divider_s: Sequence[float] = NO_DIVIDERS
) -> Partition:
    """Return the next partition: ``direction`` is +1 if the loop travels to the right, -1 to the left.

    The windows follow the dividers.
    """
    first, last = old.counts[0] + int(direction), old.counts[6] - int(direction)
    return _tmn(replace(old, counts=(first, *old.counts[1:6], last)), divider_s)


def window_due(pattern: Partition, divider_s: Sequence[float]) -> bool:
    """Return whether a window is so far from its divider that it moves without the loop."""
    return pattern.coarse > 0 and any(
        abs(tmn.window_place(pattern, s) - window) > tmn.WINDOW_DUE
        for s, window in {
            *zip(divider_s, pattern.windows, strict=True)
        }  # the set is mostly one pair
    )


def _tmn(pattern: Partition, divider_s: Sequence[float]) -> Partition:
    """Return ``pattern`` with its windows where dividers are ``divider_s``, and with the lengths of its elements."""
    counts, coarse, levels = pattern.counts, pattern.coarse, pattern.end_levels
    inner = np.repeat(tmn.relative_lengths(counts[1:6]), counts[1:6])
    first, last = max(counts[0], 1), max(counts[6], 1)
    # lengths of II to VI within the ends of the rope
    within = np.diff(
        np.clip(arc_lengths(inner), first - counts[0], np.sum(inner) - (last - counts[6]))
    )
    inner_lengths = within[within > 0.0]
    growth, fine = pattern.grading_length / coarse, tmn.fine_share(counts[1:6])
    # the loop bends the rope up to its end where the pattern is cut off
    for longest in (fine, 1.0):
        ends = [_end(levels, longest if n < 1 else 1.0) for n in counts[::6]]
        elements = pattern.lengths.size - inner_lengths.size - sum(end.size - 1 for end in ends)
        if elements >= len(_leg(first, growth)) + len(_leg(last, growth)):
            break
    windows = tuple(int(nearest_whole(tmn.window_place(pattern, s))) for s in divider_s)
    left, right = _legs(first, last, elements, growth, windows)
    lengths = np.concatenate((ends[0], left[1:], inner_lengths, right[:0:-1], ends[1][::-1]))
    return replace(pattern, lengths=coarse * lengths, windows=windows)


def _end(levels: int, longest: float) -> Array:
    """Return the elements of the outermost l, in l, from the end on: halves of halves, none above ``longest``."""
    sizes = [0.5**levels, *(0.5**k for k in range(levels, 0, -1))]
    return np.concatenate(
        [np.full(int(max(size / longest, 1.0)), min(size, longest)) for size in sizes]
    )


def _leg(units: int, growth: float) -> list[float]:
    """Return the elements of a leg of ``units`` l, in units of l as ``growth``, from the end of the rope on."""
    lengths: list[float] = []
    position = 0
    while position < units:
        size = 1
        for longer in LEG_LENGTHS if growth > 0 else ():
            gap = units - (position + longer)
            if longer > position or gap < GRADING * (longer - 1) or gap * growth < longer**2:
                break
            if position % longer == 0:
                size = longer
        lengths.append(size)
        position += size
    return lengths


@lru_cache
def _leg_elements(units: int, growth: float) -> int:
    """Return the number of elements of both legs, of ``units`` l: the largest over all positions of the loop."""
    if growth == 0:
        return units
    counts = [0, *(len(_leg(k, growth)) for k in range(1, units))]
    return max(counts[k] + counts[units - k] for k in range(1, units))


def _legs(
    first: int, last: int, elements: int, growth: float, windows: tuple[int, ...]
) -> tuple[list[float], list[float]]:
    """Return both legs from their ends on, with so many ``elements``: spare ones refine all but the outermost.

    They refine the windows first, then the longest elements.
    """
    both = _leg(first, growth), _leg(last, growth)
    spare = elements - len(both[0]) - len(both[1])
    for side, leg in enumerate(both):
        for k in range(len(leg) - 1, 0, -1):
            if spare >= tmn.WINDOW_PARTS - 1 and any(
                0 <= k - window < tmn.WINDOW for window in windows[side::2]
            ):
                leg[k : k + 1] = [leg[k] / tmn.WINDOW_PARTS] * tmn.WINDOW_PARTS
                spare -= tmn.WINDOW_PARTS - 1
    for _ in range(spare):
        leg = max(both, key=lambda leg: max(leg[1:], default=0.0))
        k = len(leg) - 1 - leg[::-1].index(max(leg[1:]))  # the longest element nearest the loop
        leg[k : k + 1] = [0.5 * leg[k]] * 2
    return both
