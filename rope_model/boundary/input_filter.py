"""Input filter: from the motions that a host gives to smooth motions of the rope's ends.

Position, speed and acceleration of a host need not be consistent: tables are interpolated, encoders
round, slower components repeat.  A rope is stiff along its axis, 1 kN per mm and more, so its end
must not jump after every sample.  The end's motion x is therefore a state of its own.  It
integrates the given acceleration A and approaches the given position X and speed V slowly, as a
critically damped observer of second order:

    x_tt = A + 2 w (V - x_t) + w^2 (X - x).

Its bandwidth w follows from the required accuracy: a misfit as large as the error of the loop's
position, e_L, must not disturb the end forces by more than their error, e_F.  The disturbance is
w^2 e_L / g, so w = sqrt(e_F g / e_L).

A smooth motion leaves a remainder too: the quintic path between two samples knows only the
accelerations at its ends.  The part that a change of the acceleration within a step explains is
therefore met within the step, and only the rest is left to the observer.  A consistent motion is
followed exactly.

Inputs that a host does not give are estimated by fading-memory filters: E. Brookner, Tracking and
Kalman Filtering Made Easy, 1998, chapter 7.  A filter of n-th order with the bandwidth W lags
behind an acceleration of the rate J by n J / W.

This module holds an end's settings and state.  ``input_sample`` adds a sample of the host to the
state, with ``input_detectors`` of grids and tables; ``input_path`` leads the end's path to it, and
``input_misfit`` sums the misfits that are left.
"""

from __future__ import annotations

from typing import NamedTuple

from rope_model.boundary.end_paths import EndMotion
from rope_model.boundary.input_detectors import GridDetector, TableDetector
from rope_model.parameters import CHOICES, Scene
from rope_model.physics.elementary import Scalar, sqrt, where
from rope_model.physics.estimates import axial_frequency

#: bandwidth of estimates over the frequency of the rope's slowest axial wave: 1/10 of a motion at
#: that frequency passes (order 2), or 1/32 (order 3)
ESTIMATE_FRACTION = 1.0 / 3.0
#: s, time below which the mean acceleration from a rate of six decimals is off by more than
#: 1e-3 rad/s^2
MIN_MEAN_TIME = 1e-3
#: s, time in which the rounding of positions of 1e4 m, 2e-12 m, takes some 0.1 m/s^2; in 1e-8 s it
#: takes 1e5
MIN_AIM_TIME = 1e-5
#: a jump where the acceleration is given: its sample is compared with the path instead
NOT_ESTIMATED = -1.0
#: largest lag of an estimate in times of its bandwidth: that of the highest order
MAX_LAG = 3.0

#: codes of the trusted inputs
ALL, POSITION_SPEED, POSITION, SPEED = range(len(CHOICES["inputs.given"]))

Four = tuple[float, float, float, float]
Axis = tuple[float, float, float]
MotionNumbers = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float, float
]


class Misfits(NamedTuple):
    """Sums of the misfits between given and followed motion, and of their effects."""

    time: float = 0.0  # s
    position: float = 0.0  # m, largest so far
    speed: float = 0.0  # m/s, largest
    acceleration: float = 0.0  # m/s^2, largest
    squares: Axis = (0.0, 0.0, 0.0)  # time integrals of the squares of the three
    # m/s^2, slowest axial wave of the leg, now and a quarter period later
    wave: tuple[float, float] = (0.0, 0.0)
    lag: float = 0.0  # m/s^2, lag of an estimated acceleration of y
    force_error_square: float = 0.0  # N^2 s, time integral of the square of the end force's error
    drift: float = 0.0  # m, slow part of the misfit of y
    max_drift: float = 0.0  # m, largest size of the drift


class Repetitions(NamedTuple):
    """Repetitions of samples by a slower component."""

    number: float = 0.0  # of steps with the sample of an earlier one
    held: float = 0.0  # number of steps since the latest sample
    sent_every: float = 0.0  # s, time between the latest samples with repetitions between them


class InputFilter(NamedTuple):
    """State of an end's filter: latest input, filtered motion, misfits so far, and signs of their cause in y."""

    given: MotionNumbers = (0.0,) * 13
    given_at: float = 0.0  # s, instant of the latest sample that is no repetition
    # PATH at that instant, with estimates
    motion: tuple[Axis, Axis, Axis, Axis] = ((0.0, 0.0, 0.0),) * 4
    end_accelerations: Four = (0.0,) * 4  # accelerations of the samples at the path's end
    recent_changes: Four = (0.0,) * 4  # largest recent changes of these between two steps
    misfits: Misfits = Misfits()
    repetitions: Repetitions = Repetitions()
    grid: GridDetector = GridDetector()
    table: TableDetector = TableDetector()
    # m (yaw: rad), by which the latest sample is off any expected motion
    position_jumps: Four = (NOT_ESTIMATED,) * 4
    speed_jumps: Four = (NOT_ESTIMATED,) * 4  # m/s (yaw: rad/s), the same of its speed
    # rad/s, mean rates of the leans between the latest two samples
    lean_rates: tuple[float, float] = (0.0, 0.0)

    @staticmethod
    def at_rest(t: float, motion: EndMotion) -> InputFilter:
        """Return the state before anything moves."""
        x, y, z, yaw = ((x0, 0.0, 0.0) for x0 in (*motion.position, motion.yaw))
        table = TableDetector(broken_at=t)
        return InputFilter(tuple(vars(motion).values()), t, (x, y, z, yaw), table=table)


class FilterSettings(NamedTuple):
    """Settings of an end's filter: bandwidths (rad/s) of the observer and of the estimates, trust, and a bound."""

    observer: float
    estimate: float
    position_trust: float  # 1 if it is trusted, else 0
    speed_trust: float
    acceleration_trust: float
    max_deceleration: float  # m/s^2, of a conveyance: beyond it head ropes of a rising one go slack


def filter_settings(scene: Scene, trusted: Scalar) -> FilterSettings:
    """Return the settings as chosen, or as they follow from the required accuracy and from the rope.

    ``trusted`` is the code of inputs.given.
    """
    chosen = scene.inputs
    accuracy = scene.accuracy
    derived = sqrt(accuracy.end_force * scene.layout.gravity / accuracy.loop)
    slowest = ESTIMATE_FRACTION * axial_frequency(scene.rope, scene.rope.length)
    return FilterSettings(
        where(chosen.bandwidth > 0, chosen.bandwidth, derived),
        where(chosen.estimate_bandwidth > 0, chosen.estimate_bandwidth, slowest),
        where(trusted <= POSITION, 1.0, 0.0),
        where(abs(trusted - POSITION) < 0.5, 0.0, 1.0),
        where(trusted <= ALL, 1.0, 0.0),
        scene.layout.gravity,
    )
