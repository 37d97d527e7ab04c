"""What joining the legs' elements does to the loop's place: ``python -m benchmarks.legs``.

The same mesh with none joined, and with a quarter, once and four times the ``leg_growth`` of 'auto', against one for
0.3 mm without joined elements, on the planar rung (an uncoupled rope), where the sway of the legs is seen alone.  What
a leg's waves lose adds up: the trips are long.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hoist_demo.parameters import Winding as Trip
from hoist_demo.reference import s_curve
from rope_model.parameters import Mesh
from rope_model.simulation.mesh import suited

from .chart.depth import scene_of
from .kinematic import wind

FINEST = 3e-4  # m, loop_error of the reference
STEP, SAMPLE = 0.01, 8  # s, steps
PARTS = (0.0, 0.25, 1.0, 4.0)  # of the leg_growth of 'auto'


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
)


@dataclass(frozen=True)
class Outcome:
    """One mesh."""

    leg_growth: float  # m
    elements: int
    loop_error: float  # m, the largest of the trip
    kinetic: float  # J, largest change by a transformation


def outcomes(case: Case, loop_error: float = 5e-3) -> Iterator[Outcome]:
    """Meshes for ``loop_error`` (m) with more and more elements joined."""
    scene = scene_of(case.rope, "uncoupled")

    def wound(mesh: Mesh) -> tuple[NDArray[np.float64], int, float]:
        run = wind(
            scene.with_(mesh=mesh), s_curve(case.trip), case.trip.travel, settle=1.0, sample=SAMPLE, interval=STEP
        )
        if not run.status.valid:
            raise RuntimeError(f"{case.rope}, {mesh}: {run.status.message}")
        changes = [abs(e.kinetic) for e in run.events if e.what == "transformation"]
        return np.array(run.bottom), run.rope.state.partition.lengths.size, max(changes)

    auto, fine = (suited(Mesh("auto", loop_error=e), scene.rope, scene.layout) for e in (loop_error, FINEST))
    exact = wound(replace(fine, leg_growth=0.0))[0]
    for times in PARTS:
        mesh = replace(auto, leg_growth=times * auto.leg_growth)
        bottom, elements, kinetic = wound(mesh)
        largest = float(np.linalg.norm(bottom - exact, axis=1).max())
        yield Outcome(mesh.leg_growth, elements, largest, kinetic)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--loop-error", type=float, default=5e-3, metavar="M", help="of the mesh [m] (%(default)s)")
    options = parser.parse_args()
    for case in CASES:
        print(
            f"{case.rope}, {case.trip.travel:g} m at up to {case.trip.speed:g} m/s, mesh for {options.loop_error:g} m"
        )
        for x in outcomes(case, options.loop_error):
            print(
                f"  leg_growth {x.leg_growth:6.2f} m {x.elements:5d} elements, loop "
                f"{1e3 * x.loop_error:6.2f} mm, kinetic energy per transformation up to {x.kinetic:.1e} J",
                flush=True,
            )


if __name__ == "__main__":
    main()
