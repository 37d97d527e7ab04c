"""Input shaping: the trip's reference convolved with impulses that leave one swing mode at rest.

With K = exp(-zeta pi / sqrt(1 - zeta^2)) and the damped half period T_d / 2 = 1 / (2 f),

    ZV : amplitudes (1, K) / (1 + K)          at 0, T_d / 2
    ZVD: amplitudes (1, 2 K, K^2) / (1 + K)^2 at 0, T_d / 2, T_d.

A chain of constant-jerk segments stays one, because convolution is a sum of shifted chains.
Source: N. C. Singer and W. P. Seering, Preshaping command inputs to reduce system vibration, J. Dyn. Sys. Meas.
Control 112, 1990.
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

from hoist_demo.control.trajectory import Trajectory, TrajectoryPoint
from hoist_demo.parameters.quantity import VANISHING, Bounds, Stated, quantity


@dataclass(frozen=True)
class Shaper(Stated):
    """The mode to leave at rest, as measured (metrics `swing_frequency`, `swing_damping` of a study) or modelled."""

    kind: Literal["ZV", "ZVD"] = quantity("ZVD", "")
    frequency: float = quantity(0.0, "Hz", "damped, of the mode; 0: it and damping from the linear model", VANISHING)
    damping: float = quantity(0.0, "1", "damping ratio of the mode", Bounds(0.0, 0.999, cure="measure it"))

    @property
    def impulses(self) -> tuple[tuple[float, float], ...]:
        """Pairs of time [s] and amplitude [1]; the amplitudes sum to 1."""
        K = math.exp(-self.damping * math.pi / math.sqrt(1.0 - self.damping**2))
        half = 0.5 / self.frequency
        weights = (1.0, K) if self.kind == "ZV" else (1.0, 2.0 * K, K**2)
        return tuple((k * half, weight / sum(weights)) for k, weight in enumerate(weights))


def shape(trip: Trajectory, shaper: Shaper) -> Trajectory:
    """`trip` convolved with the shaper's impulses; it arrives later by the last impulse's time."""
    impulses = shaper.impulses
    starts = sorted({start + delay for start in trip.starts for delay, _ in impulses})
    points = []
    for start, end in pairwise(starts):
        # the jerk of a segment is read in its middle, where no rounding can name the neighbour's
        middle = 0.5 * (start + end)
        points.append(
            TrajectoryPoint(
                position=sum(w * trip.at(start - delay).position for delay, w in impulses),
                speed=sum(w * trip.at(start - delay).speed for delay, w in impulses),
                acceleration=sum(w * trip.at(start - delay).acceleration for delay, w in impulses),
                jerk=sum(w * trip.at(middle - delay).jerk for delay, w in impulses),
            )
        )
    return Trajectory(tuple(starts), (*points, trip.points[-1]))
