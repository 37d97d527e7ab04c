"""Parts of a hoist that a model may leave out: drive shaft, brake, lining, guides, play, a jam.

SI units, checked here.

A ``Hoist`` whose part is None lacks the part's equations; there are no stiff or weak dummies.
Masses "referred to the rope" are J / R^2 with the sheave's radius R.
"""

import math
from dataclasses import dataclass

from hoist_demo.parameters.quantity import FRACTION, NONNEGATIVE, ValidatedData, parameter


def require(value: float, holds: bool, name: str, bound: str, cure: str) -> None:
    """Raise a ValueError unless the value is finite and the bound holds."""
    if not (math.isfinite(value) and holds):
        raise ValueError(f"{name} = {value!r} must be {bound}: {cure}")


@dataclass(frozen=True)
class DriveShaft(ValidatedData, of="drive_shaft."):
    """Elastic shaft between motor and sheave; all values [assumed]."""

    motor_mass: float = parameter(
        3.0e3,
        "kg",
        "inertia of the motor's rotor referred to the rope, a part of hoist.sheave_mass",
    )
    stiffness: float = parameter(
        2.0e8, "N m/rad", "torsional stiffness of the shaft between motor and sheave"
    )
    damping: float = parameter(
        0.02, "-", "damping ratio of the motor against the sheave", NONNEGATIVE
    )


@dataclass(frozen=True)
class Brake(ValidatedData, of="brake."):
    """Disc brake on the sheave; all values [assumed].

    The torque asked for is a fraction of the full one. It comes after a dead time and with the lag
    of its hydraulics.
    """

    torque: float = parameter(5.5e5, "N m", "full braking torque in both directions of rotation")
    delay: float = parameter(
        0.15, "s", "time from the start of an emergency stop to the first torque", NONNEGATIVE
    )
    lag: float = parameter(0.10, "s", "time constant of the brake's pressure")
    travel: float = parameter(
        2.0e-3, "m", "elastic deflection at the rim of the stuck brake at its full torque"
    )
    first_stage: float = parameter(
        0.5, "-", "fraction of the torque in the first stage of a two-stage stop", FRACTION
    )
    first_stage_time: float = parameter(
        1.5, "s", "time from the start of an emergency stop to the second stage"
    )


@dataclass(frozen=True)
class SheaveLining(ValidatedData, of="lining."):
    """Lining of the sheave, on which the head ropes may slide; all values [assumed]."""

    sliding: float = parameter(
        0.8, "-", "friction coefficient of sliding ropes over that of ropes that hold", FRACTION
    )


@dataclass(frozen=True)
class Guides(ValidatedData, of="guides."):
    """Friction of one conveyance along its guides; all values [assumed]."""

    coulomb: float = parameter(
        1.0e3, "N", "Coulomb friction of one conveyance along its guides", NONNEGATIVE
    )
    viscous: float = parameter(
        50.0, "N s/m", "viscous friction of one conveyance along its guides", NONNEGATIVE
    )


@dataclass(frozen=True)
class Play(ValidatedData, of="play."):
    """Freedom of a conveyance between its guides: x, z and yaw; all values [assumed].

    Within the play the head ropes alone pull it back, a pendulum with several ropes; beyond it the
    shoes are springs.
    """

    clearance: float = parameter(
        5.0e-3, "m", "clearance between shoes and guides to either side, in x and in z", NONNEGATIVE
    )
    stiffness: float = parameter(2.0e6, "N/m", "stiffness of a conveyance's guides, in x and in z")
    contact_damping: float = parameter(
        0.5,
        "s/m",
        "damping force of a contact over its elastic force and speed (Hunt and Crossley)",
        NONNEGATIVE,
    )
    damping: float = parameter(
        500.0,
        "N s/m",
        "lateral damping of a conveyance by air and rollers, at any place",
        NONNEGATIVE,
    )
    arm: float = parameter(
        1.5,
        "m",
        "distance a from the conveyance's axis to the shoes: clearance and stiffness in yaw "
        "are c / a and k a^2",
    )
    gyration: float = parameter(
        1.2, "m", "radius of gyration of the loaded conveyance about the vertical"
    )
    rope_spread: float = parameter(
        0.4, "m", "radius of gyration of the head ropes' attachments about the vertical"
    )
    friction: float = parameter(
        0.1,
        "-",
        "friction coefficient of a shoe on its guide: contact brakes the conveyance along the"
        " guides",
        NONNEGATIVE,
    )


@dataclass(frozen=True)
class Jam(ValidatedData, of="jam."):
    """A place where its guides are too narrow for a conveyance: it catches there, and sticks.

    All values [assumed].

    The holding force rises from 0 at ``distance`` from the place to its full value at the place,
    and falls again: a conveyance that is pulled or carried through is free behind it.
    """

    height: float = parameter(
        45.0, "m", "height of the conveyance's suspension at the place of the jam", NONNEGATIVE
    )
    distance: float = parameter(
        2.0, "m", "distance up and down from the place to where the guides begin to hold"
    )
    force: float = parameter(8.0e5, "N", "force that holds the conveyance at the place of the jam")
    travel: float = parameter(
        0.01, "m", "elastic deflection of the stuck conveyance at its full force"
    )
    damping: float = parameter(
        5.0e-3, "s", "damping of the stuck conveyance over its stiffness", NONNEGATIVE
    )
