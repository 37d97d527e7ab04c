"""Effect of the mesh on the loop's place during a winding."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.kinematic import wind
from evidence.mesh_rule.scenes import KINDS, STEP, Sample
from evidence.tables import Array, Table, table
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model.parameters import Mesh
from rope_model.simulation.mesh.partition import fit_mesh

SETTLE, EVERY = 3.0, 0.08  # s
#: loop_error (m) of the mesh whose legs, ends and steps are varied; how much longer its legs' elements are made
ASKED, PARTS = 5e-3, (0.25, 1.0, 4.0)
SHORT_STEP = STEP / 4


@dataclass(frozen=True)
class LoopPath:
    """Places of the loop (instants, 2), m, and the number of elements."""

    places: Array
    elements: int


def trip_of(sample: Sample, kind: str) -> Trip:
    """The smooth one or the one with an emergency stop."""
    return sample.smooth if kind == "smooth" else sample.stopped


def run_trip(sample: Sample, kind: str, mesh: Mesh, step: float = STEP) -> LoopPath:
    """The rope on its trip."""
    trip = trip_of(sample, kind)
    run = wind(sample.scene(mesh, step), s_curve(trip), trip.travel, SETTLE, round(EVERY / step), interval=step)
    run.completed(f"scene {sample.number}, {kind}, {mesh}")
    return LoopPath(np.array(run.bottom)[:, :2], run.rope.elements)


def distance(a: LoopPath, b: LoopPath) -> float:
    """Largest distance of the loop's places, m."""
    return float(np.linalg.norm(a.places - b.places, axis=1).max())


def auto_mesh(sample: Sample, loop_error: float) -> Mesh:
    """The mesh of 'auto' for ``loop_error`` (m)."""
    return fit_mesh(sample.scene(Mesh("auto", loop_error=loop_error)))


def parts(samples: Iterable[Sample]) -> Table:
    """How far the loop's place is off by joined legs, and by steps of 10 ms."""
    rows: list[tuple[object, ...]] = []
    for d, kind in ((d, kind) for d in samples for kind in KINDS):
        auto = auto_mesh(d, ASKED)
        if auto.kind == "eem":
            continue
        head = d.number, d.rope.length, kind
        plain = run_trip(d, kind, replace(auto, grading_length=0.0))
        for part in PARTS:
            growth = part * auto.grading_length
            run = run_trip(d, kind, replace(auto, grading_length=growth))
            rows.append((*head, "legs", part, growth, run.elements, distance(run, plain)))
            if part == 1.0:
                shorter = run_trip(d, kind, auto, SHORT_STEP)
                rows.append((*head, "steps", part, growth, run.elements, distance(run, shorter)))
    return table(("scene", "length [m]", "trip", "what", "part", "grading_length [m]", "elements", "off [m]"), rows)
