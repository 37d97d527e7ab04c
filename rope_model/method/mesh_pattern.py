"""Pattern of TMN-ETM: lengths of its segments and conditions of its transformations.

``counts`` are the elements of segments II to VI, lengths are in units of l.  A ``pattern`` has the
counts of all seven segments and l as ``coarse``, all 0 for EEM.
"""

import math
from typing import Annotated, Protocol, TypeAlias

from rope_model.method.mesh_fit import DUE
from rope_model.physics.elementary import (
    Scalar,
    Vector,
    floor,
    less,
    logical_or,
    maximum,
    minimum,
    where,
)
from rope_model.solver_parameters import INNER_SEGMENTS

#: m, distance before the limit at which a transformation is made, because of rounding
DUE_EARLY = 1e-7
# window of a leg that is refined where it faces a divider.  A blow that rises within four delays of
# mesh_fit.BLOW goes 4/pi l along the rope
WINDOW = 6  #: length in l
WINDOW_PARTS = 3  #: elements of each l
WINDOW_DUE = 1.6  #: distance (l) at which the window moves: more than half of that between two transformations


#: elements of segments II to VI
InnerCounts: TypeAlias = Annotated[Vector, int, len(INNER_SEGMENTS)]


class Pattern(Protocol):
    """Elements of the segments, l (m) as ``coarse``: a Partition, or its structure in C."""

    @property
    def counts(self) -> Vector: ...
    @property
    def coarse(self) -> Scalar: ...


def fine_share(counts: InnerCounts) -> Scalar:
    """Return the length of the elements of IV: half of their neighbours'."""
    return where(counts[0] > 0, 0.5, 1.0) * where(counts[1] > 0, 0.5, 1.0) * 0.5


def relative_lengths(counts: InnerCounts) -> tuple[Scalar, ...]:
    """Return the element lengths of segments II to VI."""
    return 0.5, 0.25, fine_share(counts), 0.25, 0.5


def inner_length(counts: InnerCounts) -> Scalar:
    """Return the length of segments II to VI."""
    ii, iii, iv, v, vi = counts
    return 0.5 * (ii + vi) + 0.25 * (iii + v) + fine_share(counts) * iv


def min_outer(counts: InnerCounts) -> Scalar:
    """Return the smallest number of elements of I or VII: below 1 by the whole l in half of segments II to VI."""
    return 1.0 - floor(0.5 * inner_length(counts))


def pattern_centre(pattern: Pattern) -> Scalar:
    """Return the arc length of the middle of segment IV, m."""
    return pattern.coarse * (pattern.counts[0] + 0.5 * inner_length(pattern.counts[1:6]))


def distance_past_limit(pattern: Pattern, bottom_s: Scalar) -> Scalar:
    """Return the distance (m) of the loop past the limit; negative if no transformation is due or possible."""
    return _past_limit(pattern, bottom_s - pattern_centre(pattern))


def window_place(pattern: Pattern, s: Scalar) -> Scalar:
    """Return the start, in l, of the window about arc length ``s`` (m) from the end, on the rope or just beyond."""
    beyond = pattern.counts[0] + pattern.counts[6] + inner_length(pattern.counts[1:6])
    return minimum(maximum(s / pattern.coarse - 0.5 * WINDOW, -float(WINDOW)), beyond)


def _past_limit(pattern: Pattern, offset: Scalar) -> Scalar:
    """Return the distance past the limit of a loop that is ``offset`` (m) right of the centre."""
    outer = where(offset > 0.0, pattern.counts[6], pattern.counts[0])
    stays = logical_or(pattern.coarse <= 0.0, outer == min_outer(pattern.counts[1:6]))
    return where(stays, -math.inf, abs(offset) - DUE * pattern.coarse)


def transformation_due(pattern: Pattern, bottom_s: Scalar, slack: Scalar = 0.0) -> Scalar:
    """Return +1 or -1 if the loop at arc length ``bottom_s`` is within ``slack`` (m) of a transformation.

    It is 0 otherwise, or if the mesh has reached its end in that direction.
    """
    offset = bottom_s - pattern_centre(pattern)
    return where(_past_limit(pattern, offset) < -slack, 0.0, less(0.0, offset) - less(offset, 0.0))


#: distance (l) beyond the limit of a transformation that a step carries the loop at most: 20 ms at
#: 20 m/s with l = 1.6 m
MAX_OVERSHOOT = 0.25
#: lengths (l) of elements of I or VII, each at a multiple of its length from the end of the rope,
#: so that its neighbours stay when it changes; csrc/mesh/partition.c halves them where elements are
#: to spare
LEG_LENGTHS = (2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64)
GRADING = 2  #: least distance of an element of m l from segments II to VI over (m - 1) l
