"""What follows from a hoist's data before anything is wound: pulls, hold on the sheave, and the rope at rest."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import GRAVITY, Hoist, Winding
from rope_model import BalanceRope, EndMotion

AT_REST = 1.75  #: Slip safety that design rules require of a hoist at rest [assumed].
MOVING = 1.25  #: Slip safety that design rules require in normal winding [assumed].


@dataclass(frozen=True)
class StaticSlipSafety:
    """Head ropes on the sheave, at one instant."""

    when: str  # words behind "slip safety"
    ratio: float  # larger over smaller tension of both sides
    safety: float  # available over required friction
    required: float  # safety
    gentler: str  # what lowers the ratio besides other masses; "" for nothing
    in_trip: bool  # False for the trip back, which the hoist's file does not describe


def pulls(hoist: Hoist, height: float, acceleration: float = 0.0) -> tuple[float, float]:
    """Return the tensions of all head ropes at the sheave, left and right [N].

    ``height`` is that of the left conveyance [m], ``acceleration`` its own, upwards [m/s^2]; the
    balance ropes hang in two legs, whose lengths differ by twice the conveyances' distance from the
    middle.
    """
    tensions = []
    for mass, y, sign in (
        (hoist.mass_left, height, 1.0),
        (hoist.mass_right, hoist.shaft_travel - height, -1.0),
    ):
        leg = 0.5 * (hoist.tail_rope_length + 2.0 * y - hoist.shaft_travel)
        moved = (
            mass
            + hoist.rope_mass * (hoist.sheave_height - y)
            + hoist.tail_rope_number * hoist.tail_rope_mass * leg
        )
        tensions.append(moved * (GRAVITY + sign * acceleration))
    return tensions[0], tensions[1]


def reached(winding: Winding) -> Winding:
    """Return the trip with the speed and the acceleration that it reaches."""
    points = s_curve(winding).points
    speed, acceleration = (
        max(abs(getattr(x, name)) for x in points) for name in ("speed", "acceleration")
    )
    return replace(winding, speed=speed, acceleration=acceleration)


def static_slip_safeties(hoist: Hoist, winding: Winding) -> list[StaticSlipSafety]:
    """Return how the head ropes hold at rest, speeding up and slowing down, the worse of both landings.

    The conveyances are rigidly hung: swing of the head ropes, which jerk excites, lowers what a winding shows.
    """
    up = 1.0 if winding.travel > 0.0 else -1.0
    law = winding.emergency_law
    # nothing regulates it: the imbalance counts
    full = hoist.brake if law in ("torque", "two-stage") else None
    if full:
        stop = full.torque / hoist.sheave_radius / hoist.moving_mass
    else:
        stop = winding.emergency_deceleration
    gentler_stop = "lower winding.emergency_deceleration"
    if full:
        gentler_stop = "lower hoist.brake.torque"
    in_stop = f"in an emergency stop ({law})"
    gentler_trip = "lower winding.acceleration"
    unregulated = full is not None
    instants = (
        _Instant("at rest", 0.0, AT_REST),
        _Instant("while speeding up", up * winding.acceleration, MOVING, gentler_trip),
        _Instant("while slowing down", -up * winding.acceleration, MOVING, gentler_trip),
        _Instant(f"{in_stop} of this trip", -up * stop, 1.0, gentler_stop, unregulated),
        _Instant(
            f"{in_stop} of a trip back with the same payloads",
            up * stop,
            required=1.0,
            gentler=gentler_stop,
            unregulated=unregulated,
            in_trip=False,
        ),
    )
    return [_slip_safety_at(hoist, instant) for instant in instants]


class _Instant(NamedTuple):
    """Instant at which the head ropes must hold."""

    when: str
    acceleration: float  # m/s^2, of the left conveyance, upwards
    required: float  # slip safety
    gentler: str = ""
    unregulated: bool = False  # the imbalance of both sides adds to the acceleration
    in_trip: bool = True


def _slip_safety_at(hoist: Hoist, instant: _Instant) -> StaticSlipSafety:
    """Return the slip safety at an instant, the worse of both landings."""
    ratios = []
    for height in (0.0, hoist.shaft_travel):
        acceleration = instant.acceleration
        if instant.unregulated:
            left, right = pulls(hoist, height)
            acceleration -= (left - right) / hoist.moving_mass
        tensions = pulls(hoist, height, acceleration)
        if min(tensions) > 0.0:
            ratios.append(max(tensions) / min(tensions))
        else:
            ratios.append(math.inf)
    ratio = max(ratios)
    return StaticSlipSafety(
        instant.when,
        ratio=ratio,
        safety=hoist.slip_safety(ratio),
        required=instant.required,
        gentler=instant.gentler,
        in_trip=instant.in_trip,
    )


def at_rest(
    rope: BalanceRope, hoist: Hoist, heights: Sequence[float]
) -> Iterator[tuple[float, Mapping[str, float]]]:
    """Yield the rope's signals with the left conveyance at rest at each height [m]; RuntimeError where it cannot be."""
    for height in heights:
        status = rope.initialize(0.0, EndMotion(y=height), EndMotion(y=hoist.shaft_travel - height))
        if not status.valid:
            raise RuntimeError(
                f"at rest with the left conveyance at {height:g} m: {status.message}"
            )
        yield height, rope.signals()
