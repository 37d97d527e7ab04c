"""Errors and savings of lower fidelities, the estimates of their errors, and the effect of single terms."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import replace
from statistics import median

import numpy as np
from tqdm import tqdm

from benchmarks.kinematic import Winding, wind
from evidence.errors import force_error, place_error
from evidence.tables import Tables, table
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model import Layout, Model, Scene, Swivel, balance_rope
from rope_model.parameters import FidelityChoice, Rope
from rope_model.physics.estimates import Travel, lean_error, longitudinal_error
from rope_model.simulation.messages import fidelity_rules

from .scenes import CASES, COUPLED, LONG_TRIP, P120, P240, STOP, Case

ROUNDS = 3
#: of the estimates' windings: m/s to m/s^2 and m/s^3; EI (N m^2) and spacing (m)
LIMITS = {4.0: (0.75, 0.5), 8.0: (0.75, 0.5), 16.0: (4.0, 8.0)}
VARIED = ((300.0, 2.0), (50.0, 2.0), (1000.0, 2.0), (300.0, 1.5), (300.0, 3.0), (1000.0, 1.5), (50.0, 3.0))


def valid(run: Winding) -> Winding:
    """Return the run, if it came to its end."""
    if not run.status.valid:
        raise RuntimeError(run.status.message)
    return run


def choice(case: Case) -> tuple[object, ...]:
    """Return what 'auto' takes and why, and how that differs from the torsional model; nothing where it takes that."""
    rope = balance_rope(case.scene)
    if not (status := rope.initialize(0.0, *case.ends(case.trip, case.travel, 0.0))).valid:
        raise RuntimeError(status.message)
    head = case.title, rope.fidelity, rope.fidelity_reason
    if rope.fidelity == "torsional":
        return *head, "", 0.0, 0.0, 0.0, 1.0
    runs = [(valid(case.wind(case.on("torsional"))), valid(case.wind(case.scene))) for _ in range(ROUNDS)]
    full, auto = runs[0]
    last = auto.rope.state.fidelity_reason
    raised = [f"{e.what.split()[1]} at {e.t:.2f} s, because {last}" for e in auto.events if "model" in e.what]
    time = median(lower.cpu for _, lower in runs) / median(whole.cpu for whole, _ in runs)
    peak = float(np.abs(np.subtract(auto.force, full.force)).max() / np.abs(full.force).max())
    errors = force_error(auto.force, full.force), peak, place_error(auto.bottom, full.bottom)
    return *head, "; ".join(raised), *errors, time


def fidelities() -> Tables:
    """Measure the ten scenes."""
    names = ("scene", "fidelity", "reason", "raised", "force_rms", "force_largest", "loop_m", "time")
    return {"fidelity": table(names, [choice(case) for case in tqdm(CASES, unit="scene", leave=False)])}


def windings() -> Iterator[tuple[Scene, Trip, float | None]]:
    """Yield those from which the constants of physics.estimates are taken, and one whose swivels are released."""
    for rope_case, speed, (EI, spacing) in itertools.product((P120, P240), LIMITS, VARIED):
        acceleration, jerk = LIMITS[speed]
        rope = replace(rope_case.scene.rope, EI=EI)
        scene = rope_case.scene.with_(rope=rope, layout=Layout(spacing=spacing), left=Swivel(), right=Swivel())
        yield scene, Trip(travel=rope_case.travel, speed=speed, acceleration=acceleration, jerk=jerk), None
    yield P240.scene, Trip(travel=P240.travel, speed=P240.speed), 25.0


def estimate(scene: Scene, trip: Trip, until: float | None) -> tuple[object, ...]:
    """Return measured and estimated errors of one winding: planar against torsional, rigid against planar."""
    reference = s_curve(trip)
    settle = 3.0 if until is None else until - reference.duration
    names: tuple[FidelityChoice, ...] = ("torsional", "planar", "rigid")
    full, planar, rigid = (
        valid(wind(scene.with_(model=Model(name)), reference, trip.travel, settle, sample=2)) for name in names
    )
    travel = Travel(trip.travel, reference.peak_speed, trip.acceleration, trip.jerk)
    swivels = "locked" if scene.left.mode == "locked" else f"released at {scene.left.release_time:g} s"
    head = scene.rope.length, swivels, trip.speed, scene.rope.EI, scene.layout.spacing
    of_planar = force_error(planar.force, full.force), fidelity_rules.force_error(scene, "planar", travel)
    of_rigid = force_error(rigid.force, planar.force), longitudinal_error(scene, travel) + lean_error(scene, travel)
    return *head, *of_planar, *of_rigid


def estimates() -> Tables:
    """Measure all windings (ten minutes)."""
    names = ("length", "swivels", "speed", "EI", "spacing", "planar", "planar_estimate", "rigid", "rigid_estimate")
    return {"estimates": table(names, [estimate(*x) for x in tqdm([*windings()], unit="winding", leave=False)])}


SCENES = {
    "winding": Case("120 m winding", COUPLED, "torsional"),
    "emergency stop": Case("120 m, stop", COUPLED, "torsional", trip=STOP, until=STOP.duration + 5.0),
    "release": Case("240 m, release", P240.scene, "torsional", trip=LONG_TRIP, travel=P240.travel, until=25.0),
}
#: term, change, the rope with it
VARIANTS: tuple[tuple[str, str, Callable[[Rope], Rope]], ...] = (
    ("spin inertia", "rhoJ / 100", lambda r: replace(r, rhoJ=0.01 * r.rhoJ)),
    ("non-conservative coupling", "the published Qb, Qc", lambda r: replace(r, Qb=2.371e5, Qc=2.301e5)),
    ("material damping", "beta_K = 0", lambda r: replace(r, beta_K=0.0)),
    ("material damping", "beta_K = 1e-2 s", lambda r: replace(r, beta_K=1e-2)),
    ("stretch", "Qa x 10", lambda r: replace(r, Qa=10 * r.Qa)),
)


def terms() -> Tables:
    """Change one term at a time: differences, of theta and torque over their largest value, and steps."""
    rows = []
    for name, case in SCENES.items():
        base = valid(case.wind(case.scene))
        for term, change, rope in tqdm(VARIANTS, desc=name, unit="run", leave=False):
            run = valid(case.wind(case.scene.with_(rope=rope(case.scene.rope))))
            theta = [np.array(r.observed)[:, :, 6] for r in (run, base)]
            shares = [np.abs(np.subtract(*x)).max() / np.abs(x[1]).max() for x in (theta, (run.torque, base.torque))]
            steps = (r.rope.state.counts.steps for r in (run, base))
            errors = force_error(run.force, base.force), place_error(run.bottom, base.bottom)
            rows.append((name, term, change, *errors, *shares, *steps))
    names = ("scene", "term", "change", "force_rms", "loop_m", "theta", "torque", "steps", "steps_default")
    return {"terms": table(names, rows)}


MEASURES: dict[str, Callable[[], Tables]] = {"fidelity": fidelities, "terms": terms, "estimates": estimates}
