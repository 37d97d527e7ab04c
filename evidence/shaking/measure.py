"""Errors by an end that shakes sideways against equal elements, estimates and warnings: a map.

The left end shakes at one frequency and amplitude, which rises smoothly in a second; position,
speed and acceleration are given.  Each case is wound on the default mesh, and on that for waves of
the frequency, mesh.lateral_frequency, up to HIGHEST.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np
from tqdm import tqdm

from evidence.errors import end_error, place_error
from evidence.ropes import at_rest, require, smooth_step
from evidence.tables import Array, Measures, Table, Tables, table
from rope_model import BalanceRope, EndMotion, Mesh, Scene, rope_120

RISE = 1.0  # s
H = 0.01  # s
#: m, equal elements to compare with, and s, their time steps
FINE = 0.25
FINE_DEEP = 0.4
FINE_STEP = 0.0025
#: s, in which waves pass the loop of 120 m and return
LASTING = 8.0
LASTING_DEEP = 3.0
#: m, heights of the left and right end
LONG_LEG = (80.0, 10.0)
SHORT_LEG = (10.0, 80.0)
#: Hz, highest lateral_frequency for which a mesh is tried
HIGHEST = 5.0
#: Hz and m
SHAKEN = (
    *((0.3, 0.03), (1.0, 0.03), (1.5, 0.01)),
    *((2.0, 0.001), (2.0, 0.003), (2.0, 0.02), (3.5, 0.002), (3.5, 0.01)),
    *((5.0, 0.001), (5.0, 0.003), (5.0, 0.01), (8.0, 0.003), (10.0, 0.001)),
)
ACROSS = (2.0, 0.02)  #: along z, too
DEEP = ((1.0, 0.03), (2.0, 0.01), (4.0, 0.003), (5.0, 0.01))
LENGTHS = (430.0, 1000.0)  # m
FORCES = ("left.fx", "left.fy", "left.fz", "right.fx", "right.fy", "right.fz")
PLACE = ("loop.x", "loop.y", "loop.z")
ESTIMATES = ("status.end_force_error", "status.loop_error")
COLUMNS = (
    *("length [m]", "left end [m]", "axis", "frequency [Hz]", "amplitude [m]", "mesh"),
    *("elements", "force error", "force estimate", "loop error [m]", "loop estimate [m]", "warned"),
)


class Shaking(NamedTuple):
    """Shaken end of a rope."""

    heights: tuple[float, float]  # m, of left and right end
    axis: str
    frequency: float  # Hz
    amplitude: float  # m
    lasting: float  # s

    def ends(self, t: float) -> tuple[EndMotion, EndMotion]:
        """Return the motions of the ends at ``t``."""
        omega = 2.0 * math.pi * self.frequency
        _, rise, rate, second = smooth_step(t / RISE)
        sine = self.amplitude * math.sin(omega * t)
        cosine = self.amplitude * math.cos(omega * t)
        motion = {
            self.axis: rise * sine,
            f"v{self.axis}": rate / RISE * sine + omega * rise * cosine,
            f"a{self.axis}": (second / RISE**2 - omega**2 * rise) * sine
            + 2.0 * omega * rate / RISE * cosine,
        }
        left, right = self.heights
        return EndMotion(y=left, **motion), EndMotion(y=right)


class Shaken(NamedTuple):
    """Rope after its end has shaken, and the record of it."""

    rope: BalanceRope
    forces: Array  # N, (samples, 6)
    places: Array  # m, (samples, 3)


def shake(scene: Scene, shaking: Shaking) -> Shaken:
    """Return the rope of ``scene`` after it was shaken."""
    rope = at_rest(scene, *shaking.ends(0.0))
    read: Callable[[], Array] = rope.reader((*FORCES, *PLACE))
    rows = []
    for k in range(1, round(shaking.lasting / H) + 1):
        require(rope.advance_to(k * H, *shaking.ends(k * H)))
        rows.append(np.array(read()))
    record = np.array(rows)
    return Shaken(rope, record[:, : len(FORCES)], record[:, len(FORCES) :])


def exact(scene: Scene, shaking: Shaking, fine: float) -> Shaken:
    """Return the rope on equal elements of the length ``fine`` (m), in short steps."""
    mesh = Mesh("eem", elements=math.ceil(scene.rope.length / fine))
    solver = replace(scene.solver, step_max=FINE_STEP)
    return shake(scene.with_(mesh=mesh, solver=solver), shaking)


def errors(scene: Scene, shaking: Shaking, truth: Shaken) -> tuple[object, ...]:
    """Return elements, errors, estimates and whether the rope warned."""
    run = shake(scene, shaking)
    force, place = run.rope.signals(ESTIMATES).values()
    return (
        run.rope.elements,
        end_error(run.forces, truth.forces),
        force,
        place_error(run.places, truth.places),
        place,
        int("shakes sideways" in run.rope.warnings().get("unresolved_waves", "")),
    )


def compared(scene: Scene, shaking: Shaking, fine: float) -> list[tuple[object, ...]]:
    """Return a row for the default mesh, and one for that of the frequency."""
    truth = exact(scene, shaking, fine)
    waves = Mesh("auto", lateral_frequency=shaking.frequency)
    head = (
        scene.rope.length,
        shaking.heights[0],
        shaking.axis,
        shaking.frequency,
        shaking.amplitude,
    )
    return [
        (*head, name, *errors(scene.with_(mesh=mesh), shaking, truth))
        for name, mesh in (("default", scene.mesh), ("waves", waves))
        if name == "default" or shaking.frequency <= HIGHEST
    ]


def _short(heights: tuple[float, float]) -> Table:
    """Measure the rope of 120 m (a minute)."""
    cases = [("x", *shaken) for shaken in SHAKEN]
    cases += [("z", *shaken) for shaken in SHAKEN if shaken == ACROSS]
    rows: list[tuple[object, ...]] = []
    for axis, frequency, amplitude in tqdm(cases, desc="shaking, 120 m", leave=False):
        shaking = Shaking(heights, axis, frequency, amplitude, LASTING)
        rows += compared(rope_120().scene, shaking, FINE)
    return table(COLUMNS, rows)


def long_leg() -> Tables:
    """Measure the rope of 120 m with the long leg shaken."""
    return {"long_leg": _short(LONG_LEG)}


def short_leg() -> Tables:
    """Measure the rope of 120 m with the short leg shaken."""
    return {"short_leg": _short(SHORT_LEG)}


def deep() -> Tables:
    """Measure longer ropes, for a time in which no wave reaches the loop (a minute)."""
    rows: list[tuple[object, ...]] = []
    for length, (frequency, amplitude) in tqdm(
        [*product(LENGTHS, DEEP)], desc="shaking, deep", leave=False
    ):
        base = rope_120().scene
        scene = base.with_(rope=replace(base.rope, length=length))
        shaking = Shaking((0.6 * length, 0.0), "x", frequency, amplitude, LASTING_DEEP)
        rows += compared(scene, shaking, FINE_DEEP)
    return {"deep": table(COLUMNS, rows)}


MEASURES: Measures = {"long_leg": long_leg, "short_leg": short_leg, "deep": deep}
