"""Errors of lower fidelities, and the estimates of them, whose constants are taken from here."""

import itertools
from collections.abc import Iterator
from dataclasses import replace

from tqdm import tqdm

from benchmarks.kinematic import wind
from evidence.errors import force_error
from evidence.tables import Measures, Tables, table
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model import Layout, Model, Scene, Swivel
from rope_model.cases import rope_120, rope_240
from rope_model.fidelity import fidelity_rules
from rope_model.physics.estimates import Travel, lean_error, longitudinal_error
from rope_model.solver_parameters import FidelityChoice

P120 = rope_120()
P240 = rope_240()
#: of the estimates' windings: m/s to m/s^2 and m/s^3; EI (N m^2) and spacing (m)
LIMITS = {4.0: (0.75, 0.5), 8.0: (0.75, 0.5), 16.0: (4.0, 8.0)}
VARIED = (
    (300.0, 2.0),
    (50.0, 2.0),
    (1000.0, 2.0),
    (300.0, 1.5),
    (300.0, 3.0),
    (1000.0, 1.5),
    (50.0, 3.0),
)


def windings() -> Iterator[tuple[Scene, Trip, float | None]]:
    """Yield those from which the constants of physics.estimates are taken, and one whose swivels are released."""
    for rope_case, speed, (EI, spacing) in itertools.product((P120, P240), LIMITS, VARIED):
        acceleration, jerk = LIMITS[speed]
        rope = replace(rope_case.scene.rope, EI=EI)
        scene = rope_case.scene.with_(
            rope=rope, layout=Layout(spacing=spacing), left=Swivel(), right=Swivel()
        )
        yield (
            scene,
            Trip(travel=rope_case.travel, speed=speed, acceleration=acceleration, jerk=jerk),
            None,
        )
    yield P240.scene, Trip(travel=P240.travel, speed=P240.speed), 25.0


def estimate(scene: Scene, trip: Trip, until: float | None) -> tuple[object, ...]:
    """Return measured and estimated errors of one winding: planar against torsional, rigid against planar."""
    reference = s_curve(trip)
    settle = 3.0 if until is None else until - reference.duration
    names: tuple[FidelityChoice, ...] = ("torsional", "planar", "rigid")
    full, planar, rigid = (
        wind(scene.with_(model=Model(name)), reference, trip.travel, settle, sample=2).completed()
        for name in names
    )
    speed = max(abs(point.speed) for point in reference.points)
    travel = Travel(trip.travel, speed, trip.acceleration, trip.jerk)
    swivels = (
        "locked" if scene.left.mode == "locked" else f"released at {scene.left.release_time:g} s"
    )
    head = scene.rope.length, swivels, trip.speed, scene.rope.EI, scene.layout.spacing
    of_planar = (
        force_error(planar.force, full.force),
        fidelity_rules.force_error(scene, "planar", travel),
    )
    of_rigid = (
        force_error(rigid.force, planar.force),
        longitudinal_error(scene, travel) + lean_error(scene, travel),
    )
    return *head, *of_planar, *of_rigid


def estimates() -> Tables:
    """Measure all windings (ten minutes)."""
    names = (
        "length",
        "swivels",
        "speed",
        "EI",
        "spacing",
        "planar",
        "planar_estimate",
        "rigid",
        "rigid_estimate",
    )
    return {
        "estimates": table(
            names, [estimate(*x) for x in tqdm([*windings()], unit="winding", leave=False)]
        )
    }


MEASURES: Measures = {"estimates": estimates}
