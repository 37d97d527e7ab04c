"""A leg that brushes a thin divider while the rope runs past it: force over time, its peak and its impulse."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from evidence.tables import Table, table
from rope_model import EndMotion
from rope_model.parameters import Mesh, Scene, Solver
from rope_model.shaft_parameters import Contact, Divider, Shaft

from .scenes import made, smooth_step

Array = NDArray[np.float64]
#: m: size of the divider, its height and its place; how far the ends move, in so many seconds, of so many
SIZE, HEIGHT, OFFSET, RISE, MOVES, STOP = 0.05, -25.0, -0.9, 40.0, 14.0, 10.0
#: s: steps whose error is not controlled, longest first; the step of the others
STEPS, STEP = (8e-3, 4e-3, 2e-3, 1e-3), 2e-3
#: elements of equal length, and stiffnesses of the contact, N/m^2
ELEMENTS, STIFFNESSES = (240, 480), (1e5, 1e7)
#: m: deeper places must be pressed
INSIDE = 5e-4
_COLUMNS = ("mesh", "step", "stiffness", "peak", "impulse", "told", "gaps")
_SIGNALS = ("contact.divider", "clearance.divider", "contact.divider.impulse", "status.contact_error")


@dataclass(frozen=True)
class Brushed:
    """Pressure (N) at ``t`` (s), its impulse (N s), the error told of it, samples that are inside without a force."""

    t: Array
    pressure: Array
    impulse: float
    told: float
    gaps: int

    @property
    def peak(self) -> float:
        """Largest pressure, N."""
        return float(self.pressure.max())


@cache
def brushed(elements: int = 0, step: float = 0.0, stiffness: float = Contact().stiffness) -> Brushed:
    """The rope past the divider, on so many equal elements and with steps of this length; 0: as they are by default."""
    shaft = Shaft(divider_1=Divider(size=SIZE, y=HEIGHT, offset=OFFSET), contact=Contact(stiffness=stiffness))
    mesh = Mesh("eem", elements=elements) if elements else Mesh()
    solver = Solver(step_max=step, tolerance=1e3) if step else Solver()
    rope, H, rows = made(Scene(mesh=mesh, solver=solver, shaft=shaft), EndMotion(), EndMotion()), 8e-3, []
    for k in range(1, round(STOP / H) + 1):
        _, value, rate, second = smooth_step(k * H / MOVES)
        y, v, a = RISE * value, RISE * rate / MOVES, RISE * second / MOVES**2
        status = rope.advance_to(k * H, EndMotion(y=y, vy=v, ay=a), EndMotion(y=-y, vy=-v, ay=-a))
        if not status.valid:
            raise RuntimeError(status.message)
        rows.append((k * H, *rope.signals(_SIGNALS).values()))
    t, pressure, clearance, impulse, told = np.array(rows).T
    gaps = int(np.count_nonzero((clearance < -INSIDE) & (pressure == 0.0)))
    return Brushed(t, pressure, float(impulse[-1]), float(told[-1]), gaps)


def brushed_table() -> Table:
    """Every run: the default, steps, meshes, stiffnesses."""
    runs = [(0, 0.0, Contact().stiffness), *((0, h, Contact().stiffness) for h in STEPS)]
    runs += [(n, STEP, Contact().stiffness) for n in ELEMENTS]
    runs += [(ELEMENTS[-1], STEP, k) for k in STIFFNESSES]
    found = [(run, brushed(*run)) for run in runs]
    return table(
        _COLUMNS,
        [(f"{n} equal" if n else "fitted", step, k, x.peak, x.impulse, x.told, x.gaps) for (n, step, k), x in found],
    )
