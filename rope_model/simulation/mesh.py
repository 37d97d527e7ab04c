"""Partitions of the rope into elements.

EEM, the equal-length element mesh, is fixed on the rope: the baseline that proves the other right.

TMN-ETM, time-varying multi-segment non-equal-length elements, has seven segments with element lengths

    I: l    II: l/2    III: l/4    IV: l/8    V: l/4    VI: l/2    VII: l

IV around the loop's lowest point.  When the loop has travelled l along the rope a transformation moves the pattern
by l: segment I gains one element and VII loses one, or the reverse; the other counts stay.  Where the pattern gets
coarser two elements become one (their middle node is dropped), where it gets finer one becomes two.

Ours is one addition: the outermost element at each end is halved towards the end ``end_levels`` times and stays so.
The rope is clamped there with a vertical tangent, and the bending layer below the clamp, sqrt(EI / T) = 0.2 to 0.5 m
long, is shorter than l; unresolved, it leans the whole leg.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..parameters import Mesh
from .rope_system import Array, arc_lengths

LADDER = np.array([1.0, 0.5, 0.25, 0.125, 0.25, 0.5, 1.0])

#: a transformation is due when the loop is this many l away from the middle of segment IV: half, and a margin that
#: keeps a loop which trembles about the limit from transforming to and fro
DUE = 0.6
#: more would be a mistake in the unit of an element's length
MOST_ELEMENTS = 20000


@dataclass(frozen=True)
class Partition:
    """Element lengths from left to right; for TMN-ETM also the pattern they come from.

    ``counts`` are the elements of the seven segments (empty for EEM) before the end elements are halved
    ``end_levels`` times, ``coarse`` is l.
    """

    lengths: Array
    counts: tuple[int, ...] = ()
    coarse: float = 0.0
    end_levels: int = 0

    @property
    def nodes_s(self) -> Array:
        """Arc length of the nodes from the left end, m."""
        return arc_lengths(self.lengths)

    @cached_property
    def centre(self) -> float:
        """Arc length of the middle of segment IV, m."""
        inner = float(np.dot(self.counts[1:6], LADDER[1:6]))
        return self.coarse * (self.counts[0] + 0.5 * inner)


def partition(mesh: Mesh, length: float, bottom: float) -> Partition:
    """The partition of a rope of ``length`` whose loop hangs at arc length ``bottom``."""
    if mesh.kind == "eem":
        return Partition(np.full(mesh.elements, length / mesh.elements))
    inner = float(np.dot(mesh.counts, LADDER[1:6]))
    outer = round(length / mesh.coarse_length - inner)
    if outer > MOST_ELEMENTS:
        raise ValueError(
            f"coarse_length = {mesh.coarse_length:g} m makes {outer} elements of a rope of {length:g} m, more than "
            f"{MOST_ELEMENTS}; use longer elements"
        )
    if outer < 2:
        raise ValueError(
            f"the mesh's segments II to VI need {inner * mesh.coarse_length:g} m of a rope of {length:g} m and leave "
            "nothing for I and VII; lower coarse_length or the counts"
        )
    coarse = length / (outer + inner)
    first = int(np.clip(round(bottom / coarse - 0.5 * inner), 1, outer - 1))
    return _tmn((first, *mesh.counts, outer - first), coarse, mesh.end_levels)


def misplaced(mesh: Partition, bottom: float) -> str:
    """'' while the loop at arc length ``bottom`` hangs in the mesh's fine middle; otherwise what is wrong."""
    if not mesh.counts or abs(bottom - mesh.centre) <= (DUE + 1.0) * mesh.coarse:
        return ""
    return (
        f"the loop at {bottom:.3g} m of the rope's {np.sum(mesh.lengths):.4g} m is too close to an end: the mesh's "
        f"fine middle reaches no further than {mesh.centre:.3g} m; use a smaller coarse_length or fewer elements in "
        "segments II to VI, or keep the ends closer in height"
    )


def transformed(old: Partition, direction: int) -> Partition:
    """The partition after one transformation, ``direction`` +1 when the loop travels to the right, else -1."""
    first, last = old.counts[0] + direction, old.counts[6] - direction
    return _tmn((first, *old.counts[1:6], last), old.coarse, old.end_levels)


def transformation_due(mesh: Partition, bottom: float, slack: float = 0.0) -> int:
    """+1 or -1 when the loop at arc length ``bottom`` is within ``slack`` (m) of calling for a transformation.

    0 when it is not, or when the mesh can make no more in that direction.
    """
    return 0 if distance_to_due(mesh, bottom) < -slack else int(np.sign(bottom - mesh.centre))


def distance_to_due(mesh: Partition, bottom: float) -> float:
    """How far past the limit the loop is, m; negative when no transformation is due or none is possible."""
    if not mesh.counts:
        return -np.inf
    offset = bottom - mesh.centre
    if mesh.counts[6 if offset > 0 else 0] == 1:
        return -np.inf
    return float(abs(offset) - DUE * mesh.coarse)


def _tmn(counts: tuple[int, ...], coarse: float, end_levels: int) -> Partition:
    ladder = np.repeat(coarse * LADDER, counts)
    # l/2, l/4 ... and the last length once more
    end = coarse * np.array([*(0.5**k for k in range(1, end_levels + 1)), 0.5**end_levels])
    return Partition(np.concatenate((end[::-1], ladder[1:-1], end)), counts, coarse, end_levels)
