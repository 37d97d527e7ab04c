"""Meshes of the rope: EEM and TMN-ETM (docs/theory/mesh.md).

EEM has elements of equal length.  TMN-ETM, time-varying multi-segment non-equal-length elements,
has seven segments

    I: l    II: l/2    III: l/4    IV: l/8    V: l/4    VI: l/2    VII: l    (eq-ladder)

with IV around the loop's lowest point.  For every l that the loop travels along the rope a
transformation moves the pattern by l: segment I gains one element and VII loses one, or the
reverse.  The nodes of a pattern are fixed in the rope: where it becomes coarser elements merge,
where it becomes finer they split.

Two refinements are added to the source's mesh.  The outermost elements are halved towards the
clamped ends, and elements of I and VII at the distance y from the loop may be as long as sqrt(l_g
y) (eq-grading).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from rope_model.arrays import Array
from rope_model.messages import messages
from rope_model.method.mesh_fit import COVER_ERROR, MESH_SHARE, fit_elements
from rope_model.method.mesh_pattern import (
    DUE_EARLY,
    GRADING,
    LEG_LENGTHS,
    inner_length,
    min_outer,
    relative_lengths,
    transformation_due,
)
from rope_model.parameters import Scene
from rope_model.physics.elementary import nearest_whole
from rope_model.physics.node import arc_lengths
from rope_model.solver_parameters import Mesh

SAME_NODE = 1e-9  #: distance (l) below which two nodes are one
PATTERN = (
    "coarse",
    "counts",
    "end_levels",
    "grading_length",
)  #: fields of a RopeMesh but its lengths
EQUAL_WITHIN = 1e-12  #: share of the rope's length by which equal element lengths may differ


@dataclass(frozen=True)
class RopeMesh:
    """Partition of the rope; for TMN-ETM also its pattern."""

    lengths: Array  #: of the elements from left to right (elements,), m
    coarse: float = 0.0  #: m, l; 0 for EEM
    counts: tuple[int, ...] = (0,) * 7  #: of l in I, elements in II to VI, l in VII; 0 for EEM
    end_levels: int = 0  #: how often the outermost elements are halved
    grading_length: float = 0.0  #: m, l_g; 0: elements of I and VII are l long

    @property
    def nodes_s(self) -> Array:
        """Arc lengths of the nodes from the left end (nodes,), m."""
        return arc_lengths(self.lengths)


def fitted(scene: Scene) -> Mesh:
    """Return the mesh that the scene asks for; 'auto' is fitted to the rope (eq-bend)."""
    given = scene.mesh
    if given.kind != "auto":
        return given
    loop_error = given.loop_error or MESH_SHARE * scene.accuracy.loop
    lengths = fit_elements(scene, loop_error, math.log10(COVER_ERROR / loop_error))
    if lengths.equal:
        return Mesh(kind="eem", elements=int(lengths.equal))
    return Mesh(
        kind="tmn",
        coarse_length=lengths.coarse,
        counts=(2, 0, int(lengths.fine), 0, 2),
        end_levels=int(lengths.end_levels),
        grading_length=lengths.grading,
    )


def mesh_of(scene: Scene, bottom_s: float) -> RopeMesh:
    """Return the mesh of a rope whose lowest point is at arc length ``bottom_s`` (m)."""
    given = fitted(scene)
    length = scene.rope.length
    if given.kind == "eem":
        return RopeMesh(np.full(given.elements, length / given.elements))
    inner = float(inner_length(given.counts))  # l
    outer = int(nearest_whole(length / given.coarse_length - inner))  # l, of I and VII
    if outer < 2:
        raise ValueError(messages.too_few_lengths(inner * given.coarse_length, length))
    coarse = length / (outer + inner)
    min_elements = int(min_outer(given.counts))
    first = int(nearest_whole(bottom_s / coarse - 0.5 * inner))
    first = min(max(first, min_elements), outer - min_elements)
    counts = (first, *given.counts, outer - first)
    pattern = RopeMesh(np.empty(0), coarse, counts, given.end_levels, given.grading_length)
    return with_lengths(pattern)


def with_lengths(pattern: RopeMesh) -> RopeMesh:
    """Return the pattern of TMN-ETM with the lengths of its elements."""
    return replace(pattern, lengths=pattern.coarse * np.diff(_nodes(pattern)))


def require_mesh_of(scene: Scene, mesh: RopeMesh) -> None:
    """Raise ValueError unless ``mesh`` is one of the scene, with its pattern at any place."""
    expected = mesh_of(scene, 0.5 * scene.rope.length)
    fits = True
    if expected.coarse > 0:
        first = mesh.counts[0]
        outer = expected.counts[0] + expected.counts[-1]
        least = int(min_outer(expected.counts[1:6]))
        fits = least <= first <= outer - least
        expected = replace(expected, counts=(first, *expected.counts[1:6], outer - first))
        if fits:
            expected = with_lengths(expected)
    fits = (
        fits
        and all(getattr(mesh, name) == getattr(expected, name) for name in PATTERN)
        and mesh.lengths.shape == expected.lengths.shape
        and bool(np.all(abs(mesh.lengths - expected.lengths) <= EQUAL_WITHIN * scene.rope.length))
    )
    if not fits:
        raise ValueError(
            f"the state's mesh of {mesh.lengths.size} elements on {mesh.lengths.sum():g} m must be "
            f"that of the scene, {expected.lengths.size} elements on {scene.rope.length:g} m: "
            "restore it into a rope with the same mesh"
        )


def transformed(mesh: RopeMesh, bottom_s: float) -> RopeMesh:
    """Return the mesh for a loop at ``bottom_s`` (m): ``mesh`` itself where it still serves."""
    while direction := int(transformation_due(mesh, bottom_s, DUE_EARLY)):
        counts = (mesh.counts[0] + direction, *mesh.counts[1:6], mesh.counts[6] - direction)
        mesh = with_lengths(replace(mesh, counts=counts))
    return mesh


def _nodes(pattern: RopeMesh) -> Array:
    """Return the arc lengths (l) of the nodes of TMN-ETM.

    Near an end of the rope the pattern continues beyond it, and the end cuts it off.
    """
    first = pattern.counts[0]
    last = pattern.counts[6]
    ladder = np.repeat(relative_lengths(pattern.counts[1:6]), pattern.counts[1:6])
    inner = first + arc_lengths(ladder)
    total = inner[-1] + last
    growth = pattern.grading_length / pattern.coarse
    left = _leg_nodes(max(first, 1), growth, pattern.end_levels)
    right = total - _leg_nodes(max(last, 1), growth, pattern.end_levels)
    nodes = np.sort(np.concatenate((left, inner, right)))
    nodes = nodes[(nodes > -SAME_NODE) & (nodes < total + SAME_NODE)]
    return np.asarray(nodes[np.append(True, np.diff(nodes) > SAME_NODE)])


def _leg_nodes(units: int, growth: float, end_levels: int) -> Array:
    """Return the distances (l) of the nodes of I or VII, ``units`` l long, from the rope's end."""
    nodes = [0.0, *(0.5**k for k in range(end_levels, 0, -1)), 1.0]
    position = 1
    while position < units:
        longer = (size for size in LEG_LENGTHS if _may_be(size, position, units, growth))
        position += max(longer, default=1)
        nodes.append(float(position))
    return np.array(nodes)


def _may_be(size: int, position: int, units: int, growth: float) -> bool:
    """Return whether an element may have ``size`` (l) at the ``position`` (l) from the end."""
    to_loop = units - (position + size)
    return (
        position % size == 0
        and size <= position
        and to_loop >= GRADING * (size - 1)
        and size * size <= growth * to_loop
    )
