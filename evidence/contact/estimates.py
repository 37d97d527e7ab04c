"""Fit the constants of physics.contact_error on random trips past a divider, and judge them on others.

``python -m evidence.contact.estimates``: two minutes.  Each trip is run on the fitted mesh and on that of the same rope
without a divider, against 4 equal elements per metre and steps of 4 ms.  A constant is the geometric mean of what the
errors of the first draw ask for where contact makes most of them.
"""

import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import chain
from typing import NamedTuple

import numpy as np

from evidence.contact.brush import FITTED, Brush, Trip, brush, errors
from evidence.sampling import BENDING, MASS, SPACING, STIFFNESS, Draws
from rope_model.parameters import Layout, Rope, Scene
from rope_model.physics import contact_error
from rope_model.physics.contact_error import add_contact_end_error, add_contact_loop_error
from rope_model.reference.mesh import fitted
from rope_model.shaft_parameters import Contact, Divider, Shaft
from rope_model.solver_parameters import Mesh

#: seeds of the trips that the constants are fitted to and judged on, so many of each
FIT = 50
JUDGE = 51
NUMBER = 18
#: N: trips that press less are left out
LEAST = 5.0
#: m/s^2, and how much larger the acceleration is than the rise over the square of its time
ACCELERATION = (0.5, 2.5)
FASTEST = 5.77
NAMES = ("AT_ENDS", "OF_PLACE")


class Asked(NamedTuple):
    """An error, its estimate without contact, and what contact adds to that with a constant of 1."""

    error: float
    rest: float
    contact: float

    @property
    def constant(self) -> float:
        """The constant that makes the estimate equal the error; NaN where contact is the lesser part."""
        return (
            math.sqrt(self.error**2 - self.rest**2) / self.contact
            if self.error > 1.5 * self.rest
            else math.nan
        )


def draw(seed: int, number: int) -> Iterator[Trip]:
    """Ropes of 60 to 150 m, and dividers that legs hang on, by up to 60 mm, or beside, by up to 30 mm."""
    draws = Draws(seed)
    evenly = draws.evenly
    in_logarithms = draws.in_logarithms
    for _ in range(number):
        length = in_logarithms((60.0, 150.0))
        mass = evenly(MASS)
        spacing = evenly(SPACING)
        axial = mass * in_logarithms(STIFFNESS)
        rope = Rope(
            length=length, mass_per_length=mass, EI=in_logarithms(BENDING), Qa=axial, Qb=0.0, Qc=0.0
        )
        size = evenly((0.03, 0.2))
        gap = evenly((-0.06, 0.03))
        side = (-1.0, 1.0)[draws.one_of(2)]
        offset = side * (0.5 * (spacing - size - rope.diameter) - gap)
        divider = Divider(size=size, y=-length * evenly((0.12, 0.4)), offset=offset)
        rise = length * evenly((0.15, 0.35))
        moves = math.sqrt(FASTEST * rise / evenly(ACCELERATION))
        shaft = Shaft(divider_1=divider, contact=Contact(stiffness=in_logarithms((3e5, 3e6))))
        yield Trip(Scene(rope, Layout(spacing), shaft=shaft), rise, moves, moves + 1.0)


class Judged(NamedTuple):
    """The pressure's estimate over its error, and what end forces and place ask for."""

    pressure: float
    asked: tuple[Asked, Asked]


def judge(trip: Trip) -> list[Judged]:
    """On either mesh; nothing where the divider is hardly touched."""
    fine = brush(trip, Mesh("eem", round(4.0 * trip.scene.rope.length)), 4e-3)
    free = fitted(trip.scene.with_(mesh=FITTED, shaft=Shaft()))
    return (
        [_judged(trip, brush(trip, mesh), fine) for mesh in (free, FITTED)]
        if fine.peak > LEAST
        else []
    )


def _judged(trip: Trip, x: Brush, fine: Brush) -> Judged:
    found = errors(x, fine)
    force = float(np.linalg.norm(x.forces.reshape(-1, 2, 3), axis=2).max())
    adds = (
        add_contact_end_error(0.0, x.sums, trip.stop, force),
        add_contact_loop_error(trip.scene, 0.0, x.sums),
    )

    def asked(k: int) -> Asked:
        added = float(adds[k])
        told = x.told[k + 1]
        one = added / float(getattr(contact_error, NAMES[k]))
        return Asked(found[k + 1], math.sqrt(max(told**2 - added**2, 0.0)), one)

    return Judged(x.told[0] / found[0], (asked(0), asked(1)))


def _said(ratios: list[float]) -> str:
    ratio = np.array(ratios)
    near = " and ".join(
        f"{np.mean(np.abs(np.log(ratio)) < math.log(k)):.0%} within {k}" for k in (2, 3)
    )
    return f"{near}, {ratio.min():.2g} to {ratio.max():.2g} of {ratio.size}"


def main() -> None:
    """Print the constants, and the estimates over the errors of both draws."""
    with ProcessPoolExecutor(2) as pool:
        found = {seed: list(chain(*pool.map(judge, draw(seed, NUMBER)))) for seed in (FIT, JUDGE)}
    for seed, rows in found.items():
        print(f"seed {seed}: pressure {_said([row.pressure for row in rows])}")
    for k, name in enumerate(NAMES):
        constants = np.array([row.asked[k].constant for row in found[FIT]])
        constant = math.exp(np.nanmean(np.log(constants)))
        print(
            f"{name} = {constant:.2g} of {np.isfinite(constants).sum()}, now {getattr(contact_error, name)}"
        )
        for seed, rows in found.items():
            asked = [row.asked[k] for row in rows]
            ratios = [math.hypot(x.rest, constant * x.contact) / x.error for x in asked]
            print(f"  seed {seed}: {_said(ratios)}")


if __name__ == "__main__":
    main()
