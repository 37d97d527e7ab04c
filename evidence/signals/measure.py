"""A trip with each signal against the exact motion at the reference level: five minutes on two cores."""

from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from evidence.claims import text
from evidence.signals import multirate
from evidence.signals.sources import SIGNALS, Sample, Source, motion_of
from evidence.tables import Array, Measures, Tables, table
from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.parameters import Winding
from rope_model import EndMotion, Level, Scene, at_level, balance_rope, rope, rope_120
from rope_model.parameters import Layout

OUTPUTS = (
    "left.fy",
    "right.fy",
    "left.fx",
    "right.fx",
    "loop.y",
    "status.end_force_error",
    "status.loop_error",
)
COLUMNS = (
    *(
        "rope",
        "signal",
        "reading",
        "step [s]",
        "RMS",
        "largest",
        "told",
        "loop [m]",
        "loop, told [m]",
    ),
    *("misfit [m]", "warning", "failure"),
)
#: s, of standing before the trip, and after it
DELAY = 0.5
REST = 2.0
#: s, of communication, in the table that is shown
STEP = 0.01


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
    """Wind the trip."""

    def ends(x: float, v: float, a: float) -> tuple[EndMotion, EndMotion]:
        return EndMotion(y=x, vy=v, ay=a), EndMotion(y=trip.travel - x, vy=-v, ay=-a)

    running = balance_rope(scene)
    status = running.initialize(0.0, *ends(source(0.0)[0], 0.0, 0.0))
    read = running.reader(OUTPUTS)
    found = []
    for k in range(1, round((trip.motion.duration + REST) / step) + 1):
        if not status.valid:
            break
        given_at = (k if reading == "end" else k - 1) * step
        status = running.advance_to(k * step, *ends(*source(given_at)), given_at)
        found.append(read())
    misfit = running.signals(["inputs.misfit.position"])["inputs.misfit.position"]
    return Run(np.array(found), misfit, running.warnings().get("unfit_inputs", ""), status.message)


def rows(job: tuple[Trip, float]) -> list[tuple[Any, ...]]:
    """Wind with every signal, read at the start and at the end of a step; end forces' deviations are taken together."""
    trip, step = job
    found = []
    exact: Callable[[float], Sample] = partial(motion_of, trip.motion)
    right = run(trip, trip.scene("reference"), exact, step, "end").values
    for signal, reading in product(SIGNALS, ("start", "end")):
        x = run(trip, trip.scene("standard"), signal.make(exact, step), step, reading)
        n = len(x.values)
        off = (x.values[:, :4] - right[:n, :4]) / np.abs(right[:, :4]).max()
        loop = np.abs(x.values[:, 4] - right[:n, 4]).max()
        *_, told, loop_told = x.values[-1]
        rms = np.sqrt((off**2).mean(axis=0)).max()
        largest = np.abs(off).max()
        words = x.warning.partition(": ")[2].partition(";")[0]
        numbers = rms, largest, told, loop, loop_told, x.misfit
        found.append((trip.name, signal.name, reading, step, *numbers, words, x.failure))
    return found


def tables() -> Tables:
    """Wind all trips."""
    with ProcessPoolExecutor() as pool:
        parts = pool.map(rows, [(trip, step) for trip in TRIPS for step in trip.steps])
        return {"signals": table(COLUMNS, [x for part in parts for x in part])}


def missed(recorded: Tables) -> Iterator[str]:
    """Yield the targets that are missed."""
    from evidence.signals.block import claims

    return (f"{claim.what}: {text(claim)}" for claim in claims(recorded) if not claim.holds)


MEASURES: Measures = {"signals": tables, "multirate": multirate.tables}
