"""Smallest distances of several ropes in one hoist, and what they did to each other."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from hoist_demo.recording.ropes import rope_signals
from hoist_demo.recording.time_series import Array, Recording
from rope_model import Account

LOOKED_AT = 0.1  #: Time between two shapes that are compared [s].


#: Square of the sine of an angle below which two sides count as parallel.
PARALLEL = 1e-12


@dataclass(frozen=True)
class NearestRopes:
    """Smallest distance of two ropes in a run."""

    clearance: float  # m, between their surfaces
    t: float  # s
    position: tuple[float, float, float]  # m, half-way between both


@dataclass(frozen=True)
class RopePair:
    """Two ropes, their nearest approach, and what their contact did where it is computed."""

    one: str
    other: str
    nearest: NearestRopes | None  # None: no instant at which both have a shape
    account: Account | None

    @property
    def touched(self) -> bool:
        """True if the ropes touched, as far as their shapes show."""
        return self.nearest is not None and self.nearest.clearance <= 0.0


def nearest(times: Array, one: Array, other: Array, radii: float) -> NearestRopes:
    """Return the nearest approach of two ropes.

    Their shapes are points (instants, points, 3) [m]; ``radii`` is the sum of their radii [m].
    """
    best = NearestRopes(np.inf, float(times[0]), (np.nan, np.nan, np.nan))
    for k, t in enumerate(times):
        distance, position = polygon_distance(one[k], other[k])
        if distance - radii < best.clearance:
            x, y, z = position.tolist()
            best = NearestRopes(distance - radii, float(t), (x, y, z))
    return best


def polygon_distance(one: Array, other: Array) -> tuple[float, Array]:
    """Return the smallest distance of polygons through points (n, 3), and the place half-way [m].

    Two sides p + a d, q + b e, a and b within 0 and 1, are nearest where both derivatives vanish,
    or at a bound (C. Ericson, Real-Time Collision Detection, 2005, section 5.1.9). An arc of the
    radius r cut short by a side of the length l is missed by l^2 / (8 r) at most.
    """
    p = one[:-1, None]
    d = np.diff(one, axis=0)[:, None]
    q = other[None, :-1]
    e = np.diff(other, axis=0)[None]
    r = p - q
    dd = (d * d).sum(-1)
    ee = (e * e).sum(-1)
    de = (d * e).sum(-1)
    dr = (d * r).sum(-1)
    er = (e * r).sum(-1)
    across = dd * ee - de * de
    # parallel sides are nearest at an end, too
    inside = (de * er - dr * ee) / np.where(across > 0.0, across, 1.0)
    a = np.where(across > PARALLEL * dd * ee, inside, 0.0)
    b = np.clip((de * np.clip(a, 0.0, 1.0) + er) / ee, 0.0, 1.0)
    a = np.clip((de * b - dr) / dd, 0.0, 1.0)
    gap = r + a[..., None] * d - b[..., None] * e
    distance = np.linalg.norm(gap, axis=-1)
    k = np.unravel_index(np.argmin(distance), distance.shape)
    return float(distance[k]), (p + a[..., None] * d)[k] - 0.5 * gap[k]


def pairs(
    recording: Recording,
    ropes: Sequence[tuple[str, tuple[float, float, float], float]],
    accounts: Mapping[tuple[str, str], Account],
) -> list[RopePair]:
    """List all pairs of ropes with name, origin of their places [m] and diameter [m].

    A broken rope has no shape any more, and one whose model leaves out what leads it out of its
    plane has none either.
    """
    every = 1
    if recording.time.size > 1:
        every = max(1, round(LOOKED_AT / (recording.time[1] - recording.time[0])))
    shapes = {name: _shapes(recording, name, origin, every) for name, origin, _ in ropes}
    rope_pairs = []
    for (one, _, diameter), (other, _, other_diameter) in combinations(ropes, 2):
        count = min(len(shapes[one]), len(shapes[other]))
        times = recording.time[::every][:count]
        shape = shapes[one][:count]
        other_shape = shapes[other][:count]
        both = np.isfinite(shape + other_shape).all(axis=(1, 2))
        near = None
        if both.any():
            radii = 0.5 * (diameter + other_diameter)
            near = nearest(times[both], shape[both], other_shape[both], radii)
        rope_pairs.append(RopePair(one, other, near, accounts.get((one, other))))
    return rope_pairs


def _shapes(
    recording: Recording, name: str, origin: tuple[float, float, float], every: int
) -> Array:
    """Return shapes of a rope (instants, points, 3) [m] until it breaks.

    They count x from between the conveyances' centres.
    """
    rope = rope_signals(recording, name)
    shapes = rope.shapes_at(range(0, len(rope.time), every))
    assert shapes is not None
    # a rope that its model keeps in a plane has no place out of it
    return np.asarray(shapes + origin + 0.0 * rope["loop.z"][::every, None, None])
