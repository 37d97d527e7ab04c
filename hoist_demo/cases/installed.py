"""Cases of the size of installed hoists: hoist, winding, controller, and the balance rope that belongs to them.

`published` tells what the source states; those numbers stand as such in INSTALLED. Everything else is ours [assumed]:
the empty conveyances and the depth where none are given, acceleration and jerk, head ropes, inertias, shaft, brake
(three times the torque of the payload), guides, losses, friction, spacing, and balance ropes that balance the head
ropes exactly. Deflection sheaves and what they change in wrap and length are left out. So a case is a hoist of that
size and not that hoist, and no number computed with it may be used to judge the installation.

The stiffnesses of a balance rope follow from the known one of 44 mm and 8 kg/m by geometric similarity, with its
diameter d = 44 mm sqrt(m / 8): Qa ~ d^2, Qb and Qc ~ d^3, Qd, EI and rhoJ ~ d^4. Of Qb and Qc a rope has a share that
its lay decides; here it is COUPLING.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from hoist_demo.cases.case import LOCKED, Case, swivels
from hoist_demo.control.controller import Gains
from hoist_demo.parameters import GRAVITY, Hoist, Winding
from hoist_demo.parameters.components import Brake, DriveShaft, Guides, Play
from rope_model.parameters import Rope

_KIRUNA = (
    "ABB, 'LKAB Kiruna's new haulage level: ABB mine hoist upgrade for production increase', table of hoist data; "
    "https://paperzz.com/doc/7036438/lkab-kiruna-s-new-haulage-level-abb-mine-hoist-upgrade-for"
)
_PALABORA = (
    "Palabora Mining Company, 'Underground fixed plant'; "
    "http://www.palabora.com/Our-Activities/Our-operations/UG-Mining-Lift-I/Underground-fixed-plant"
)
_MONOPOL = "pro-bergbau, 'Die Foerdermaschine'; http://pro-bergbau.de/grubenfahrt/foerdermaschine.html"
_ROBERT = (
    "pro-bergbau, tour of the Heinrich Robert colliery; http://pro-bergbau.de/bilder/hrtour/hreinfachdaten.html and "
    "http://pro-bergbau.de/bilder/hrtour/hrdoppeldaten.html"
)

TAIL_SPARE = 40.0  #: Length of a balance rope beyond the travel [m, assumed]: loop, and sump below the lower landing.

_OF_MACHINE = ("winding.speed", "hoist.sheave_radius", "hoist.head_rope_number", "hoist.payload_left")

#: Qb and Qc of an installed size's balance rope over those of a rope similar to the known one [-, assumed].  Balance
#: ropes of deep shafts are made to turn little. With the known rope's coupling, the weight of 1000 m held at both ends
#: would turn the loop through more than a full turn before it moves: the legs would pass through each other.
COUPLING = 0.1


def round_rope(length: float, mass_per_length: float, spacing: float, coupling: float) -> dict[str, float]:
    """Parameters by FMI name of a rope similar to the known one, from length [m], mass [kg/m] and spacing [m].

    `coupling` is the share of the similar rope's Qb and Qc that this one has [-]: 1 keeps them, COUPLING suits deep
    shafts, 0 makes a rope without torque. The yaw at rest grows with it and with the length.
    """
    known = Rope()
    s = math.sqrt(mass_per_length / known.mass_per_length)
    return {
        "rope.length": length,
        "rope.mass_per_length": mass_per_length,
        "rope.Qa": known.Qa * s**2,
        "rope.Qb": coupling * known.Qb * s**3,
        "rope.Qc": coupling * known.Qc * s**3,
        "rope.Qd": known.Qd * s**4,
        "rope.EI": known.EI * s**4,
        "rope.rhoJ": known.rhoJ * s**4,
        "rope.diameter": known.diameter * s,
        "layout.spacing": spacing,
    }


class _Machine(NamedTuple):
    """Data of an installed hoist."""

    travel: float  # m
    speed: float  # m/s
    payload: float  # kg
    conveyance: float  # kg
    diameter: float  # m, of the sheave
    rated_power: float  # W
    head_ropes: tuple[int, float]  # their number, and the mass per length of one [kg/m]
    tail_ropes: int
    sheave_mass: float  # kg
    acceleration: float  # m/s^2
    length_up: float  # m, sheave above a conveyance at the upper landing


def _installed_case(machine: _Machine, source: str, published: str, *stated: str) -> Case:
    """Case of a machine, with what its source states in words and by the names of a study.

    [assumed] A peak torque and power of twice the rated ones, EA of 13 MN per kg/m (a modulus of 110 GPa of the steel),
    a shaft of 12 Hz, two modes of the head ropes, 2.4 m between the conveyances.
    """
    m, radius, (number, mass) = machine, machine.diameter / 2.0, machine.head_ropes
    tail_mass = number * mass / m.tail_ropes
    motor_mass = 0.4 * m.sheave_mass
    reduced = motor_mass * (m.sheave_mass - motor_mass) / m.sheave_mass * radius**2
    hoist = Hoist(
        conveyance_mass=m.conveyance,
        payload_left=m.payload,
        sheave_mass=m.sheave_mass,
        sheave_radius=radius,
        torque_limit=2.0 * m.rated_power / (m.speed / radius),
        power_limit=2.0 * m.rated_power,
        head_rope_number=number,
        head_rope_mass=mass,
        head_rope_stiffness=1.3e7 * mass,
        head_rope_damping=0.02,
        head_rope_length_up=m.length_up,
        head_rope_modes=2,
        loss_coulomb=0.01 * m.conveyance * GRAVITY,
        loss_viscous=0.02 * m.payload,
        shaft_travel=m.travel,
        tail_rope_mass=tail_mass,
        tail_rope_length=m.travel + TAIL_SPARE,
        tail_rope_number=m.tail_ropes,
        drive_shaft=DriveShaft(motor_mass=motor_mass, stiffness=(2.0 * math.pi * 12.0) ** 2 * reduced),
        brake=Brake(torque=3.0 * (m.payload * GRAVITY * radius)),
        guides=Guides(coulomb=0.005 * m.conveyance * GRAVITY, viscous=0.01 * m.payload),
        play=Play(),
    )
    winding = Winding(m.travel, m.speed, m.acceleration, jerk=0.5, settle=15.0, emergency_deceleration=2.0)
    gains = Gains(speed=3.0 * hoist.moving_mass, integral_time=2.0, position=0.5)
    rope = round_rope(m.travel + TAIL_SPARE, tail_mass, 2.4, COUPLING) | swivels(LOCKED)
    return Case(hoist, winding, gains, rope, published, stated, source)


_OF_KIRUNA = (*_OF_MACHINE, "hoist.shaft_travel", "winding.travel", "hoist.conveyance_mass")
INSTALLED = {
    "kiruna-355": _installed_case(
        _Machine(355.0, 11.0, 30.0e3, 36.5e3, 3.25, 5.6e6, (6, 5.6), 3, 35.0e3, 0.9, 40.0),
        _KIRUNA,
        "hoisting distance 355 m, 11 m/s, pulley 3.25 m, 6 head ropes, two skips, payload 30 t, skip with "
        "rope attachment 36.5 t, motor 5600 kW at 64.7 rpm",
        *_OF_KIRUNA,
    ),
    "kiruna-710": _installed_case(
        _Machine(710.0, 17.0, 34.0e3, 40.0e3, 3.25, 5.6e6, (6, 5.6), 3, 35.0e3, 0.9, 40.0),
        _KIRUNA,
        "hoisting distance 710 m, 17 m/s, pulley 3.25 m, 6 head ropes, two skips, payload 34 t, skip with "
        "rope attachment 40 t, motor 5600 kW at 100 rpm",
        *_OF_KIRUNA,
    ),
    "monopol-1000": _installed_case(
        _Machine(1000.0, 16.0, 20.0e3, 22.0e3, 6.5, 4.2e6, (3, 9.5), 2, 32.0e3, 0.8, 70.0),
        _MONOPOL,
        "16 m/s, driving wheel 6.5 m, 3 head ropes, payload of the skips up to 20 t (of the machine 27 t); "
        "no depth: 1000 m is ours",
        *_OF_MACHINE,
    ),
    "robert-1096": _installed_case(
        _Machine(1096.0, 17.0, 18.0e3, 20.0e3, 7.0, 4.0e6, (1, 19.5), 1, 32.0e3, 0.8, 70.0),
        _ROBERT,
        "driving wheel 7 m, head rope 19.5 kg/m over 1096 m, payload 18 t, 17 m/s; that the 1096 m are the "
        "travel and that there is one rope is our reading",
        *("winding.speed", "hoist.sheave_radius", "hoist.payload_left", "hoist.head_rope_mass"),
    ),
    "palabora-1282": _installed_case(
        _Machine(1282.0, 18.0, 32.0e3, 34.0e3, 6.0, 6.0e6, (4, 9.0), 3, 45.0e3, 0.8, 60.0),
        _PALABORA,
        "total length of wind 1282 m, 18 m/s, payload 32 t, motor 6000 kW, a cycle of 118 s, tower 106 m",
        *("winding.speed", "hoist.payload_left", "hoist.shaft_travel", "winding.travel"),
    ),
}
