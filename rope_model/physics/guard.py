"""Guards of the loop: their quantities, and when they trip.

Five quantities are watched, each against a threshold of its own, 0 for none:

    rise        how far the loop's lowest point is above its quasi-static place, or above a switch at a given height
    window      how far it is, horizontally, from midway between the ends, or, at the height of a switch, a leg from
                straight below its end
    clearance   distance of the rope's surface from the nearest body of the shaft, where it is less than the threshold
    turns       |loop.turns|
    torque      the larger moment of both swivels

A guard trips when its quantity has been beyond the threshold without a break for the guard's delay.  The first one to
do so is the cause and stays it; of several at one instant it is that which stands first above.

A rope of the length L between ends at yl and yr, whose legs are a = (L + yl - yr)/2 and b = L - a long, and stretch
under their own weight, has its lowest point quasi-statically at

    (yl + yr)/2 - rho g (a^2 + b^2) / (4 Qa) - constant,

the constant being that of the loop where the rope was at rest.
"""

from typing import Any, NamedTuple

from rope_model.physics.elementary import hypot, less, smaller, where

#: guards; a cause's code is its place, counted from 1
CAUSES = ("rise", "window", "clearance", "turns", "torque")
#: s: beyond any time
NEVER = 1e30


class GuardState(NamedTuple):
    """Memory of the guards."""

    rest: float = 0.0  # m, loop_height at rest
    cause: float = 0.0  # of the trip; 0: none
    time: float = 0.0  # s, of the trip
    since: tuple[float, float, float, float, float] = (NEVER,) * 5  # s, from when on each is beyond its threshold


def thresholds(guard: Any) -> tuple[Any, ...]:
    """Thresholds in the order of CAUSES."""
    return guard.rise, guard.window, guard.clearance, guard.turns, guard.torque


def guarded(guard: Any) -> Any:
    """Number above 0 where there is any guard."""
    return sum(thresholds(guard)[1:], guard.rise)


def loop_height(rope: Any, layout: Any, lowest: Any, left: Any, right: Any) -> Any:
    """Height (m) of the loop's ``lowest`` point over its quasi-static place, but for a constant of the loop.

    ``left`` and ``right`` are heights of the ends.
    """
    a = 0.5 * (rope.length + left - right)
    b = rope.length - a
    stretch = 0.5 * rope.mass_per_length * layout.gravity * (a * a + b * b) / rope.Qa
    return lowest - 0.5 * (left + right) + 0.5 * stretch


def sideways(point: Any, left: Any, right: Any) -> Any:
    """Horizontal distance (m) of ``point`` (3,) from midway between the ends (3,)."""
    return hypot(point[0] - 0.5 * (left[0] + right[0]), point[2] - 0.5 * (left[2] + right[2]))


def off_plumb(height: Any, a: Any, b: Any, end: Any) -> Any:
    """Horizontal distance (m) from ``end`` of the piece from ``a`` to ``b`` (3,), at a ``height`` that it passes."""
    part = (height - a[1]) / (b[1] - a[1])
    return hypot(a[0] + part * (b[0] - a[0]) - end[0], a[2] + part * (b[2] - a[2]) - end[2])


def watch(guard: Any, state: Any, t: Any, seen: Any) -> GuardState:
    """The state of the guards that at the instant ``t`` (s) have ``seen`` this, in the order of CAUSES."""
    limits = thresholds(guard)
    delays = guard.rise_delay, guard.window_delay, guard.clearance_delay, guard.turns_delay, guard.torque_delay
    excess = [value - limit for value, limit in zip(seen, limits, strict=True)]
    excess[2] = -excess[2]
    on = [less(0.0, limit) * less(0.0, x) for limit, x in zip(limits, excess, strict=True)]
    since = [where(less(0.5, x), smaller(before, t), NEVER) for x, before in zip(on, state.since, strict=True)]
    first: Any = 0.0
    for code, (start, delay) in reversed([*enumerate(zip(since, delays, strict=True), start=1)]):
        first = where(less(t - start, delay), first, float(code))
    before = less(0.0, state.cause)
    cause = where(before, state.cause, first)
    time = where(before, state.time, where(less(0.0, first), t, 0.0))
    return GuardState(state.rest, cause, time, (since[0], since[1], since[2], since[3], since[4]))
