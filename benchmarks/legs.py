"""What joining the legs' elements does to the loop's place: ``python -m benchmarks.legs``.

The same mesh with none joined, and with a quarter, once and four times the ``grading_length`` of 'auto', against one
for 0.3 mm without joined elements, with the planar model (an uncoupled rope), where the sway of the legs is seen
alone.  What a leg's waves lose adds up: the trips are long.  An emergency stop sends shorter waves up the legs; what
the time steps alone do to loop and end forces is printed beside it, by the same fine mesh with a quarter of the step.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model.parameters import Mesh
from rope_model.simulation.mesh import fit_mesh

from .kinematic import Winding, fixed_steps, scene_of, wind

FINEST = 3e-4  # m, loop_error of the reference
STEP, EVERY, SETTLE = 0.01, 0.08, 5.0  # s
PARTS = (0.0, 0.25, 1.0, 4.0)  # of the grading_length of 'auto'


@dataclass(frozen=True)
class Case:
    """A rope on a trip."""

    rope: str
    trip: Trip


CASES = (
    Case("rope-120", Trip(travel=90.0, speed=8.0)),
    Case("rope-240", Trip(travel=200.0, speed=10.0)),
    Case("monopol-1000", Trip(travel=700.0, speed=8.0)),
    Case("monopol-1000", Trip(travel=900.0, speed=16.0)),
    Case("rope-240", Trip(travel=200.0, speed=10.0, emergency_at=16.0)),
    Case("kiruna-710", Trip(travel=650.0, speed=16.0, emergency_at=35.0)),
    Case("monopol-1000", Trip(travel=900.0, speed=16.0, emergency_at=40.0)),
)


@dataclass(frozen=True)
class Outcome:
    """One mesh."""

    grading_length: float  # m
    elements: int
    loop_error: float  # m, the largest of the trip
    force_error: float  # RMS over the largest force
    kinetic: float  # J, largest change by a transformation


def wind_uncoupled(case: Case, mesh: Mesh, step: float = STEP) -> Winding:
    """The uncoupled rope on its trip, with a record every EVERY (s)."""
    scene = scene_of(case.rope, "uncoupled").with_(mesh=mesh, solver=fixed_steps(step))
    run = wind(scene, s_curve(case.trip), case.trip.travel, SETTLE, round(EVERY / step), interval=step)
    if not run.status.valid:
        raise RuntimeError(f"{case.rope}, {mesh}: {run.status.message}")
    return run


def apart(a: Winding, b: Winding) -> float:
    """Largest distance of the loops' places, m."""
    return float(np.linalg.norm(np.array(a.bottom) - np.array(b.bottom), axis=1).max())


def force_error(run: Winding, exact: Winding) -> float:
    """RMS difference of the end forces over the largest force."""
    force = np.array(exact.force)
    return float(np.sqrt(np.mean((np.array(run.force) - force) ** 2)) / np.abs(force).max())


def meshes(case: Case, loop_error: float) -> tuple[Mesh, Mesh]:
    """The mesh of 'auto' for ``loop_error`` (m), and the reference's."""
    scene = scene_of(case.rope, "uncoupled")
    auto, fine = (fit_mesh(scene.with_(mesh=Mesh("auto", loop_error=e))) for e in (loop_error, FINEST))
    return auto, replace(fine, grading_length=0.0)


def outcomes(case: Case, exact: Winding, auto: Mesh) -> Iterator[Outcome]:
    """Meshes with more and more elements joined."""
    for times in PARTS:
        mesh = replace(auto, grading_length=times * auto.grading_length)
        run = wind_uncoupled(case, mesh)
        kinetic = max(abs(e.kinetic) for e in run.events if e.what == "transformation")
        elements = run.rope.state.partition.lengths.size
        yield Outcome(mesh.grading_length, elements, apart(run, exact), force_error(run, exact), kinetic)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--loop-error", type=float, default=5e-3, metavar="M", help="of the mesh [m] (%(default)s)")
    options = parser.parse_args()
    for case in CASES:
        trip = case.trip
        stop = "" if trip.emergency_at is None else f", emergency stop at {trip.emergency_at:g} s"
        auto, fine = meshes(case, options.loop_error)
        exact = wind_uncoupled(case, fine)
        shorter = wind_uncoupled(case, fine, STEP / 4)
        steps = 1e3 * apart(exact, shorter), 100 * force_error(exact, shorter)
        print(
            f"{case.rope}, {trip.travel:g} m at up to {trip.speed:g} m/s{stop}, mesh for {options.loop_error:g} m; "
            f"steps of {1e3 * STEP:g} ms alone: {steps[0]:.2f} mm, end forces {steps[1]:.1e} %"
        )
        for x in outcomes(case, exact, auto):
            print(
                f"  grading_length {x.grading_length:6.2f} m {x.elements:5d} elements, "
                f"loop {1e3 * x.loop_error:6.2f} mm, end forces {100 * x.force_error:.1e} %, "
                f"kinetic energy per transformation up to {x.kinetic:.1e} J",
                flush=True,
            )


if __name__ == "__main__":
    main()
