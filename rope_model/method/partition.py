"""Partition of the rope into elements, and its pattern of segments."""

from dataclasses import dataclass

from rope_model.arrays import Array
from rope_model.method import mesh_pattern as tmn
from rope_model.method.mesh_fit import NO_DIVIDERS
from rope_model.physics.node import arc_lengths


@dataclass(frozen=True)
class Partition:
    """Element lengths from left to right; for TMN-ETM also their pattern.

    ``counts`` are the elements of the seven segments (0 for EEM) before the end elements are halved
    ``end_levels`` times and those of I and VII joined as ``grading_length`` (m) allows; ``coarse``
    is l.  Below 1 in I or VII they count the l that the end cuts off.  ``windows`` begin so many l
    from the ends, in the order of mesh_fit.divider_positions; unused ones are beyond the rope.
    """

    lengths: Array
    counts: tuple[int, ...] = (0,) * 7
    coarse: float = 0.0
    end_levels: int = 0
    grading_length: float = 0.0
    windows: tuple[int, ...] = (0,) * len(NO_DIVIDERS)

    @property
    def nodes_s(self) -> Array:
        """Arc length of the nodes from the left end, m."""
        return arc_lengths(self.lengths)

    @property
    def fine_length(self) -> float:
        """Length of the loop's elements, m."""
        if self.coarse:
            return self.coarse * tmn.fine_share(self.counts[1:6])
        return float(self.lengths[0])

    @property
    def centre(self) -> float:
        """Arc length of the middle of segment IV, m."""
        return float(tmn.pattern_centre(self))
