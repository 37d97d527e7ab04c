"""A leg that brushes a thin divider while the rope runs past it: force over time, its peak and its impulse."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from rope_model import EndMotion
from rope_model.parameters import Mesh, Scene, Solver
from rope_model.shaft_parameters import Contact, Divider, Shaft

from .scenes import made, smooth_step

Array = NDArray[np.float64]
#: m: size of the divider, its height and its place; how far the ends move, in so many seconds, of so many
SIZE, HEIGHT, OFFSET, RISE, MOVES, STOP = 0.05, -25.0, -0.9, 40.0, 14.0, 10.0
#: equal elements and steps (s) of the fine run
FINE = 480, 2e-3
#: m: deeper places must be pressed
INSIDE = 5e-4
_SIGNALS = ("contact.divider", "clearance.divider", "contact.divider.impulse", "status.contact_error")
_MORE = ("left.fx", "left.fy", "right.fx", "right.fy", "loop.x", "loop.y", "loop.z")


@dataclass(frozen=True)
class Brushed:
    """Pressure (N) at ``t`` (s), its impulse (N s), the error told of it, samples that are inside without a force.

    ``forces`` (N) are those at the ends, ``loop`` (m) its place; ``square`` (N^2 s) is that of physics.contact_error.
    """

    t: Array
    pressure: Array
    impulse: float
    told: float
    gaps: int
    forces: Array
    loop: Array
    square: float

    @property
    def peak(self) -> float:
        """Largest pressure, N."""
        return float(self.pressure.max())


@cache
def brushed(
    elements: int = 0,
    step: float = 0.0,
    stiffness: float = Contact().stiffness,
    offset: float = OFFSET,
    height: float = HEIGHT,
) -> Brushed:
    """The rope past the divider, on so many equal elements and with steps of this length; 0: as they are by default."""
    shaft = Shaft(divider_1=Divider(size=SIZE, y=height, offset=offset), contact=Contact(stiffness=stiffness))
    mesh = Mesh("eem", elements=elements) if elements else Mesh("auto")
    solver = Solver(step_max=step, tolerance=1e3) if step else Solver()
    rope, H, rows = made(Scene(mesh=mesh, solver=solver, shaft=shaft), EndMotion(), EndMotion()), 1e-2, []
    for k in range(1, round(STOP / H) + 1):
        _, value, rate, second = smooth_step(k * H / MOVES)
        y, v, a = RISE * value, RISE * rate / MOVES, RISE * second / MOVES**2
        status = rope.advance_to(k * H, EndMotion(y=y, vy=v, ay=a), EndMotion(y=-y, vy=-v, ay=-a))
        if not status.valid:
            raise RuntimeError(status.message)
        rows.append((k * H, *rope.signals((*_SIGNALS, *_MORE)).values()))
    t, pressure, clearance, impulse, told, *more = np.array(rows).T
    gaps = int(np.count_nonzero((clearance < -INSIDE) & (pressure == 0.0)))
    forces, loop = np.array(more[:4]), np.array(more[4:])
    square = float(rope.state.contact.square)
    return Brushed(t, pressure, float(impulse[-1]), float(told[-1]), gaps, forces, loop, square)


def missed(coarse: Brushed, fine: Brushed) -> float:
    """Error of the pressure, root mean square while either presses, relative to the largest."""
    presses = (coarse.pressure > 0.0) | (fine.pressure > 0.0)
    return float(np.sqrt(np.square(coarse.pressure - fine.pressure)[presses].mean()) / fine.peak)
