"""The slack rod in PyElastica, a code of discrete Cosserat rods (Gazzola Lab, MIT): recorded for ``make contact``.

``python -m evidence.contact.elastica_rod`` writes docs/data/contact/elastica.csv: some ten minutes; needs
``pip install balance-rope[contact]``.

Its explicit steps are bounded by waves of stretch and shear: the rod's stretch is ours, its shear as stiff, and its
rotary inertia much larger than a rope's, which at rest has no part in anything.  Orientations are those of
elements: the first and last are clamped at their middles, and stand out of the rod by half.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import elastica as ea
import numpy as np

from evidence.rendering import DOCS
from evidence.tables import table, write

from .scenes import Array
from .slack_rod import AXIAL, BEND, COLUMNS, DIAMETER, LENGTH, MASS, SLACK, STATIONS, TORSION, Held, nearest

ELEMENTS = (60, 120)
#: kg m: rotary inertia per length about the diameters, twice that about the axis
INERTIA = 0.075
#: s times elements: the step
STEP = 0.036
#: 1/s, of all motion; N/m and N s/m of contact
DAMPING, STIFFNESS, CONTACT_DAMPING = 2.0, 1e6, 200.0
#: s in which the ends come together, turns a second on the way to a station, and s of rest there, read in the last
FOLD, RATE, REST, READ = 10.0, 0.04, 20.0, 4.0
#: N/m sideways while the ends come together
KICK = 0.5


#: what of PyElastica takes part
_Simulator: Any = type(
    "Simulator",
    (ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping, ea.Contact, ea.CallBacks),
    {"__doc__": "One rod, its clamps, its contact."},
)


def _schedule() -> Iterator[tuple[float, float, float]]:
    """Start (s) and turns before and after of each way to a station."""
    t, before = FOLD, 0.0
    for station in STATIONS:
        yield t, before, station
        t, before = t + (station - before) / RATE + REST, station


DURATION = FOLD + STATIONS[-1] / RATE + len(STATIONS) * REST
WAYS = tuple(_schedule())


def _smooth(x: float) -> tuple[float, float]:
    """From 0 to 1 with x, and its rate."""
    x = min(max(x, 0.0), 1.0)
    return x**3 * (10 - 15 * x + 6 * x * x), 30 * (x * (1 - x)) ** 2


def turns_at(t: float) -> tuple[float, float]:
    """Turns of the end, and turns a second."""
    start, before, after = [way for way in WAYS if way[0] <= t][-1] if t > FOLD else WAYS[0]
    time = (after - before) / RATE
    part, rate = _smooth((t - start) / time)
    return before + (after - before) * part, (after - before) * rate / time


class _Ends(ea.ConstraintBase):  # type: ignore[misc]
    """Both ends clamped; one comes nearer, then turns."""

    def __init__(self, *parts: Any, **named: Any) -> None:
        super().__init__(*parts, **named)
        rod = self._system
        self._x = rod.position_collection[:, [0, -1]].copy()
        self._Q = rod.director_collection[..., [0, -1]].copy()

    def constrain_values(self, system: Any, time: float) -> None:
        part, _ = _smooth(time / FOLD)
        angle = 2 * math.pi * turns_at(time)[0]
        c, s = math.cos(angle), math.sin(angle)
        turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        system.position_collection[:, 0] = self._x[:, 0]
        system.position_collection[:, -1] = self._x[:, 1] - [SLACK * part, 0, 0]
        system.director_collection[..., 0] = self._Q[..., 0]
        system.director_collection[..., -1] = self._Q[..., 1] @ turn.T

    def constrain_rates(self, system: Any, time: float) -> None:
        _, rate = _smooth(time / FOLD)
        system.velocity_collection[:, 0] = 0
        system.velocity_collection[:, -1] = (-SLACK * rate / FOLD, 0, 0)
        system.omega_collection[:, 0] = 0
        system.omega_collection[:, -1] = (0, 0, 2 * math.pi * turns_at(time)[1])


class _Kick(ea.NoForces):  # type: ignore[misc]
    """What makes a straight rod buckle sideways."""

    def apply_forces(self, system: Any, time: float = 0.0) -> None:
        if time < FOLD:
            system.external_forces[1] += KICK * LENGTH / system.n_elems


class _Record(ea.CallBackBaseClass):  # type: ignore[misc]
    """Time, torque, pull and the force of the legs in the last seconds of every rest; the rod then."""

    def __init__(self, every: int, rows: list[tuple[float, ...]], shapes: dict[float, Array]) -> None:
        super().__init__()
        self.every, self.rows, self.shapes = every, rows, shapes

    def make_callback(self, system: Any, time: float, current_step: int) -> None:
        if current_step % self.every:
            return
        for start, before, after in WAYS:
            until = start + (after - before) / RATE + REST
            if until - READ <= time < until:
                self.rows.append((after, *_forces(system)))
                self.shapes[after] = system.position_collection.copy()


def _forces(rod: Any) -> tuple[float, float, float]:
    """Torque and pull at the ends, and by how much the force inside the loop differs from it."""
    twist = rod.internal_couple[2] / rod.voronoi_dilatation**3
    inside = np.einsum("jik,jk->ik", rod.director_collection, rod.internal_stress) / rod.dilatation
    ends, middle = inside[:, [0, -1]].mean(axis=1), inside[:, rod.n_elems // 2]
    return 0.5 * float(twist[0] + twist[-1]), float(ends[0]), float(np.linalg.norm(middle - ends))


def simulate(elements: int) -> list[tuple[Held, float]]:
    """At every station: means over the last seconds, and half of what the torque still swings by."""
    dl, h = LENGTH / elements, STEP / elements
    area = math.pi * DIAMETER**2 / 4
    rod = ea.CosseratRod.straight_rod(
        elements + 1,
        np.array([-0.5 * dl, 0.0, 0.0]),
        np.array([1.0, 0.0, 0.0]),
        np.array([0.0, 1.0, 0.0]),
        LENGTH + dl,
        DIAMETER / 2,
        density=MASS / area,
        youngs_modulus=AXIAL / area,
    )
    for matrix, diagonal in ((rod.shear_matrix, (AXIAL,) * 3), (rod.bend_matrix, (BEND, BEND, TORSION))):
        matrix[:] = np.diag(diagonal)[..., None]
    inertia = INERTIA * dl * np.diag([1.0, 1.0, 2.0])
    rod.mass_second_moment_of_inertia[:] = inertia[..., None]
    rod.inv_mass_second_moment_of_inertia[:] = np.linalg.inv(inertia)[..., None]

    rows: list[tuple[float, ...]] = []
    shapes: dict[float, Array] = {}
    simulator = _Simulator()
    simulator.append(rod)
    simulator.constrain(rod).using(_Ends, constrained_position_idx=(0, -1), constrained_director_idx=(0, -1))
    simulator.add_forcing_to(rod).using(_Kick)
    simulator.dampen(rod).using(
        ea.AnalyticalLinearDamper,
        translational_damping_constant=DAMPING * MASS * dl,
        rotational_damping_constant=DAMPING * INERTIA * dl,
        time_step=h,
    )
    simulator.detect_contact_between(rod, rod).using(ea.RodSelfContact, k=STIFFNESS, nu=CONTACT_DAMPING)
    simulator.collect_diagnostics(rod).using(_Record, every=round(0.1 / h), rows=rows, shapes=shapes)
    simulator.finalize()
    ea.integrate(ea.PositionVerlet(), simulator, DURATION, round(DURATION / h), progress_bar=False)
    if not np.isfinite(rod.position_collection).all():
        raise RuntimeError(f"{elements} elements are unstable with STEP = {STEP:g} s; make it shorter")
    return [_station(np.array([row for row in rows if row[0] == turns]), shapes[turns]) for turns in STATIONS]


def _station(rows: Array, nodes: Array) -> tuple[Held, float]:
    turns, torque, pull, pressed = rows.mean(axis=0)
    dl = LENGTH / (nodes.shape[1] - 2)
    s = np.linspace(0.0, LENGTH, 1201)
    points = np.array([np.interp(s, np.arange(nodes.shape[1]) * dl - 0.5 * dl, x) for x in nodes]).T
    swing = 0.5 * float(np.ptp(rows[:, 1]))
    return Held(float(turns), float(torque), float(pull), float(pressed), nearest(points, s)), swing


def main() -> None:
    """Record both meshes."""
    found = []
    for elements in ELEMENTS:
        for x, swing in simulate(elements):
            found.append((elements, x.turns, x.torque, x.pull, x.pressed, *x.places, swing))
            print(*found[-1])
    write({"elastica": table((*COLUMNS, "swing"), found)}, DOCS / "data" / "contact")


if __name__ == "__main__":
    main()
