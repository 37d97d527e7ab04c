"""Outputs of a drive at one instant: names, and places in a vector."""

from itertools import product

import numpy as np

from hoist_demo.parameters import SIDES
from rope_model.arrays import Array

#: Motion of a conveyance in its guides.
_LATERAL = (
    *("x", "vx", "ax"),
    *("z", "vz", "az"),
    *("yaw", "yaw_rate", "yaw_acceleration"),
)

OUTPUTS = (
    *("y_left", "y_right"),  # m, heights of the suspensions
    *("v_left", "v_right"),  # m/s
    *("a_left", "a_right"),  # m/s^2
    *("angle", "rate"),  # rad, rad/s, of the sheave
    "torque",  # N m, of the motor
    *("tension_left", "tension_right"),  # N, all head ropes, at the sheave
    *("energy_kinetic", "energy_potential"),  # J
    "motor_rate",  # rad/s
    "brake_torque",  # N m, on the sheave, positive against positive rotation
    # N, at the sheave, were everything at rest here
    *("static_tension_left", "static_tension_right"),
    # place of a conveyance in its guides: x in the plane of the loop, z out of it, yaw about the
    # vertical, each with its rate and second derivative
    *(f"{name}_{side}" for side, name in product(SIDES, _LATERAL)),
    # N, of all head ropes on a conveyance, without their inertia; never negative
    *("pull_left", "pull_right"),
    *("slack_left", "slack_right"),  # m, of the head ropes
    *("jam_left", "jam_right"),  # N, of a jam on a conveyance, positive against upward motion
)
OUTPUT_INDEX = {name: k for k, name in enumerate(OUTPUTS)}  #: Places of OUTPUTS.


def tension_ratio(one: Array, other: Array) -> Array:
    """Return the larger tension over the smaller one [-], infinite where a side is slack."""
    low = np.minimum(one, other)
    high = np.maximum(one, other)
    return np.asarray(np.divide(high, low, out=np.full(np.shape(low), np.inf), where=low > 0.0))
