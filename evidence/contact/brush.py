"""A rope that brushes a thin divider while it runs past: force over time, its peak and its impulse.

They are measured against step, mesh, stiffness and height.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from evidence.errors import end_error, place_error
from evidence.ropes import at_rest, follow, moving
from evidence.tables import Array, Table, records, table
from rope_model import EndMotion
from rope_model.parameters import Scene
from rope_model.physics.contact_error import ContactSums
from rope_model.reference.mesh import fitted
from rope_model.shaft_parameters import Contact, Divider, Shaft
from rope_model.solver_parameters import Mesh, Solver

#: m: deeper places must be pressed
INSIDE = 5e-4
#: elements and steps (s) of the fine run
FINE = 480, 2e-3
FITTED = Mesh("auto")
STIFFNESS = Contact().stiffness
_ENDS = tuple(f"{side}.f{axis}" for side in ("left", "right") for axis in "xyz")
_SIGNALS = ("contact.divider", "clearance.divider", *_ENDS, "loop.x", "loop.y", "loop.z")
_TOLD = (
    "contact.divider.impulse",
    "status.contact_error",
    "status.end_force_error",
    "status.loop_error",
)


class Trip(NamedTuple):
    """A rope whose left end rises by ``rise`` (m) and whose right one falls, in the time ``moves`` of ``stop`` (s)."""

    scene: Scene
    rise: float = 40.0
    moves: float = 14.0
    stop: float = 10.0

    def ends(self, t: float) -> tuple[EndMotion, EndMotion]:
        """Where they are."""
        return moving(self.rise, t, self.moves, y=1.0), moving(-self.rise, t, self.moves, y=1.0)


class Brush(NamedTuple):
    """Pressure (N) every 10 ms, its impulse (N s), estimated errors, and samples that are inside without a force.

    ``forces`` (N) are those at the ends, ``loop`` (m) is its place, ``sums`` those of physics.contact_error.
    """

    pressure: Array
    impulse: float
    told: tuple[
        float, float, float
    ]  # of the pressure, the end forces (relative) and the loop's place (m)
    gaps: int
    forces: Array
    loop: Array
    sums: ContactSums

    @property
    def peak(self) -> float:
        """Largest pressure in the middle of a step, N: a blow peaks between samples."""
        return float(self.sums.largest)


def past(stiffness: float = STIFFNESS, y: float = -25.0) -> Trip:
    """The default rope past the divider of the page, at this height (m)."""
    divider = Divider(size=0.05, y=y, offset=-0.9)
    return Trip(Scene(shaft=Shaft(divider_1=divider, contact=Contact(stiffness=stiffness))))


@cache
def brush(trip: Trip, mesh: Mesh = FITTED, step: float = 0.0) -> Brush:
    """The trip on this mesh, with steps of this length; 0: as the default accuracy asks for."""
    solver = Solver(step_max=step, tolerance=1e3) if step else Solver()
    rope = at_rest(trip.scene.with_(mesh=mesh, solver=solver))
    rows = follow(rope, 1e-2, trip.stop, trip.ends, rope.reader(_SIGNALS))
    impulse, pressure, force, place = rope.signals(_TOLD).values()
    gaps = int(np.count_nonzero((rows[:, 1] < -INSIDE) & (rows[:, 0] == 0.0)))
    told = (pressure, force, place)
    sums = rope.state.contact
    return Brush(rows[:, 0], impulse, told, gaps, rows[:, 2:8], rows[:, 8:], sums)


def leaning(mesh: Mesh) -> float:
    """Force (N) of a thin divider that the default rope leans on at rest."""
    shaft = Shaft(divider_1=Divider(size=0.1, y=-25.0, offset=1.03))
    return at_rest(Scene(mesh=mesh, shaft=shaft)).signals(["contact.divider"])["contact.divider"]


def errors(coarse: Brush, fine: Brush) -> tuple[float, float, float]:
    """Errors of what ``told`` estimates."""
    presses = (coarse.pressure > 0.0) | (fine.pressure > 0.0)
    pressure = math.sqrt(np.square(coarse.pressure - fine.pressure)[presses].mean()) / fine.peak
    return pressure, end_error(coarse.forces, fine.forces), place_error(coarse.loop, fine.loop)


#: elements, 0 for the fitted mesh; step (s); stiffness (N/m^2)
CASES = (
    *((elements, step, STIFFNESS) for elements in (0, 480) for step in (10e-3, 5e-3, 2e-3)),
    *((elements, 5e-3, STIFFNESS) for elements in (120, 240, 960)),
    *((elements, 5e-3, STIFFNESS * times) for times in (0.25, 4.0) for elements in (0, 240, 480)),
)
COLUMNS = ("elements", "step", "stiffness", "peak", "impulse", "told")


def brushes() -> Table:
    """Peak (N), impulse (N s) and estimated error of the pressure, of CASES."""
    rows = []
    for elements, step, stiffness in CASES:
        x = brush(past(stiffness), Mesh("eem", elements) if elements else FITTED, step)
        rows.append((elements, step, stiffness, x.peak, x.impulse, x.told[0]))
    return table(COLUMNS, rows)


#: m, of the divider: it meets any place of an element; and the fine run's elements, step and end (s), behind the peak
HEIGHTS = tuple(-25.0 - 0.2 * k for k in range(9))
FINEST = (960, 2e-3, 5.0)
#: meshes in words; one that is given has no window
MESHES = {
    "as fitted": FITTED,
    "fitted, without its window": fitted(past().scene.with_(mesh=FITTED)),
    "270 equal elements": Mesh("eem", 270),
    "480 equal elements": Mesh("eem", 480),
}


def heights() -> Table:
    """How much too large the peak of the default accuracy is with the divider at HEIGHTS, on MESHES."""
    rows = []
    for y in HEIGHTS:
        trip = past(y=y)._replace(stop=FINEST[2])
        fine = brush(trip, Mesh("eem", FINEST[0]), FINEST[1])
        for name, mesh in MESHES.items():
            rows.append((y, name, brush(trip, mesh).peak / fine.peak - 1.0))
    return table(("y", "mesh", "peak off by"), rows)


def orders(t: Table) -> dict[str, float]:
    """Orders of peak and impulse: 120 and 240 elements against 960, steps of 10 and 5 ms against 2 ms."""
    rows = {(r["elements"], r["step"], r["stiffness"]): r for r in records(t)}
    found = {}
    for name in ("peak", "impulse"):
        for of, keys in (
            ("length", ((120, 5e-3), (240, 5e-3), (960, 5e-3))),
            ("step", ((480, 10e-3), (480, 5e-3), (480, 2e-3))),
        ):
            coarse, fine, exact = (rows[*key, STIFFNESS][name] for key in keys)
            found[f"{name}, {of}"] = math.log2(abs(coarse - exact) / abs(fine - exact))
    return found
