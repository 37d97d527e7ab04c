"""Data of the hoist, of the winding and of the coupling: SI units, checked once, here.

All numbers of the hoist are ours [assumed]: plausible for a friction hoist of 90 m travel with 10 t conveyances and
5 t payload over the 120 m balance rope of 8 kg/m, and taken from no particular installation.

The shaft. Heights y point up and are those of the rope suspension under a conveyance. The lower landing is y = 0 m,
the upper one y = shaft_travel, and the sheave axis is head_rope_length_up above that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from hoist_demo.components import Brake, Guides, Play, Shaft, require, require_magnitudes
from hoist_demo.quantity import quantity

GRAVITY = 9.81
"""Acceleration of free fall [m/s^2]."""

ASSUMED_DATA = (
    "The hoist, the winding and the rope data marked [assumed] in docs/model.md and docs/hoist.md are ours. They are "
    "plausible, they belong to no installation, and no number shown here may be used to judge one."
)
"""Said wherever results are shown."""


@dataclass(frozen=True)
class Hoist:
    """Friction (Koepe) hoist with its motor on the sheave; all values [assumed].

    What is None or 0 among the last lines is left out of the equations.
    """

    conveyance_mass: float = quantity(10.0e3, "kg", "each conveyance with its attachments")
    payload_left: float = quantity(5.0e3, "kg")
    payload_right: float = quantity(0.0, "kg")
    sheave_mass: float = quantity(8.0e3, "kg", "inertia of sheave and motor referred to the rope, J / R^2")
    sheave_radius: float = quantity(1.25, "m")
    torque_lag: float = quantity(0.05, "s", "time constant of the motor torque")
    torque_limit: float = quantity(2.2e5, "N m", "motor with service brake")
    head_rope_number: int = quantity(4, "-")
    head_rope_stiffness: float = quantity(2.6e7, "N", "EA of one rope")
    head_rope_mass: float = quantity(2.0, "kg/m", "of one rope")
    head_rope_damping: float = quantity(0.03, "-", "damping ratio of a conveyance on its ropes")
    head_rope_length_up: float = quantity(15.0, "m", "sheave axis above a conveyance at the upper landing")
    loss_coulomb: float = quantity(4.0e3, "N", "at the sheave's rim")
    loss_viscous: float = quantity(200.0, "N s/m", "at the sheave's rim")
    loss_speed: float = quantity(0.02, "m/s", "width of the smooth Coulomb law F tanh(v / loss_speed)")
    friction_coefficient: float = quantity(0.25, "-", "rope on lining")
    wrap_angle: float = quantity(math.pi, "rad")
    shaft_travel: float = quantity(90.0, "m", "between the landings")
    tail_rope_mass: float = quantity(8.0, "kg/m", "of one balance rope: feed-forward and static tensions use it")
    tail_rope_length: float = quantity(120.0, "m", "likewise")
    tail_rope_number: int = quantity(
        1, "-", "equal balance ropes; each pulls with the force of the one that is computed"
    )
    conveyance_mass_right: float | None = quantity(
        None, "kg", "of a counterweight or another conveyance; None: as the left one"
    )
    power_limit: float | None = quantity(None, "W", "of the motor and its converter, in both directions")
    head_rope_modes: int = quantity(0, "-", "longitudinal modes of the head ropes of a side, beyond their mean strain")
    shaft: Shaft | None = quantity(None, "", "none: rigid")
    brake: Brake | None = quantity(None, "", "none: no brake but the motor")
    guides: Guides | None = quantity(None, "", "none: no friction along the guides")
    play: Play | None = quantity(None, "", "none: conveyances move along straight lines")

    def __post_init__(self) -> None:
        may_vanish = {"payload_left", "payload_right", "head_rope_damping", "loss_coulomb", "loss_viscous"}
        require_magnitudes(self, may_vanish | {"tail_rope_mass", "tail_rope_length", "head_rope_modes"})
        for name, cure in (
            ("head_rope_number", "count the ropes"),
            ("tail_rope_number", "count the ropes"),
            ("head_rope_modes", "2 suit most studies, 0 leaves them out"),
        ):
            value = getattr(self, name)
            require(value, value == int(value) and value <= 20, name, "a whole number up to 20", cure)
        if self.shaft is not None:
            require(
                self.shaft.motor_mass,
                self.shaft.motor_mass < self.sheave_mass,
                "shaft.motor_mass",
                f"below sheave_mass = {self.sheave_mass:g} kg, which contains it",
                "give the motor's share",
            )

    @property
    def rope_stiffness(self) -> float:
        """EA of all head ropes [N]."""
        return self.head_rope_number * self.head_rope_stiffness

    @property
    def rope_mass(self) -> float:
        """Mass per length of all head ropes [kg/m]."""
        return self.head_rope_number * self.head_rope_mass

    @property
    def tail_mass(self) -> float:
        """Mass per length of all balance ropes [kg/m]."""
        return self.tail_rope_number * self.tail_rope_mass

    @property
    def tail_balance(self) -> float:
        """Balance ropes' mass per length over that of the head ropes [-]; 1 keeps the motor torque at rest constant."""
        return self.tail_mass / self.rope_mass

    @property
    def mass_left(self) -> float:
        """Left conveyance with its payload [kg]."""
        return self.conveyance_mass + self.payload_left

    @property
    def mass_right(self) -> float:
        """Right conveyance with its payload [kg]."""
        empty = self.conveyance_mass if self.conveyance_mass_right is None else self.conveyance_mass_right
        return empty + self.payload_right

    @property
    def sheave_height(self) -> float:
        """Height of the sheave's axis [m]."""
        return self.shaft_travel + self.head_rope_length_up

    @property
    def moving_mass(self) -> float:
        """All moving masses referred to the rope [kg], the balance ropes' included."""
        ropes = self.rope_mass * (self.shaft_travel + 2.0 * self.head_rope_length_up)
        tail = self.tail_mass * self.tail_rope_length
        return self.sheave_mass + self.mass_left + self.mass_right + ropes + tail

    @property
    def travel_loss(self) -> tuple[float, float]:
        """Coulomb [N] and viscous [N s/m] friction at the rim and along the guides of both conveyances."""
        guides = self.guides
        if guides is None:
            return self.loss_coulomb, self.loss_viscous
        return self.loss_coulomb + 2.0 * guides.coulomb, self.loss_viscous + 2.0 * guides.viscous

    @property
    def imbalance_rate(self) -> float:
        """Change of the force that holds the hoist, per metre of travel of the left conveyance [N/m]."""
        return 2.0 * GRAVITY * (self.tail_mass - self.rope_mass)

    @property
    def tension_ratio_limit(self) -> float:
        """Tension ratio at which the ropes slip on the sheave, exp(mu alpha) (Euler-Eytelwein) [-]."""
        return math.exp(self.friction_coefficient * self.wrap_angle)

    def slip_safety(self, ratio: float) -> float:
        """Friction that there is over friction that a tension ratio asks for, (exp(mu alpha) - 1) / (ratio - 1) [-]."""
        return (self.tension_ratio_limit - 1.0) / (ratio - 1.0) if ratio > 1.0 else math.inf

    def torque_available(self, rate: float) -> float:
        """Largest torque of the motor [N m] at a speed of rotation [rad/s], by torque and power."""
        if self.power_limit is None:
            return self.torque_limit
        return self.power_limit / max(abs(rate), self.power_limit / self.torque_limit)


EmergencyLaw = Literal["drive", "deceleration", "torque", "two-stage"]
"""Who stops the hoist: the drive along its reference, or the brake with a regulated deceleration, its full torque, or
a part of it first and the whole later."""


@dataclass(frozen=True)
class Winding:
    """One trip of the left conveyance, up when travel is positive, with waiting times before and after."""

    travel: float = quantity(90.0, "m", "negative lowers")
    speed: float = quantity(8.0, "m/s", "limit")
    acceleration: float = quantity(0.75, "m/s^2", "limit")
    jerk: float = quantity(0.5, "m/s^3", "limit")
    creep_speed: float = quantity(0.5, "m/s", "of a creep, where there is one")
    creep_distance: float = quantity(
        0.0, "m", "to the landing from where creep speed is reached, final stop included; 0: no creep"
    )
    departure_creep_distance: float = quantity(0.0, "m", "from the start to where creep speed is left; 0: no creep")
    start_delay: float = quantity(1.0, "s")
    settle: float = quantity(10.0, "s", "recorded after the reference has arrived")
    emergency_at: float | None = quantity(None, "s", "emergency stop begins; None: no emergency stop")
    emergency_deceleration: float = quantity(5.0, "m/s^2")
    emergency_jerk: float = quantity(50.0, "m/s^3", "the short ramp of the emergency deceleration")
    emergency_law: EmergencyLaw = "drive"

    def __post_init__(self) -> None:
        require(self.travel, self.travel != 0.0, "travel", "finite and not 0", "give the length of the trip in m")
        for name in ("speed", "acceleration", "jerk"):
            value = getattr(self, name)
            require(value, value > 0.0, name, "finite and above 0", "give the limit's magnitude")
        for name in ("start_delay", "settle"):
            value = getattr(self, name)
            require(value, value >= 0.0, name, "finite and at least 0", "give a waiting time in s")
        for name in ("creep_distance", "departure_creep_distance"):
            value = getattr(self, name)
            require(value, value >= 0.0, name, "finite and at least 0", "give a length in m, 0 for no creep")
        require(
            self.creep_speed,
            self.creep_speed > 0.0 and (not self.creeps or self.creep_speed <= self.speed),
            "creep_speed",
            f"above 0 and at most the speed limit {self.speed:g} m/s",
            "creep more slowly",
        )
        if self.emergency_law not in get_args(EmergencyLaw):
            known = ", ".join(get_args(EmergencyLaw))
            raise ValueError(f"emergency_law = {self.emergency_law!r} must be one of {known}: choose one")
        if self.emergency_at is not None:
            require(self.emergency_at, self.emergency_at >= 0.0, "emergency_at", "at least 0", "give a time in s")
        require(
            self.emergency_deceleration,
            self.emergency_deceleration >= self.acceleration,
            "emergency_deceleration",
            f"at least the acceleration limit {self.acceleration:g} m/s^2",
            "brake harder or wind more gently",
        )
        require(
            self.emergency_jerk,
            self.emergency_jerk >= self.jerk,
            "emergency_jerk",
            f"at least the jerk limit {self.jerk:g} m/s^3",
            "shorten the brake's ramp",
        )

    @property
    def creeps(self) -> bool:
        """Whether some of the trip is run at creep speed."""
        return self.creep_distance > 0.0 or self.departure_creep_distance > 0.0

    @property
    def followed_until(self) -> float:
        """Time [s] until which the drive follows the reference: an emergency stop with the brake ends that."""
        return math.inf if self.emergency_at is None or self.emergency_law == "drive" else self.emergency_at


@dataclass(frozen=True)
class Coupling:
    """How drive and rope exchange their data."""

    step: float = quantity(0.01, "s", "communication step H")
    start: float = quantity(0.0, "s")
    scheme: str = "gauss-seidel-1"  # one of hoist_demo.coupling.catalogue
    sample: float | None = quantity(
        None, "s", "sample time of controller and recording, a multiple of step; None: the step"
    )

    def __post_init__(self) -> None:
        require(self.step, 0.0 < self.step <= 0.1, "step", "above 0 and at most 0.1 s", "take 0.005 to 0.02 s")
        require(self.start, True, "start", "finite", "give a time in s")
        require(
            self.sample_time,
            self.per_sample >= 1 and abs(self.per_sample * self.step - self.sample_time) <= 1e-9 * self.sample_time,
            "sample",
            f"a multiple of the communication step {self.step:g} s",
            "take the step itself, or twice or thrice",
        )

    @property
    def sample_time(self) -> float:
        """Sample time of controller and recording [s]."""
        return self.step if self.sample is None else self.sample

    @property
    def per_sample(self) -> int:
        """Communication steps from one sample to the next."""
        return round(self.sample_time / self.step)


def require_trip_fits(hoist: Hoist, winding: Winding) -> None:
    """Reject a trip longer than the shaft, and an emergency stop with a brake that is not there or too weak."""
    require(
        winding.travel,
        abs(winding.travel) <= hoist.shaft_travel,
        "travel",
        f"within +- shaft_travel = {hoist.shaft_travel:g} m",
        "shorten the trip",
    )
    if winding.emergency_at is None or winding.emergency_law == "drive":
        return
    if hoist.brake is None:
        raise ValueError(
            f"emergency_law = {winding.emergency_law!r} must be 'drive' for a hoist without a brake: give it a brake"
        )
    deceleration, capacity = winding.emergency_deceleration, hoist.brake.torque / hoist.sheave_radius
    require(
        deceleration,
        winding.emergency_law != "deceleration" or deceleration * hoist.moving_mass <= capacity,
        "emergency_deceleration",
        f"at most {capacity / hoist.moving_mass:.3g} m/s^2, what brake.torque gives all moving masses",
        "brake more gently or fit a stronger brake",
    )


@dataclass(frozen=True)
class Setup:
    """Hoist and winding that belong to a scene of the balance rope."""

    hoist: Hoist
    winding: Winding


SETUPS = {
    "rope-120": Setup(Hoist(), Winding()),
    "rope-240": Setup(Hoist(shaft_travel=200.0, tail_rope_length=240.0), Winding(travel=200.0, speed=10.0)),
}
