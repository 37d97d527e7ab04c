"""A trip with each signal against the exact motion at the reference level."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.parameters import Winding
from rope_model import EndMotion, Level, Scene, at_level, balance_rope, rope, rope_120
from rope_model.parameters import Layout

from .sources import SIGNALS, Signal, Source

OUTPUTS = ("left.fy", "right.fy", "left.fx", "right.fx", "loop.y", "status.end_force_error", "status.loop_error")
COLUMNS = (
    *("rope", "signal", "reading", "step [s]", "RMS", "largest", "told", "loop [m]", "loop, told [m]"),
    *("misfit [m]", "warning", "failure"),
)
#: s, of standing before the trip, and after it
DELAY, REST = 0.5, 2.0
#: s, of communication, in the table that is shown
STEP = 0.01
READINGS = ("start", "end")

Array = NDArray[np.float64]


class Trip(NamedTuple):
    """A rope and the way of its left end, up; the right end goes down."""

    name: str
    scene: Callable[[Level], Scene]
    travel: float  # m
    speed: float  # m/s
    steps: tuple[float, ...]  # s, of communication

    @property
    def motion(self) -> Trajectory:
        """The S-curve after some standing."""
        return s_curve(Winding(travel=self.travel, speed=self.speed, start_delay=DELAY))


def _usual(level: Level) -> Scene:
    return rope_120(level).scene


def _deep(level: Level) -> Scene:
    known = rope("34x7", diameter=0.052, length=910.0)
    return at_level(Scene(rope=known.middle, layout=Layout(spacing=2.2)), level)


#: the second is one that nothing was developed on
TRIPS = (
    Trip("120 m", _usual, 90.0, 8.0, (0.001, 0.005, 0.01, 0.02, 0.05)),
    Trip("910 m", _deep, 870.0, 16.0, (0.01,)),
)


class Run(NamedTuple):
    """Outputs at the ends of the steps, and what was said."""

    values: Array  # (steps, OUTPUTS)
    misfit: float
    warning: str
    failure: str


def run(trip: Trip, scene: Scene, source: Source, step: float, reading: str) -> Run:
    """The trip in process."""
    running = balance_rope(scene)
    status = running.initialize(0.0, *_ends(trip, (source(0.0)[0], 0.0, 0.0)))
    read, found = running.reader(OUTPUTS), []
    for k in range(1, round((trip.motion.duration + REST) / step) + 1):
        if not status.valid:
            break
        given_at = (k if reading == "end" else k - 1) * step
        status = running.advance_to(k * step, *_ends(trip, source(given_at)), given_at)
        found.append(read())
    misfit = running.signals(["inputs.misfit.position"])["inputs.misfit.position"]
    return Run(np.array(found), misfit, running.warnings().get("unfit_inputs", ""), status.message)


def _ends(trip: Trip, sample: tuple[float, float, float]) -> tuple[EndMotion, EndMotion]:
    x, v, a = sample
    return EndMotion(y=x, vy=v, ay=a), EndMotion(y=trip.travel - x, vy=-v, ay=-a)


def row(trip: Trip, signal: Signal, step: float, reading: str, exact: Array, found: Run) -> tuple[Any, ...]:
    """Deviations of a run; those of vertical and horizontal end forces together."""
    n = len(found.values)
    off = (found.values[:, :4] - exact[:n, :4]) / np.abs(exact[:, :4]).max()
    loop = np.abs(found.values[:, 4] - exact[:n, 4]).max()
    *_, told, loop_told = found.values[-1]
    rms = np.sqrt((off**2).mean(axis=0)).max()
    largest = np.abs(off).max()
    words = found.warning.partition(": ")[2].partition(";")[0]
    numbers = rms, largest, told, loop, loop_told, found.misfit
    return trip.name, signal.name, reading, step, *numbers, words, found.failure


def rows(trip: Trip, step: float) -> Iterator[tuple[Any, ...]]:
    """Every signal, read at the start and at the end of a step."""
    exact = run(trip, trip.scene("reference"), SIGNALS[0].make(trip.motion, step), step, "end").values
    for signal in SIGNALS:
        for reading in READINGS:
            source = signal.make(trip.motion, step)
            yield row(trip, signal, step, reading, exact, run(trip, trip.scene("standard"), source, step, reading))
