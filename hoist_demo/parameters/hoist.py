"""Parameters of the hoist, and the quantities that follow from them.

All numbers of the hoist are ours [assumed]: plausible for a friction hoist of 90 m travel with 10 t
conveyances and 5 t payload over the 120 m balance rope of 8 kg/m, and taken from no particular
installation.

The shaft. Heights y point up and are those of the rope suspension under a conveyance. The lower
landing is y = 0 m, the upper one y = shaft_travel, and the sheave axis is head_rope_length_up above
that.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import repeat
from typing import Any, TypeVar

import numpy as np

from hoist_demo.parameters.components import (
    Brake,
    DriveShaft,
    Guides,
    Jam,
    Play,
    SheaveLining,
    require,
)
from hoist_demo.parameters.quantity import NONNEGATIVE, NumberRange, ValidatedData, parameter
from rope_model.physics.elementary import Scalar, maximum, sum_of

GRAVITY = 9.81  #: Acceleration of free fall [m/s^2].

#: Said wherever results are shown.
ASSUMED_DATA = (
    "Data of hoist, winding and rope that are marked [assumed] have no published source. They are "
    "plausible, they belong to no installation: put in your own before you judge an installation "
    "by the numbers shown here."
)

#: bounds far beyond any hoist: what is out of them has another unit
_MODES = NumberRange(0, 20, cure="2 suit most studies, 0 leaves them out")
_COUNT = NumberRange(1, 20, cure="count the ropes")
_STIFFNESS = NumberRange(1e5, 1e10, cure="give EA of one rope in N: 26 MN are 2.6e7")
_FRICTION = NumberRange(0.01, 2.0, cure="give it as a pure number: 25 % are 0.25")
_ANGLE = NumberRange(0.1, 4.0 * math.pi, cure="give it in rad: 180 degrees are 3.1416")


@dataclass(frozen=True)
class Hoist(ValidatedData):
    """Friction (Koepe) hoist with its motor on the sheave, without parts that are None or 0.

    All values [assumed].
    """

    conveyance_mass: float = parameter(10.0e3, "kg", "mass of each conveyance with its attachments")
    payload_left: float = parameter(5.0e3, "kg", "payload in the left conveyance", NONNEGATIVE)
    payload_right: float = parameter(0.0, "kg", "payload in the right conveyance", NONNEGATIVE)
    sheave_mass: float = parameter(
        8.0e3, "kg", "inertia of sheave and motor referred to the rope, J / R^2"
    )
    sheave_radius: float = parameter(1.25, "m", "radius of the sheave")
    torque_lag: float = parameter(0.05, "s", "time constant of the motor torque")
    torque_limit: float = parameter(
        2.2e5, "N m", "largest torque of the motor together with the service brake"
    )
    head_rope_number: int = parameter(4, "-", "number of head ropes", _COUNT)
    head_rope_stiffness: float = parameter(
        2.6e7, "N", "axial stiffness EA of one head rope", _STIFFNESS
    )
    head_rope_mass: float = parameter(2.0, "kg/m", "mass per length of one head rope")
    head_rope_damping: float = parameter(
        0.03, "-", "damping ratio of a conveyance that vibrates on its head ropes", NONNEGATIVE
    )
    head_rope_length_up: float = parameter(
        15.0, "m", "height of the sheave's axis above a conveyance at the upper landing"
    )
    loss_coulomb: float = parameter(4.0e3, "N", "Coulomb friction at the sheave's rim", NONNEGATIVE)
    loss_viscous: float = parameter(
        200.0, "N s/m", "viscous friction at the sheave's rim", NONNEGATIVE
    )
    loss_speed: float = parameter(
        0.02, "m/s", "width of the smooth Coulomb law F tanh(v / loss_speed)"
    )
    friction_coefficient: float = parameter(
        0.25, "-", "friction coefficient of the head ropes on the lining", _FRICTION
    )
    wrap_angle: float = parameter(
        math.pi, "rad", "angle of the sheave that the head ropes wrap", _ANGLE
    )
    shaft_travel: float = parameter(90.0, "m", "distance between the landings")
    tail_rope_mass: float = parameter(
        8.0,
        "kg/m",
        "mass per length of one balance rope, or of all together where they differ; for "
        "feed-forward and statics",
        NONNEGATIVE,
    )
    tail_rope_length: float = parameter(
        120.0,
        "m",
        "length of one balance rope, or the mean by mass where they differ; for feed-forward "
        "and statics",
        NONNEGATIVE,
    )
    tail_rope_number: int = parameter(
        1,
        "-",
        "number of equal balance ropes, of which one is computed; 1 where they differ",
        _COUNT,
    )
    conveyance_mass_right: float | None = parameter(
        None,
        "kg",
        "mass of a counterweight, or of a right conveyance that differs from the left one; "
        "left out: as the left one",
    )
    power_limit: float | None = parameter(
        None, "W", "largest power of the motor and its converter, in both directions"
    )
    head_rope_modes: int = parameter(
        0,
        "-",
        "number of longitudinal modes of a side's head ropes, beyond their mean strain",
        _MODES,
    )
    drive_shaft: DriveShaft | None = parameter(
        None, "", "shaft between motor and sheave; left out: rigid"
    )
    brake: Brake | None = parameter(
        None, "", "brake on the sheave; left out: only the motor brakes"
    )
    lining: SheaveLining | None = parameter(
        None, "", "lining on which the head ropes may slide; left out: they hold whatever they pull"
    )
    guides: Guides | None = parameter(None, "", "friction along the guides; left out: none")
    play: Play | None = parameter(
        None,
        "",
        "play of the conveyances between their guides; left out: they move along straight lines",
    )
    jam_left: Jam | None = parameter(
        None, "", "place where the left conveyance jams; left out: it passes everywhere"
    )
    jam_right: Jam | None = parameter(
        None, "", "place where the right conveyance jams; left out: it passes everywhere"
    )
    slack_tension: float | None = parameter(
        None,
        "N",
        "tension of the head ropes at either conveyance below which the safety circuit opens;"
        " left out: not watched",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.drive_shaft is not None:
            motor_mass = self.drive_shaft.motor_mass
            require(
                motor_mass,
                motor_mass < self.sheave_mass,
                name="drive_shaft.motor_mass",
                bound=f"below sheave_mass = {self.sheave_mass:g} kg, which contains it",
                cure="give the motor's share",
            )
        for name in ("jam_left", "jam_right"):
            jam = getattr(self, name)
            if jam is not None:
                require(
                    jam.height,
                    jam.height <= self.shaft_travel,
                    name=f"{name}.height",
                    bound=f"within 0 and shaft_travel = {self.shaft_travel:g} m",
                    cure="give a place that it passes",
                )
        if self.slack_tension is not None:
            lightest = GRAVITY * min(self.mass_left, self.mass_right)
            require(
                self.slack_tension,
                self.slack_tension < lightest,
                name="slack_tension",
                bound=f"below {lightest:.6g} N, the weight of the lighter conveyance",
                cure="give a part of it",
            )

    @property
    def equation_structure(self) -> "Hoist":
        """Hoist with all numbers 0 but the count of modes: one for hoists of equal equations."""
        return with_numbers(self, repeat(0.0))

    @property
    def numbers(self) -> list[float]:
        """Numbers that ``equation_structure`` leaves out, components' in their places."""
        return list(_numbers(self))

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
    def mass_left(self) -> float:
        """Left conveyance with its payload [kg]."""
        return self.conveyance_mass + self.payload_left

    @property
    def mass_right(self) -> float:
        """Right conveyance with its payload [kg]."""
        if self.conveyance_mass_right is None:
            return self.conveyance_mass + self.payload_right
        return self.conveyance_mass_right + self.payload_right

    @property
    def sheave_height(self) -> float:
        """Height of the sheave's axis [m]."""
        return self.shaft_travel + self.head_rope_length_up

    @property
    def moving_mass(self) -> float:
        """Sum of the moving masses referred to the rope [kg], the balance ropes' included."""
        ropes = self.rope_mass * (self.shaft_travel + 2.0 * self.head_rope_length_up)
        balance_ropes = self.tail_mass * self.tail_rope_length
        return self.sheave_mass + self.mass_left + self.mass_right + ropes + balance_ropes

    @property
    def travel_loss(self) -> tuple[float, float]:
        """Coulomb [N] and viscous [N s/m] friction at the rim and along all guides."""
        guides = self.guides
        if guides is None:
            return self.loss_coulomb, self.loss_viscous
        return self.loss_coulomb + 2.0 * guides.coulomb, self.loss_viscous + 2.0 * guides.viscous

    @property
    def imbalance_rate(self) -> float:
        """Change of the holding force per metre of the left conveyance's travel [N/m]."""
        return 2.0 * GRAVITY * (self.tail_mass - self.rope_mass)

    def imbalance(self, travelled: float = 0.0) -> float:
        """Return the sides' largest difference of weights [N], ``travelled`` m from a landing."""
        ropes = abs(self.imbalance_rate * (0.5 * self.shaft_travel - travelled))
        return GRAVITY * abs(self.mass_left - self.mass_right) + ropes

    @property
    def tension_ratio_limit(self) -> float:
        """Tension ratio at which ropes slip on the sheave, exp(mu alpha) (Euler-Eytelwein)."""
        return math.exp(self.friction_coefficient * self.wrap_angle)

    def slip_safety(self, ratio: Scalar) -> Any:
        """Return friction over required friction, (exp(mu alpha) - 1) / (ratio - 1)."""
        excess = np.asarray(ratio - 1.0)
        limit = self.tension_ratio_limit - 1.0
        safety = np.divide(limit, excess, out=np.full(excess.shape, np.inf), where=excess > 0.0)
        if safety.ndim:
            return safety
        return float(safety)

    def torque_available(self, rate: Scalar) -> Scalar:
        """Return the largest torque of the motor [N m] at a speed of rotation [rad/s].

        Limits of torque and power hold. The speed may be a symbol.
        """
        if self.power_limit is None:
            return self.torque_limit
        return self.power_limit / maximum(abs(rate), self.power_limit / self.torque_limit)


T = TypeVar("T")


def with_numbers(data: T, numbers: Iterable[Any]) -> T:
    """Return a hoist or a part of it with other numbers, or symbols, in their places.

    None of them is checked.
    """
    remaining = iter(numbers)
    unchecked = object.__new__(type(data))
    unchecked.__dict__.update(vars(data))
    for name, value in _items(data):
        if is_dataclass(value):
            unchecked.__dict__[name] = with_numbers(value, remaining)
        else:
            unchecked.__dict__[name] = next(remaining)
    return unchecked


def _numbers(data: Any) -> Iterator[float]:
    for _, value in _items(data):
        if is_dataclass(value):
            yield from _numbers(value)
        else:
            yield float(value)


def _items(data: Any) -> list[tuple[str, Any]]:
    """Return numbers and parts of a hoist or of a part of it, with their names.

    The count of modes and values of None are left out.
    """
    names = [field.name for field in fields(data) if field.name != "head_rope_modes"]
    pairs = [(name, getattr(data, name)) for name in names]
    return [(name, value) for name, value in pairs if value is not None]


def hoist_with(hoist: Hoist, ropes: Sequence[tuple[float, float]]) -> Hoist:
    """Return the hoist with its balance ropes as one rope of their mass.

    ``ropes`` has the mass per length [kg/m] and the length [m] of each.
    """
    mass = sum_of(m for m, _ in ropes)
    length = sum_of(m * x for m, x in ropes) / mass
    return replace(hoist, tail_rope_number=1, tail_rope_mass=mass, tail_rope_length=length)
