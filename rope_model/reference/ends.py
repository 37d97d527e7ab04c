"""Motions of the conveyances between two instants of the host.

Each coordinate x, y, z, yaw of an end is a quintic in time with the given position, speed and
acceleration at both instants (docs/theory/ends.md, "The ends").  A yaw has no given acceleration:
it is the mean since the last instant.
"""

import math
from dataclasses import dataclass

import numpy as np

from rope_model.arrays import Array
from rope_model.boundary.end_paths import MOTION_BOUNDS, PATH, EndMotion
from rope_model.messages import messages

YAW = PATH.index("yaw")  #: column of an end's yaw
#: values and first and second derivatives of the powers 0 to 5 of u at 0 and at 1 (6, 6), inverted
_TO_POWERS = np.linalg.inv(
    np.array(
        [
            [1, 0, 0, 0, 0, 0],
            [0, 1, 0, 0, 0, 0],
            [0, 0, 2, 0, 0, 0],
            [1, 1, 1, 1, 1, 1],
            [0, 1, 2, 3, 4, 5],
            [0, 0, 2, 6, 12, 20],
        ]
    )
)


@dataclass(frozen=True)
class EndQuintic:
    """Motion of an end from one instant to the next."""

    start: float  #: s
    stop: float  #: s
    powers: Array  #: coefficients of the powers 0 to 5 of u, 0 to 1, for x, y, z, yaw (6, 4)

    def at(self, t: float) -> Array:
        """Return position, speed and acceleration of x, y, z, yaw (3, 4) at ``t`` (s)."""
        h = self.stop - self.start
        u = (t - self.start) / h
        value = [1, u, u**2, u**3, u**4, u**5]
        rate = [0, 1 / h, 2 * u / h, 3 * u**2 / h, 4 * u**3 / h, 5 * u**4 / h]
        second = [0, 0, 2 / h**2, 6 * u / h**2, 12 * u**2 / h**2, 20 * u**3 / h**2]
        return np.array([value, rate, second]) @ self.powers


def resting(t: float, motion: EndMotion) -> EndQuintic:
    """Return the path to ``t`` (s) of an end that rests at the position of ``motion``."""
    powers = np.zeros((6, 4))
    powers[0] = (*motion.position, motion.yaw)
    return EndQuintic(t - 1.0, t, powers)


def onwards(path: EndQuintic, t: float, motion: EndMotion, age: float) -> EndQuintic:
    """Return the path from the end of ``path`` to ``t`` (s).

    ``motion`` was given ``age`` (s) before ``t`` and goes on with its acceleration.
    """
    h = t - path.stop
    first = path.at(path.stop)
    yaw_acceleration = (motion.yaw_rate - first[1, YAW]) / h
    position = np.array([*motion.position, motion.yaw])
    speed = np.array([*motion.velocity, motion.yaw_rate])
    acceleration = np.array([*motion.acceleration, yaw_acceleration])
    last = np.array(
        [
            position + age * speed + 0.5 * age * age * acceleration,
            speed + age * acceleration,
            acceleration,
        ]
    )
    units = np.array([[1.0], [h], [h * h]])
    return EndQuintic(path.stop, t, _TO_POWERS @ np.vstack((units * first, units * last)))


def refusal(motion: EndMotion, side: str) -> str | None:
    """Return None if an end can be there; else value, bound and cure."""
    for name, bound in MOTION_BOUNDS.items():
        value = getattr(motion, name)
        if not math.isfinite(value):
            return messages.input_not_finite(side, name, value)
        if abs(value) > bound:
            return messages.input_out_of_range(side, name, value, bound)
        if name.startswith("lean") and value != 0:
            return messages.no_clamp(side, name, value)
    return None


def too_rough(path: EndQuintic, side: str, acceleration_max: float) -> str | None:
    """Return None if no acceleration at the quarters of the path is above the bound; else value and cure."""
    quarter = 0.25 * (path.stop - path.start)
    samples = [path.at(path.start + k * quarter)[2] for k in (1, 2, 3)]
    peaks = np.abs(samples).max(axis=0)
    worst = int(np.argmax(peaks))
    peak = float(peaks[worst])
    if peak <= acceleration_max:
        return None
    unit = "rad/s^2" if worst == YAW else "m/s^2"
    return messages.inputs_do_not_fit(side, PATH[worst], peak, unit, acceleration_max)
