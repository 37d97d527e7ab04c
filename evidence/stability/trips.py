"""Ropes hung and wound, with the records the entries compare."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.kinematic import ends_at
from evidence.tables import Array
from hoist_demo.control.trajectory import Trajectory, s_curve
from hoist_demo.parameters import Winding
from rope_model.parameters import Scene
from rope_model.simulation.balance_rope import Status
from rope_model.simulation.ends.paths import EndMotion
from rope_model.simulation.simulator import RopeSimulator


@dataclass(frozen=True)
class Record:
    """A run, one row per communication step; ``wanted`` is the duration it was to have, s."""

    rope: RopeSimulator
    status: Status
    wanted: float
    t: Array  # s
    bottom: Array  # (n, 3) m, the loop's lowest point
    force: Array  # (n, 2) N, vertical, of the conveyances on the left and right end

    @property
    def completion(self) -> float:
        """Part of the run that was done."""
        return float(self.t[-1]) / self.wanted if self.t.size else 0.0


def trip(travel: float, speed: float, acceleration: float, jerk: float) -> Trajectory:
    """An S-curve that begins at once."""
    stop = max(acceleration, 5.0)  # not used, but validated
    return s_curve(Winding(travel, speed, acceleration, jerk, start_delay=0.0, emergency_deceleration=stop))


def hang(scene: Scene, left: float = 0.0, right: float = 0.0) -> RopeSimulator:
    """The rope at rest between ends at these heights, m."""
    rope = RopeSimulator(scene)
    status = rope.initialize(0.0, EndMotion(y=left), EndMotion(y=right))
    assert status.valid, status.message
    return rope


def follow(rope: RopeSimulator, reference: Any, travel: float, interval: float = 0.01, settle: float = 1.0) -> Record:
    """``reference`` followed from the rope's present time to its end and ``settle`` s more, or to the first failure.

    The left end goes up from height 0, the right one down from ``travel``.
    """
    status, rows = Status(True), []
    wanted = reference.duration + settle
    first = round(rope.state.motion.t / interval) + 1
    for k in range(first, round(wanted / interval) + 1):
        status = rope.advance_to(k * interval, *ends_at(reference, travel, k * interval))
        if not status.valid:
            break
        m = rope.state.motion
        rows.append([m.t, *rope.loop.position, *m.reaction[[0, -1], 1]])
    x = np.array(rows).reshape(-1, 6)
    return Record(rope, status, wanted, x[:, 0], x[:, 1:4], x[:, 4:6])


def without_transformations(rope: RopeSimulator) -> RopeSimulator:
    """The same rope, whose mesh stays from now on as it is."""
    state = rope.state
    fixed = replace(state.partition, counts=(0,) * 7, coarse=0.0)
    rope._accept(state._replace(partition=fixed))  # which restore refuses
    return rope
