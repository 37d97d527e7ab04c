"""Motions of the conveyances between two instants of the host.

Each coordinate x, y, z, yaw of an end is a quintic in time with the given position, speed and
acceleration at both instants (docs/theory/ends.md, "The ends").  A yaw has no given acceleration:
it is the mean since the last instant.
"""

import math
from dataclasses import dataclass

import numpy as np

from rope_model.reference.equations import Array
from rope_model.simulation.ends.paths import MOTION_BOUNDS, EndMotion

SIDES = ("left", "right")
END_NODE = (0, -1)  #: row of each end in arrays of nodes
SENSE = (-1.0, 1.0)  #: of a rotation about Y in theta at each end, as of the tangent in Y
RESTS_BELOW = 1e-6  #: m/s and rad/s, speed below which an end rests
_POWERS = np.arange(6)
#: values and first and second derivatives of the powers 0 to 5 at 0 and at 1 (6, 6), inverted
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
class EndPath:
    """Motion of an end from one instant to the next."""

    start: float  #: s
    stop: float  #: s
    first: Array  #: position, speed, acceleration of x, y, z, yaw at the start (3, 4)
    last: Array  #: at the stop (3, 4)

    def at(self, t: float) -> Array:
        """Return position, speed and acceleration of x, y, z, yaw (3, 4) at ``t`` (s)."""
        if self.stop == self.start:
            return self.last
        h = self.stop - self.start
        u = (t - self.start) / h
        units = np.array([[1.0], [h], [h * h]])
        powers = _TO_POWERS @ np.vstack((units * self.first, units * self.last))
        value = u**_POWERS
        rate = _POWERS[1:] * u ** _POWERS[:-1]
        second = _POWERS[2:] * _POWERS[1:-1] * u ** _POWERS[:-2]
        return np.array([value @ powers, rate @ powers[1:] / h, second @ powers[2:] / (h * h)])


def resting(t: float, motion: EndMotion) -> EndPath:
    """Return the path of an end that rests at the position of ``motion``."""
    rows = np.zeros((3, 4))
    rows[0] = (*motion.position, motion.yaw)
    return EndPath(t, t, rows, rows)


def onwards(path: EndPath, t: float, motion: EndMotion, age: float) -> EndPath:
    """Return the path from the end of ``path`` to ``t`` (s).

    ``motion`` was given ``age`` (s) before ``t`` and goes on with its acceleration.
    """
    yaw_acceleration = (motion.yaw_rate - path.last[1, 3]) / (t - path.stop)
    position = np.array([*motion.position, motion.yaw])
    speed = np.array([*motion.velocity, motion.yaw_rate])
    acceleration = np.array([*motion.acceleration, yaw_acceleration])
    at_t = position + age * speed + 0.5 * age * age * acceleration
    return EndPath(
        path.stop, t, path.last, np.array([at_t, speed + age * acceleration, acceleration])
    )


def refusal(motion: EndMotion, side: str) -> str:
    """Return '' if an end can be there; else value, bound and cure."""
    for name, bound in MOTION_BOUNDS.items():
        value = getattr(motion, name)
        if not math.isfinite(value) or abs(value) > bound:
            return (
                f"{side}.{name} = {value:g} must be within -{bound:g} and {bound:g}: check its unit"
            )
        if name.startswith("lean") and value != 0:
            return (
                f"{side}.{name} = {value:g} rad must be 0: the reference rope knows plumb ends "
                "only; take the engine, balance_rope(scene)"
            )
    return ""


def peak_acceleration(path: EndPath) -> float:
    """Return the largest acceleration (m/s^2, rad/s^2) at the quarters of the path."""
    quarter = 0.25 * (path.stop - path.start)
    samples = [path.at(path.start + k * quarter)[2] for k in (1, 2, 3)]
    return float(np.abs(samples).max())
