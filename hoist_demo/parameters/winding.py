"""Data of one trip, and whether the hoist can do it."""

import math
from dataclasses import dataclass
from typing import Literal

from hoist_demo.parameters.components import Jam, require
from hoist_demo.parameters.hoist import Hoist
from hoist_demo.parameters.quantity import NONNEGATIVE, UNBOUNDED, ValidatedData, parameter

#: Who stops the hoist: the drive along its reference, or the brake with a regulated deceleration,
#: its full torque, or a part of it first and the whole later.
EmergencyLaw = Literal["drive", "deceleration", "torque", "two-stage"]


@dataclass(frozen=True)
class Winding(ValidatedData):
    """One trip of the left conveyance, up if travel is positive, with waits before and after."""

    travel: float = parameter(
        90.0, "m", "travel of the left conveyance; a negative one lowers it", UNBOUNDED
    )
    speed: float = parameter(8.0, "m/s", "limit of the speed")
    acceleration: float = parameter(0.75, "m/s^2", "limit of the acceleration")
    jerk: float = parameter(0.5, "m/s^3", "limit of the jerk")
    creep_speed: float = parameter(0.5, "m/s", "speed of a creep, where the trip has one")
    creep_distance: float = parameter(
        0.0,
        "m",
        "distance to the landing at which creep speed is reached, final stop included; 0: no creep",
        NONNEGATIVE,
    )
    departure_creep_distance: float = parameter(
        0.0, "m", "distance from the start at which creep speed is left; 0: no creep", NONNEGATIVE
    )
    start_delay: float = parameter(1.0, "s", "time at rest before the trip", NONNEGATIVE)
    settle: float = parameter(
        10.0, "s", "time that is recorded after the reference has arrived", NONNEGATIVE
    )
    emergency_at: float | None = parameter(
        None,
        "s",
        "time at which an emergency stop begins; left out: no emergency stop",
        NONNEGATIVE,
    )
    emergency_deceleration: float = parameter(5.0, "m/s^2", "deceleration of an emergency stop")
    emergency_jerk: float = parameter(
        50.0, "m/s^3", "jerk of the short ramp to the emergency deceleration"
    )
    emergency_law: EmergencyLaw = "drive"

    def __post_init__(self) -> None:
        super().__post_init__()
        require(
            self.travel,
            self.travel != 0.0,
            name="travel",
            bound="finite and not 0",
            cure="give the length of the trip in m",
        )
        require(
            self.creep_speed,
            self.creep_speed > 0.0 and (not self.creeps or self.creep_speed <= self.speed),
            name="creep_speed",
            bound=f"above 0 and at most the speed limit {self.speed:g} m/s",
            cure="creep more slowly",
        )
        require(
            self.emergency_deceleration,
            self.emergency_deceleration >= self.acceleration,
            name="emergency_deceleration",
            bound=f"at least the acceleration limit {self.acceleration:g} m/s^2",
            cure="brake harder or wind more gently",
        )
        require(
            self.emergency_jerk,
            self.emergency_jerk >= self.jerk,
            name="emergency_jerk",
            bound=f"at least the jerk limit {self.jerk:g} m/s^3",
            cure="shorten the brake's ramp",
        )

    @property
    def creeps(self) -> bool:
        """True if some of the trip is run at creep speed."""
        return self.creep_distance > 0.0 or self.departure_creep_distance > 0.0

    @property
    def tracking_end(self) -> float:
        """Time [s] until which the drive follows the reference: an emergency stop by the brake."""
        if self.emergency_at is None or self.emergency_law == "drive":
            return math.inf
        return self.emergency_at


@dataclass(frozen=True)
class Arrival(ValidatedData):
    """Bounds within which a conveyance counts as arrived; all values [assumed]."""

    position_band: float = parameter(
        0.01, "m", "largest distance of the left conveyance from its landing"
    )
    speed_band: float = parameter(0.01, "m/s", "largest speed of either conveyance")
    window: float = parameter(
        5.0, "s", "time after the reference's arrival over which swing is judged"
    )


def require_trip_fits(hoist: Hoist, winding: Winding) -> None:
    """Reject a trip longer than the shaft, and a stop for which the brake is too weak."""
    require(
        winding.travel,
        abs(winding.travel) <= hoist.shaft_travel,
        name="travel",
        bound=f"within +- shaft_travel = {hoist.shaft_travel:g} m",
        cure="shorten the trip",
    )
    if winding.emergency_law == "drive":
        return
    if hoist.brake is None:
        raise ValueError(
            f"emergency_law = {winding.emergency_law!r} must be 'drive' for a hoist without a "
            "brake: give it one, as hoist.brake.torque = 5.5e5 (N m)"
        )
    deceleration = winding.emergency_deceleration
    capacity = hoist.brake.torque / hoist.sheave_radius
    largest = capacity / hoist.moving_mass
    require(
        deceleration,
        winding.emergency_law != "deceleration" or deceleration * hoist.moving_mass <= capacity,
        name="emergency_deceleration",
        bound=f"at most {largest:.3g} m/s^2, what brake.torque gives all moving masses",
        cure="brake more gently or fit a stronger brake",
    )


def require_jams_on_the_way(hoist: Hoist, winding: Winding) -> None:
    """Reject a jam that its conveyance does not reach in a trip from its landing."""
    start, _ = start_heights(hoist, winding)
    low, high = sorted((start, start + winding.travel))
    _require_on_the_way(hoist.jam_left, "jam_left", low, high, winding.travel)
    travel = hoist.shaft_travel
    _require_on_the_way(hoist.jam_right, "jam_right", travel - high, travel - low, winding.travel)


def _require_on_the_way(jam: Jam | None, name: str, low: float, high: float, travel: float) -> None:
    """Reject a jam that is not between the heights ``low`` and ``high`` of its conveyance [m]."""
    if jam is None:
        return
    require(
        jam.height,
        low - jam.distance < jam.height < high + jam.distance,
        name=f"{name}.height",
        bound=(
            f"within {jam.distance:g} m of {low:g} to {high:g} m, where its conveyance comes in a "
            f"trip of {travel:g} m"
        ),
        cure=f"move the jam (hoist.{name}.height), or wind further (wind --quick winds 10 m)",
    )


def start_heights(hoist: Hoist, winding: Winding) -> tuple[float, float]:
    """Return the heights of left and right conveyance before a trip [m].

    They are the landings; left is the lower one if it rises.
    """
    if winding.travel > 0.0:
        return 0.0, hoist.shaft_travel
    return hoist.shaft_travel, 0.0
