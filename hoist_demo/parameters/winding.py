"""Data of one trip, and whether the hoist can do it."""

import math
from dataclasses import dataclass
from typing import Literal

from hoist_demo.parameters.components import require
from hoist_demo.parameters.hoist import Hoist
from hoist_demo.parameters.quantity import NONNEGATIVE, UNBOUNDED, ValidatedData, parameter

#: Who stops the hoist: the drive along its reference, or the brake with a regulated deceleration,
#: its full torque, or a part of it first and the whole later.
EmergencyLaw = Literal["drive", "deceleration", "torque", "two-stage"]


@dataclass(frozen=True)
class Winding(ValidatedData):
    """One trip of the left conveyance, up if travel is positive, with waits before and after."""

    travel: float = parameter(90.0, "m", "negative lowers", UNBOUNDED)
    speed: float = parameter(8.0, "m/s", "limit")
    acceleration: float = parameter(0.75, "m/s^2", "limit")
    jerk: float = parameter(0.5, "m/s^3", "limit")
    creep_speed: float = parameter(0.5, "m/s", "of a creep, where there is one")
    creep_distance: float = parameter(
        0.0,
        "m",
        "to the landing from where creep speed is reached, final stop included; 0: no creep",
        NONNEGATIVE,
    )
    departure_creep_distance: float = parameter(
        0.0, "m", "to where creep speed is left; 0: no creep", NONNEGATIVE
    )
    start_delay: float = parameter(1.0, "s", "", NONNEGATIVE)
    settle: float = parameter(10.0, "s", "recorded after the reference has arrived", NONNEGATIVE)
    emergency_at: float | None = parameter(
        None, "s", "emergency stop begins; left out: no emergency stop", NONNEGATIVE
    )
    emergency_deceleration: float = parameter(5.0, "m/s^2")
    emergency_jerk: float = parameter(50.0, "m/s^3", "the short ramp of the emergency deceleration")
    emergency_law: EmergencyLaw = "drive"

    def __post_init__(self) -> None:
        super().__post_init__()
        require(
            self.travel,
            self.travel != 0.0,
            "travel",
            "finite and not 0",
            "give the length of the trip in m",
        )
        creep, bound = self.creep_speed, f"above 0 and at most the speed limit {self.speed:g} m/s"
        slow = creep > 0.0 and (not self.creeps or creep <= self.speed)
        require(creep, slow, "creep_speed", bound, "creep more slowly")
        value, bound = (
            self.emergency_deceleration,
            f"at least the acceleration limit {self.acceleration:g} m/s^2",
        )
        cure = "brake harder or wind more gently"
        require(value, value >= self.acceleration, "emergency_deceleration", bound, cure)
        value, bound = self.emergency_jerk, f"at least the jerk limit {self.jerk:g} m/s^3"
        require(value, value >= self.jerk, "emergency_jerk", bound, "shorten the brake's ramp")

    @property
    def creeps(self) -> bool:
        """True if some of the trip is run at creep speed."""
        return self.creep_distance > 0.0 or self.departure_creep_distance > 0.0

    @property
    def tracking_end(self) -> float:
        """Time [s] until which the drive follows the reference: an emergency stop by the brake."""
        return (
            math.inf
            if self.emergency_at is None or self.emergency_law == "drive"
            else self.emergency_at
        )


@dataclass(frozen=True)
class Arrival(ValidatedData):
    """Bounds within which a conveyance counts as arrived; all values [assumed]."""

    position_band: float = parameter(0.01, "m", "of the left conveyance about its landing")
    speed_band: float = parameter(0.01, "m/s", "of both conveyances")
    window: float = parameter(5.0, "s", "after the reference's arrival, over which swing is judged")


def require_trip_fits(hoist: Hoist, winding: Winding) -> None:
    """Reject a trip longer than the shaft, and a stop for which the brake is too weak."""
    travel, bound = winding.travel, f"within +- shaft_travel = {hoist.shaft_travel:g} m"
    require(travel, abs(travel) <= hoist.shaft_travel, "travel", bound, "shorten the trip")
    if winding.emergency_law == "drive":
        return
    if hoist.brake is None:
        raise ValueError(
            f"emergency_law = {winding.emergency_law!r} must be 'drive' for a hoist without a "
            "brake: give it one, as hoist.brake.torque = 5.5e5 (N m)"
        )
    deceleration, capacity = (
        winding.emergency_deceleration,
        hoist.brake.torque / hoist.sheave_radius,
    )
    enough = winding.emergency_law != "deceleration" or deceleration * hoist.moving_mass <= capacity
    bound = (
        f"at most {capacity / hoist.moving_mass:.3g} m/s^2, what brake.torque gives all moving "
        "masses"
    )
    require(
        deceleration,
        enough,
        "emergency_deceleration",
        bound,
        "brake more gently or fit a stronger brake",
    )


def require_jams_on_the_way(hoist: Hoist, winding: Winding) -> None:
    """Reject a jam that its conveyance does not reach in a trip from its landing."""
    start, _ = start_heights(hoist, winding)
    low, high = sorted((start, start + winding.travel))
    for name, jam, (least, most) in (
        ("jam_left", hoist.jam_left, (low, high)),
        ("jam_right", hoist.jam_right, (hoist.shaft_travel - high, hoist.shaft_travel - low)),
    ):
        if jam is not None:
            on_the_way = least - jam.distance < jam.height < most + jam.distance
            bound = (
                f"within {jam.distance:g} m of {least:g} to {most:g} m, where its conveyance comes "
                "in a trip of "
            )
            cure = f"move the jam (hoist.{name}.height), or wind further (wind --quick winds 10 m)"
            require(jam.height, on_the_way, f"{name}.height", f"{bound}{winding.travel:g} m", cure)


def start_heights(hoist: Hoist, winding: Winding) -> tuple[float, float]:
    """Return the heights of left and right conveyance before a trip [m].

    They are the landings; left is the lower one if it rises.
    """
    low, high = 0.0, hoist.shaft_travel
    return (low, high) if winding.travel > 0.0 else (high, low)
