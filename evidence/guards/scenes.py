"""Ropes, swivels, shafts and trips from a seed; some of the ropes foul, most do not.

The ropes are those of deep shafts: a coupling of tension and torsion between a fiftieth of the published one and all of
it, swivels that turn with friction or are seized.  The shaft is a rectangle about two conveyances; half have a divider
through the loop.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from evidence.sampling import Draws
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding
from rope_model import (
    Contact,
    Conveyance,
    Divider,
    HeadRopes,
    Layout,
    Lining,
    Model,
    Rope,
    Scene,
    Shaft,
    Swivel,
    at_level,
)
from rope_model.physics.estimates import loop_width

#: one seed sets the thresholds, the other judges them
SET, JUDGE = 41, 42
LENGTH, MASS, BENDING, SPACING = (150.0, 900.0), (4.0, 12.0), (100.0, 800.0), (1.6, 2.6)  # m, kg/m, N m^2, m
#: share of the published coupling; coefficient of friction and share of the swivels that are seized
COUPLING, FRICTION, SEIZED = (0.02, 1.0), (0.05, 0.3), 0.4
SPEED, ACCELERATION, JERK = (5.0, 16.0), (0.5, 1.2), (0.3, 1.0)  # m/s, m/s^2, m/s^3
STOPPED, BEGIN, BRAKE = 0.4, (0.2, 0.8), (2.0, 5.0)  # share with an emergency stop, when (of the trip), m/s^2
#: m: from conveyances and loop to the lining, and of the lining from the plane of the ends; height of a divider above
#: the loop, and the share of shafts that have it
GAP, DEPTH, ABOVE, DIVIDED = (0.8, 3.0), (0.8, 3.0), (2.0, 8.0), 0.5
#: m: rope below the lower landing
SUMP = 25.0


@dataclass(frozen=True)
class Sample:
    """A rope in its shaft, and its trip."""

    seed: int
    number: int
    scene: Scene
    trip: Winding
    coupling: float  # share of the published one

    @property
    def is_seized(self) -> bool:
        """Neither swivel turns."""
        return self.scene.left.mode == "locked"


def draw(seed: int, number: int) -> Iterator[Sample]:
    """The first ``number`` of the seed."""
    draws = Draws(seed)
    evenly, in_logarithms = draws.evenly, draws.in_logarithms
    for k in range(number):
        length, mass, share = in_logarithms(LENGTH), evenly(MASS), in_logarithms(COUPLING)
        rope = _rope(length, mass, in_logarithms(BENDING), share)
        spacing, friction = evenly(SPACING), evenly(FRICTION)
        seized, divided, stopped = evenly() < SEIZED, evenly() < DIVIDED, evenly() < STOPPED
        swivel = Swivel("locked") if seized else Swivel("coulomb", mu_static=friction, mu_kinetic=0.8 * friction)
        scene = Scene(rope, Layout(spacing), swivel, swivel)
        shaft = _shaft(spacing, loop_width(scene), evenly(GAP), evenly(DEPTH), evenly(ABOVE) if divided else 0.0)
        scene = scene.with_(shaft=shaft)
        trip = Winding(
            travel=length - 2.0 * SUMP,
            speed=evenly(SPEED),
            acceleration=evenly(ACCELERATION),
            jerk=in_logarithms(JERK),
            start_delay=0.0,
        )
        begin, brake = evenly(BEGIN) * s_curve(trip).duration, evenly(BRAKE)
        if stopped:
            trip = replace(trip, emergency_at=begin, emergency_deceleration=brake)
        yield Sample(seed, k, at_level(scene, "draft").with_(model=Model("torsional")), trip, share)


def _rope(length: float, mass: float, EI: float, share: float) -> Rope:
    """Similar to the published one in its section, but for EI and the coupling."""
    s = (mass / 8.0) ** 0.5
    published = Rope()
    Qb = share * published.Qb * s**3
    return Rope(
        length=length,
        mass_per_length=mass,
        Qa=published.Qa * s**2,
        Qb=Qb,
        Qc=Qb,
        Qd=published.Qd * s**4,
        EI=EI,
        rhoJ=published.rhoJ * s**4,
        diameter=published.diameter * s,
    )


def _shaft(spacing: float, loop: float, gap: float, depth: float, above: float) -> Shaft:
    """The lining is ``gap`` (m) from conveyances and loop; a divider is ``above`` (m) the loop, or 0 for none.

    The loop's bottom is half a loop's width or so below the level SUMP - spacing under the lower landing.
    """
    wide = 0.8 * spacing
    return Shaft(
        lining=Lining(width=max(spacing + wide, loop) + 2.0 * gap, depth=2.0 * depth),
        conveyance=Conveyance(wide, depth, 4.0, 0.5),
        head_ropes=HeadRopes(0.03, 0.6),
        divider_1=Divider(size=0.2 if above else 0.0, y=above - SUMP),
        contact=Contact(stiffness=0.0),  # up to the first touch it is the same, and that is the end
    )
