"""Bounds that a hoist keeps or breaks before it is wound: hold on the sheave, motor and brake."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from hoist_demo.cases.case import Case
from hoist_demo.cases.rules import RuleInputs
from hoist_demo.design.statics import reached, static_slip_safeties
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.parameters.components import Brake

HOLD = "Hold on the sheave"  #: Group of the rows on slip.
DRIVE = "Motor and brake"  #: Group of the rows on the drive.


@dataclass(frozen=True)
class CheckRow:
    """Bound that a hoist keeps or breaks before it is wound."""

    group: str
    quantity: str
    value: str
    bound: str
    holds: bool
    problem: str  # sentence for a bound that does not hold, with its cure
    in_trip: bool = True  # False: the hoist's trip does not come there, a note and no problem


@dataclass(frozen=True)
class HoistCheck:
    """Judgements of a hoist before it is wound: bounds, and remarks on values and on ropes."""

    rows: tuple[CheckRow, ...]
    remarks: tuple[str, ...] = ()

    @property
    def problems(self) -> list[str]:
        """Sentences on bounds that the hoist's trip breaks, then the remarks."""
        broken = [row.problem for row in self.rows if row.in_trip and not row.holds]
        return [*broken, *self.remarks]

    @property
    def notes(self) -> list[str]:
        """Sentences on bounds that other trips than the hoist's would break."""
        return [row.problem for row in self.rows if not (row.in_trip or row.holds)]


def checks(case: Case) -> list[CheckRow]:
    """Return a row for each bound of a hoist at rest, in its trip and in emergency stops."""
    return [*_slip_checks(case), *_drive_checks(case)]


def _slip_checks(case: Case) -> Iterator[CheckRow]:
    """Yield a row for each instant at which the head ropes must hold on the sheave."""
    limit = case.hoist.tension_ratio_limit
    for one in static_slip_safeties(case.hoist, case.winding):
        cures = ["add mass on the lighter side", "take a lining with more friction"]
        if one.gentler:
            cures.append(one.gentler)
        yield CheckRow(
            HOLD,
            quantity=f"slip safety {one.when}, without swing",
            value=f"{one.safety:.3g}",
            bound=f"{one.required:g}",
            holds=one.safety >= one.required,
            problem=(
                f"slip safety {one.when} is {one.safety:.3g} (tension ratio {one.ratio:.3g}, limit "
                f"{limit:.3g}) and must be at least {one.required:g}: {', or '.join(cures)}"
            ),
            in_trip=one.in_trip,
        )


class _DriveLimit(NamedTuple):
    """Limit of motor or brake, and what the trip needs of it."""

    name: str  # parameter of the hoist
    limit: float
    needed: float
    unit: str
    cure: str


def _drive_checks(case: Case) -> Iterator[CheckRow]:
    """Yield a row for each limit of motor and brake."""
    trip = reached(case.winding)
    limits = [*_motor_limits(case.hoist, trip)]
    if case.hoist.brake is not None:
        limits += _brake_limits(case.hoist, case.hoist.brake, trip)
    for one in limits:
        value = f"{one.limit:g} {one.unit}"
        bound = f"{one.needed:.3g} {one.unit}"
        yield CheckRow(
            DRIVE,
            quantity=f"hoist.{one.name}",
            value=value,
            bound=bound,
            holds=one.limit >= one.needed,
            problem=f"hoist.{one.name} = {value} must be at least {bound}, {one.cure}",
        )


def _motor_limits(hoist: Hoist, trip: Winding) -> Iterator[_DriveLimit]:
    inputs = RuleInputs(hoist, trip, hoist)
    speed = max(0.0, trip.speed - 0.5 * trip.acceleration**2 / trip.jerk)  # at full acceleration
    way = speed**2 / (2.0 * trip.acceleration)
    power = inputs.torque(way) * speed / hoist.sheave_radius
    cure = (
        "which speeding up with the payload asks for: raise it, or wind more gently "
        "(winding.acceleration, winding.speed)"
    )
    yield _DriveLimit("torque_limit", hoist.torque_limit, inputs.torque(), "N m", cure)
    yield _DriveLimit("power_limit", hoist.power_limit or math.inf, power, "W", cure)


def _brake_limits(hoist: Hoist, brake: Brake, trip: Winding) -> Iterator[_DriveLimit]:
    holding = hoist.sheave_radius * hoist.imbalance()
    cure = "which holds the heavier side: fit a stronger brake"
    yield _DriveLimit("brake.torque", brake.torque, holding, "N m", cure)
    first_torque = brake.first_stage * brake.torque
    if trip.emergency_law == "two-stage" and brake.torque >= holding:
        # the second stage holds what the first lets run
        yield _DriveLimit(
            "brake.first_stage",
            limit=brake.first_stage,
            needed=holding / brake.torque,
            unit="of brake.torque",
            cure=(
                f"of which the first stage gives {first_torque:.3g} N m to hold the heavier side: "
                f"until first_stage_time = {brake.first_stage_time:g} s it runs on; raise the "
                "first stage, or shorten it"
            ),
        )
