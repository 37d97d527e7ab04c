"""What the mesh does to the loop's place on a winding."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.kinematic import wind
from evidence.tables import Table, table
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model.parameters import Mesh
from rope_model.simulation.mesh import fit_mesh, partition

from .scenes import KINDS, STEP, Sample
from .statics import pattern

Array = NDArray[np.float64]
SETTLE, EVERY = 3.0, 0.08  # s
#: loop_error (m) of the mesh whose legs, ends and steps are varied; how much longer its legs' elements are made
ASKED, PARTS = 5e-3, (0.25, 1.0, 4.0)
SHORT_STEP = STEP / 4
#: loop errors asked for, m
ACCURACIES = (0.05, 5e-3, 1e-3, 2e-4)
#: of the references: loop elements and half of segment IV over (EI / rho g)^(1/3), grading_length L in m^2; the second
#: tells how far the first may be trusted
REFERENCES = ((0.07, 3.0, 60.0), (0.1, 2.7, 120.0))


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
    if not run.status.valid:
        raise RuntimeError(f"scene {sample.number}, {kind}, {mesh}: {run.status.message}")
    return LoopPath(np.array(run.bottom)[:, :2], run.rope.elements)


def distance(a: LoopPath, b: LoopPath) -> float:
    """Largest distance of the loop's places, m."""
    return float(np.linalg.norm(a.places - b.places, axis=1).max())


def auto_mesh(sample: Sample, loop_error: float) -> Mesh:
    """The mesh of 'auto' for ``loop_error`` (m)."""
    return fit_mesh(sample.scene(Mesh("auto", loop_error=loop_error)))


def reference(sample: Sample, fine: float, cover: float, growth: float) -> Mesh:
    """As pattern; equal elements where the rope is too short for it."""
    mesh = replace(pattern(sample, fine, cover), grading_length=growth / sample.rope.length)
    travel = sample.smooth.travel
    try:
        cells = partition(mesh, sample.rope.length, 0.5 * (sample.rope.length - travel))
    except ValueError:
        cells = None
    if cells is None or abs(cells.centre - 0.5 * (sample.rope.length - travel)) > 0.5 * cells.coarse:
        return Mesh("eem", elements=round(sample.rope.length / (fine * sample.w)))
    return mesh


def parts(samples: Iterable[Sample]) -> Table:
    """How far the loop's place is off by joined legs, by the ends' elements, and by steps of 10 ms."""
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
                finer = run_trip(d, kind, replace(auto, end_levels=auto.end_levels + 3))
                shorter = run_trip(d, kind, auto, SHORT_STEP)
                rows.append((*head, "ends", part, growth, run.elements, distance(run, finer)))
                rows.append((*head, "steps", part, growth, run.elements, distance(run, shorter)))
    return table(("scene", "length [m]", "trip", "what", "part", "grading_length [m]", "elements", "off [m]"), rows)


def judge(samples: Iterable[Sample], accuracies: Sequence[float] = ACCURACIES) -> Table:
    """Asked and achieved errors of the loop's place; that at rest before the trip; how sure the reference is."""
    rows: list[tuple[object, ...]] = []
    for d, kind in ((d, kind) for d in samples for kind in KINDS):
        exact, other = (run_trip(d, kind, reference(d, *lengths)) for lengths in REFERENCES)
        sure, speed = distance(exact, other), s_curve(trip_of(d, kind)).peak_speed
        for asked in accuracies:
            mesh = auto_mesh(d, asked)
            fine = mesh.coarse_length / 4 if mesh.kind == "tmn" else d.rope.length / mesh.elements
            run = run_trip(d, kind, mesh)
            rest = float(np.linalg.norm(run.places[0] - exact.places[0]))
            rope = d.rope.length, d.rope.mass_per_length, d.rope.EI, d.rope.Qa, d.layout.spacing, d.w
            rows.append(
                (d.number, *rope, kind, speed, asked, mesh.kind, fine, run.elements, distance(run, exact), rest, sure)
            )
    return table(COLUMNS, rows)


COLUMNS = (
    *("scene", "length [m]", "mass [kg/m]", "EI [N m2]", "EA [N]", "spacing [m]", "w [m]"),
    *("trip", "speed [m/s]", "asked [m]", "mesh", "fine [m]", "elements"),
    *("achieved [m]", "at rest [m]", "reference [m]"),
)
