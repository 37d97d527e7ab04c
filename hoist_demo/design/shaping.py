"""Input shaping: the trip's reference convolved with impulses that leave one swing mode at rest.

With K = exp(-zeta pi / sqrt(1 - zeta^2)) and the damped half period T_d / 2 = 1 / (2 f),

    ZV : amplitudes (1, K) / (1 + K)          at 0, T_d / 2
    ZVD: amplitudes (1, 2 K, K^2) / (1 + K)^2 at 0, T_d / 2, T_d.

A chain of constant-jerk segments stays one, because convolution is a sum of shifted chains.
Source: N. C. Singer and W. P. Seering, Preshaping command inputs to reduce system vibration, J. Dyn. Sys. Meas.
Control 112, 1990.
"""

import math
from itertools import pairwise

from hoist_demo.control.trajectory import Trajectory, TrajectoryPoint
from hoist_demo.parameters.trip_design import Shaper
from rope_model.physics.elementary import sum_of


def impulses(shaper: Shaper) -> tuple[tuple[float, float], ...]:
    """Return pairs of time [s] and amplitude [1]; the amplitudes sum to 1."""
    K = math.exp(-shaper.damping * math.pi / math.sqrt(1.0 - shaper.damping**2))
    weights = (1.0, K) if shaper.kind == "ZV" else (1.0, 2.0 * K, K**2)
    return tuple(
        (0.5 * k / shaper.frequency, weight / sum_of(weights)) for k, weight in enumerate(weights)
    )


def shape(trip: Trajectory, shaper: Shaper) -> Trajectory:
    """Return ``trip`` convolved with the shaper's impulses; the last of them delays it."""
    sequence = impulses(shaper)
    starts = sorted({start + delay for start in trip.starts for delay, _ in sequence})
    points = []
    for start, end in pairwise(starts):
        # the jerk of a segment is read in its middle, where no rounding can name the neighbour's
        middle = 0.5 * (start + end)
        points.append(
            TrajectoryPoint(
                position=sum_of(w * trip.at(start - delay).position for delay, w in sequence),
                speed=sum_of(w * trip.at(start - delay).speed for delay, w in sequence),
                acceleration=sum_of(
                    w * trip.at(start - delay).acceleration for delay, w in sequence
                ),
                jerk=sum_of(w * trip.at(middle - delay).jerk for delay, w in sequence),
            )
        )
    return Trajectory(tuple(starts), (*points, trip.points[-1]))
