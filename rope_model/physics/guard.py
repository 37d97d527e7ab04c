"""Guards of the loop: monitored quantities, thresholds and trips.

Five quantities are watched, each against its own threshold, 0 for none:

    rise        height of the loop's lowest point above its quasi-static position, or above a switch at a given height
    window      horizontal distance of that point from midway between the ends, or, at the height of a switch, of a leg
                from plumb below its end
    clearance   distance of the rope's surface from the nearest body of the shaft, which trips below the threshold
    turns       |loop.turns|
    torque      the larger moment of both swivels

A guard trips when its quantity has been beyond the threshold without interruption for the guard's
delay.  The first one to trip stays the cause; of several at one instant it is the first in the list
above.

A rope of the length L between ends at yl and yr has legs of length a = (L + yl - yr)/2 and
b = L - a, which stretch under their own weight.  The quasi-static height of its lowest point is

    (yl + yr)/2 - rho g (a^2 + b^2) / (4 Qa) - constant,

with the constant of the loop at rest.
"""

from typing import Annotated, Any, NamedTuple

from rope_model.parameters import Layout, Rope
from rope_model.physics.elementary import (
    Scalar,
    Vector,
    Vector3,
    hypot,
    less,
    minimum,
    sum_of,
    where,
)
from rope_model.physics.inextensible import left_leg_length
from rope_model.shaft_parameters import Guard

#: guards; the code of a cause is its index, counted from 1
CAUSES = ("rise", "window", "clearance", "turns", "torque")
#: s, beyond any time
NEVER = 1e30


class GuardState(NamedTuple):
    """State of the guards."""

    rest: float = 0.0  # m, loop_height at rest
    cause: float = 0.0  # code of the first trip; 0: none
    time: float = 0.0  # s, instant of that trip
    # s, instants at which the thresholds were passed
    since: tuple[float, float, float, float, float] = (NEVER,) * 5


def thresholds(guard: Guard) -> tuple[Scalar, ...]:
    """Return the thresholds in the order of CAUSES."""
    return guard.rise, guard.window, guard.clearance, guard.turns, guard.torque


def any_threshold(guard: Guard) -> Scalar:
    """Return a number above 0 if there is any guard, else 0."""
    return sum_of(thresholds(guard)[1:], guard.rise)


def loop_height(rope: Rope, layout: Layout, lowest: Scalar, left: Scalar, right: Scalar) -> Scalar:
    """Return the height (m) of the ``lowest`` point above its quasi-static position, up to the loop's constant.

    ``left`` and ``right`` are the heights of the ends.
    """
    a = left_leg_length(rope.length, left, right)
    b = rope.length - a
    stretch = 0.5 * rope.mass_per_length * layout.gravity * (a * a + b * b) / rope.Qa
    return lowest - 0.5 * (left + right) + 0.5 * stretch


def sideways(point: Vector3, left: Vector3, right: Vector3) -> Scalar:
    """Return the horizontal distance (m) of ``point`` (3,) from midway between the ends (3,)."""
    return hypot(point[0] - 0.5 * (left[0] + right[0]), point[2] - 0.5 * (left[2] + right[2]))


def off_plumb(height: Scalar, a: Vector3, b: Vector3, end: Vector3) -> Scalar:
    """Return the horizontal distance (m) of the piece from ``a`` to ``b`` (3,) from ``end``, at a ``height`` in it."""
    fraction = (height - a[1]) / (b[1] - a[1])
    return hypot(a[0] + fraction * (b[0] - a[0]) - end[0], a[2] + fraction * (b[2] - a[2]) - end[2])


def watch(
    guard: Guard, state: GuardState, t: Scalar, values: Annotated[Vector, len(CAUSES)]
) -> GuardState:
    """Return the state of the guards after the instant ``t`` (s), when their quantities have these ``values`` (5,)."""
    limits = thresholds(guard)
    delays = (
        guard.rise_delay,
        guard.window_delay,
        guard.clearance_delay,
        guard.turns_delay,
        guard.torque_delay,
    )
    excess = [value - limit for value, limit in zip(values, limits, strict=True)]
    excess[2] = -excess[2]
    exceeded = [less(0.0, limit) * less(0.0, x) for limit, x in zip(limits, excess, strict=True)]
    since = [
        where(less(0.5, x), minimum(before, t), NEVER)
        for x, before in zip(exceeded, state.since, strict=True)
    ]
    first: Any = 0.0
    for code, (start, delay) in reversed([*enumerate(zip(since, delays, strict=True), start=1)]):
        first = where(less(t - start, delay), first, float(code))
    before = less(0.0, state.cause)
    cause = where(before, state.cause, first)
    time = where(before, state.time, where(less(0.0, first), t, 0.0))
    return GuardState(state.rest, cause, time, (since[0], since[1], since[2], since[3], since[4]))
