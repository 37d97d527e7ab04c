"""A scene wound with an accuracy, and its errors against a much finer run."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from benchmarks.kinematic import ends_at
from evidence.errors import end_error, place_error
from evidence.promise.scenes import Sample
from evidence.ropes import follow, require
from evidence.tables import Array
from rope_model import Accuracy, Mesh, Scene, Solver, balance_rope

#: s: how long a scene goes on behind its trip, and how often it is looked at, where it does not communicate more rarely
SETTLE = 3.0
EVERY = 0.02
#: what is asked: the default, and a tenth and ten times as much of it
REQUESTS = {"default": Accuracy(), "tight": Accuracy(1e-4, 1e-3), "loose": Accuracy(1e-2, 1e-1)}
#: the run that judges, and how often that communicates, s: its ends follow the trip itself
FINE: dict[str, Any] = {
    "accuracy": Accuracy(end_force=2e-5, loop=5e-4),
    "mesh": Mesh("auto", loop_error=5e-5),
    "solver": Solver(step_max=1.25e-3),
}
FINE_STEP = 1.25e-3
_SIGNALS = tuple(
    [f"{side}.{name}" for side in ("left", "right") for name in ("fx", "fy", "fz")]
    + ["loop.x", "loop.y", "loop.z"]
)
COLUMNS = (
    *("scene", "asked", "kind", "length [m]", "EI [N m2]"),
    *("interval [s]", "events", "end force", "loop [m]"),
    *(
        "end force, estimated",
        "loop, estimated [m]",
        "end force, of the fine run",
        "loop, of the fine run [m]",
    ),
    *("work", "failure"),
)


@dataclass(frozen=True)
class Run:
    """Signals (instants, ...), estimated errors, elements times corrections, swivel events, and why it ended early."""

    signals: Array
    end_force: float
    loop: float
    work: float
    events: float
    failure: str = ""


def wind(sample: Sample, interval: float, **changes: Any) -> Run:
    """The scene on its trip, with parts of it changed."""
    scene: Scene = sample.scene.with_(**changes)
    trip = sample.trajectory
    ends = partial(ends_at, trip, sample.trip.travel)
    every = max(round(max(EVERY, sample.interval) / interval), 1)
    rope = balance_rope(scene)
    try:
        require(rope.initialize(0.0, *ends(0.0)))
        rows = follow(rope, interval, trip.duration + SETTLE, ends, rope.reader(_SIGNALS))[
            every - 1 :: every
        ]
    except RuntimeError as failed:
        return Run(np.zeros((0, len(_SIGNALS))), np.nan, np.nan, np.nan, np.nan, str(failed))
    told = rope.signals(
        ("status.end_force_error", "status.loop_error", "count.newton", "count.swivel_events")
    )
    force, loop, corrections, events = told.values()
    return Run(rows, force, loop, corrections * rope.elements, events)


def errors(run: Run, fine: Run) -> tuple[float, float]:
    """Of the end forces and of the loop's place (m)."""
    n = min(len(run.signals), len(fine.signals))
    if n == 0:
        return np.nan, np.nan
    told = run.signals[:n]
    exact = fine.signals[:n]
    return end_error(told[:, :6], exact[:, :6]), place_error(told[:, 6:], exact[:, 6:])


def judge(sample: Sample, asked: Sequence[str]) -> list[tuple[Any, ...]]:
    """Rows of COLUMNS, one for each of the requests."""
    fine = wind(sample, FINE_STEP, **FINE)
    scene = sample.scene
    about = sample.kind, scene.rope.length, scene.rope.EI, sample.interval
    rows = []
    for request in asked:
        run = wind(sample, sample.interval, accuracy=REQUESTS[request])
        failure = "; ".join(filter(None, (fine.failure, run.failure)))
        told = run.end_force, run.loop, fine.end_force, fine.loop, run.work, failure
        rows.append((sample.number, request, *about, run.events, *errors(run, fine), *told))
    return rows
