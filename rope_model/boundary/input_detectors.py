"""Detectors of the causes of misfits in the heights of an end: a rounding grid, and a table of straight lines."""

from typing import Any, NamedTuple

from rope_model.physics.elementary import Scalar, floor, logical_and, logical_or, minimum, where

#: m, grids of rounded positions that are recognised
GRIDS = (1e-2, 1e-3, 1e-4)
#: tolerance in multiples of a grid: doubles round 1e4 m by 1e-8 of the finest
ON_GRID = 1e-6
#: m/s, least change of speed between samples that reveals a broken line: twice the error of six
#: decimals in 10 ms
MIN_CHANGE = 2e-4
# change of the speed over that by the acceleration: 1 in a smooth motion, n at a break of a table
# of n steps
STRAIGHT = 0.2  #: upper bound on a straight line; the jerk makes up a fifth
BROKEN = 1.8  #: lower bound at a break
#: breaks after pieces of equal length that reveal a table: random pieces of 2 or 3 steps are alike
#: so once in 2^7
MIN_BREAKS = 8.0
#: relative difference of such lengths: less than a step of a table of a hundred
TABLE_TOLERANCE = 0.01


class GridDetector(NamedTuple):
    """Grid to which the positions of a moving end may be rounded."""

    size: float = 1.0  # m, coarsest of GRIDS with all positions; 1 before the first, 0: none
    samples: float = 0.0  # number of samples of an end that moves


class TableDetector(NamedTuple):
    """Breaks of y, which may come from a table that is interpolated linearly."""

    slope: float = 0.0  # m/s, slope of y between the latest two samples
    straight_samples: float = 0.0  # number of samples since the last break of y's line
    broken_at: float = 0.0  # s, instant of that break
    breaks: float = 0.0  # number of breaks after straight pieces as long as the one before
    piece: float = 0.0  # s, time between the latest two


def grid_after(grid: GridDetector, y: Scalar, moves: Scalar) -> GridDetector:
    """Return the detector after a sample ``y`` (m) of an end, which counts if the end ``moves``."""
    finest: Any = 0.0
    for size in reversed(GRIDS):
        multiple = y / size
        finest = where(abs(multiple - floor(multiple + 0.5)) < ON_GRID, size, finest)
    return GridDetector(
        size=where(moves, minimum(grid.size, finest), grid.size),
        samples=grid.samples + where(moves, 1.0, 0.0),
    )


def table_after(
    table: TableDetector, given_at: Scalar, slope: Scalar, expected: Scalar
) -> TableDetector:
    """Return the detector after a sample with this ``slope``, where the acceleration explains a change ``expected``."""
    change = abs(slope - table.slope)
    visible = expected > MIN_CHANGE
    breaks = logical_and(visible, change > BROKEN * expected)
    straight = logical_and(visible, change < STRAIGHT * expected)
    counts = logical_and(breaks, table.straight_samples > 0)
    piece = given_at - table.broken_at
    is_table = table.breaks >= MIN_BREAKS
    alike = logical_or(is_table, abs(piece - table.piece) < TABLE_TOLERANCE * piece)
    return TableDetector(
        slope=slope,
        straight_samples=where(straight, table.straight_samples + 1.0, 0.0),
        broken_at=where(breaks, given_at, table.broken_at),
        breaks=where(counts, where(alike, table.breaks + 1.0, 1.0), table.breaks),
        piece=where(logical_and(counts, 1 - is_table), piece, table.piece),
    )
