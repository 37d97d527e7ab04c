"""Effect of the mesh on the loop's place during a winding."""

from collections.abc import Iterable
from dataclasses import replace

from benchmarks.kinematic import Winding, wind
from evidence.errors import place_error
from evidence.mesh_rule.scenes import KINDS, STEP, Sample
from evidence.tables import Table, table
from hoist_demo.control.trajectory import s_curve
from rope_model.reference.mesh import fitted
from rope_model.solver_parameters import Mesh

SETTLE = 3.0  # s
EVERY = 0.08  # s
#: loop_error (m) of the mesh whose legs, ends and steps are varied; how much longer its legs' elements are made
ASKED = 5e-3
PARTS = (0.25, 1.0, 4.0)
SHORT_STEP = STEP / 4


def run_trip(sample: Sample, kind: str, mesh: Mesh, step: float = STEP) -> Winding:
    """The rope on its trip, the smooth one or the one with an emergency stop."""
    trip = sample.smooth if kind == "smooth" else sample.stopped
    run = wind(
        sample.scene(mesh, step),
        s_curve(trip),
        trip.travel,
        SETTLE,
        round(EVERY / step),
        interval=step,
    )
    return run.completed(f"scene {sample.number}, {kind}, {mesh}")


def parts(samples: Iterable[Sample]) -> Table:
    """How far the loop's place is off by joined legs, and by steps of 10 ms."""
    rows: list[tuple[object, ...]] = []
    for d, kind in ((d, kind) for d in samples for kind in KINDS):
        auto = fitted(d.scene(Mesh("auto", loop_error=ASKED)))
        if auto.kind == "eem":
            continue
        head = d.number, d.rope.length, kind
        plain = run_trip(d, kind, replace(auto, grading_length=0.0))
        for part in PARTS:
            growth = part * auto.grading_length
            run = run_trip(d, kind, replace(auto, grading_length=growth))
            rows.append(
                (
                    *head,
                    "legs",
                    part,
                    growth,
                    run.rope.elements,
                    place_error(run.bottom, plain.bottom),
                )
            )
            if part == 1.0:
                shorter = run_trip(d, kind, auto, SHORT_STEP)
                rows.append(
                    (
                        *head,
                        "steps",
                        part,
                        growth,
                        run.rope.elements,
                        place_error(run.bottom, shorter.bottom),
                    )
                )
    return table(
        (
            "scene",
            "length [m]",
            "trip",
            "what",
            "part",
            "grading_length [m]",
            "elements",
            "off [m]",
        ),
        rows,
    )
