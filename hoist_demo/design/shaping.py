"""Input shaping: the trip's reference convolved with impulses that leave one swing mode at rest.

With K = exp(-zeta pi / sqrt(1 - zeta^2)) and the damped half period T_d / 2 = 1 / (2 f),

    ZV : amplitudes (1, K) / (1 + K)          at 0, T_d / 2
    ZVD: amplitudes (1, 2 K, K^2) / (1 + K)^2 at 0, T_d / 2, T_d.

A chain of constant-jerk segments stays one, because convolution is a sum of shifted chains.
Source: N. C. Singer and W. P. Seering, Preshaping command inputs to reduce system vibration, J. Dyn. Sys. Meas.
Control 112, 1990.
"""

from itertools import pairwise

from hoist_demo.control.trajectory import Trajectory, TrajectoryPoint
from hoist_demo.parameters.trip_design import Shaper


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
