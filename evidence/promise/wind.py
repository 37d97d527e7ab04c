"""A scene wound with an accuracy, and what it errs by against a much finer run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.kinematic import ends_at
from rope_model import Accuracy, BalanceRope, Mesh, Scene, Solver, balance_rope

from .scenes import Sample

Array = NDArray[np.float64]
SETTLE, EVERY = 3.0, 0.02  # s
#: what is asked: the defaults; and those before, with steps by the places of the nodes alone, 1 mm in a step
ASKED = Accuracy()
BEFORE: dict[str, Any] = {
    "accuracy": Accuracy(end_force=1.0, loop=1.0),
    "mesh": Mesh("auto", loop_error=5e-3),
    "solver": Solver(tolerance=0.1, newton_tolerance=1e-7),
}
#: the run that judges
FINE: dict[str, Any] = {
    "accuracy": Accuracy(end_force=1e-4, loop=1e-3),
    "mesh": Mesh("auto", loop_error=2e-4),
    "solver": Solver(step_max=1.25e-3),
}
_SIGNALS = tuple(
    [f"{side}.{name}" for side in ("left", "right") for name in ("fx", "fy", "fz")]
    + ["loop.x", "loop.y", "loop.z", "left.mz", "right.mz", "left.swivel.angle", "right.swivel.angle"]
)
COLUMNS = (
    *("scene", "kind", "length [m]", "mass [kg/m]", "EI [N m2]", "swivel", "speed [m/s]", "interval [s]"),
    *("end force", "horizontal force", "loop [m]", "clamp moment", "swivel angle [rad]"),
    *("end force, estimated", "loop, estimated [m]", "end force, of the fine run", "loop, of the fine run [m]"),
    "work",
    *("end force, before", "loop, before [m]", "work, before", "failure"),
)


@dataclass(frozen=True)
class Run:
    """Signals (instants, ...), estimated errors, elements times corrections, and why it ended early.

    There are signals every EVERY s, or every communication step where those are longer.
    """

    signals: Array
    end_force: float
    loop: float
    work: float
    failure: str = ""


def wind(sample: Sample, interval: float, build: Callable[[Scene], BalanceRope] = balance_rope, **changes: Any) -> Run:
    """The scene on its trip, with parts of it changed."""
    scene: Scene = sample.scene.with_(**changes)
    trip, rope = sample.trajectory, build(scene)
    every = max(round(EVERY / interval), 1)
    status = rope.initialize(0.0, *ends_at(trip, sample.trip.travel, 0.0))
    read, rows = rope.reader(_SIGNALS), []
    for k in range(1, round((trip.duration + SETTLE) / interval) + 1) if status.valid else ():
        status = rope.advance_to(k * interval, *ends_at(trip, sample.trip.travel, k * interval))
        if not status.valid:
            break
        if k % every == 0:
            rows.append(read())
    if not status.valid:
        return Run(np.zeros((0, len(_SIGNALS))), np.nan, np.nan, np.nan, status.message)
    told = rope.signals(("status.end_force_error", "status.loop_error", "count.newton"))
    force, loop, corrections = told.values()
    return Run(np.array(rows), force, loop, corrections * rope.elements)


def errors(run: Run, fine: Run) -> tuple[float, ...]:
    """Of end force, its horizontal part, place of the loop, clamp moment, swivel angle; see COLUMNS.

    Forces and moments: root mean square of the worse end, relative to the largest.  Loop and angle: the largest.
    """
    n = min(len(run.signals), len(fine.signals))
    if n == 0:
        return (np.nan,) * 5
    exact, off = fine.signals[:n], run.signals[:n] - fine.signals[:n]
    force, side = exact[:, :6].reshape(n, 2, 3), off[:, :6].reshape(n, 2, 3)
    largest = np.linalg.norm(force, axis=2).max()
    return (
        _rms(np.linalg.norm(side, axis=2)) / largest,
        _rms(np.linalg.norm(side[:, :, ::2], axis=2)) / largest,
        float(np.linalg.norm(off[:, 6:9], axis=1).max()),
        _rms(off[:, 9:11]) / float(np.abs(exact[:, 9:11]).max()),
        float(np.abs(off[:, 11:]).max()),
    )


def judge(sample: Sample, asked: Accuracy = ASKED) -> tuple[Any, ...]:
    """A row of COLUMNS."""
    fine = wind(sample, sample.interval, **FINE)
    run, before = wind(sample, sample.interval, accuracy=asked), wind(sample, sample.interval, **BEFORE)
    rope, failure = sample.scene.rope, "; ".join(filter(None, (fine.failure, run.failure, before.failure)))
    found, then = errors(run, fine), errors(before, fine)
    return (
        *(sample.number, sample.kind, rope.length, rope.mass_per_length, rope.EI, sample.scene.left.mode),
        *(sample.trajectory.peak_speed, sample.interval, *found),
        *(run.end_force, run.loop, fine.end_force, fine.loop, run.work, then[0], then[2], before.work, failure),
    )


def _rms(x: Array) -> float:
    """Root mean square over time, of the worse end."""
    return float(np.sqrt((x**2).mean(axis=0)).max())
