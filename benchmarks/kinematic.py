"""Windings with the conveyances' motion prescribed, for benchmarks and evidence."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import Trajectory, TrajectoryPoint
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from rope_model import BalanceRope, EndMotion, Model, Scene, Solver, Status, balance_rope
from rope_model.state import Event

Array = NDArray[np.float64]
H = 0.01  # s, communication step
OBSERVED_HEIGHT = 3.0  # m, of the observation points over the rope's lowest point, as in the source
OBSERVED = 7  # columns of a node that are observed: r, r', theta
READ = ("loop.x", "loop.y", "loop.z", "energy.kinetic")


def fixed_steps(h: float) -> Solver:
    """Steps of ``h`` (s), which no local error shortens."""
    return Solver(step_max=h, tolerance=1e6)


@dataclass
class Winding:
    """Records of a run, sampled every ``sample`` communication steps."""

    rope: BalanceRope
    status: Status
    t: list[float] = field(default_factory=list)
    force: list[Array] = field(default_factory=list)  # N, left and right
    bottom: list[Array] = field(default_factory=list)  # m
    observed: list[Array] = field(default_factory=list)  # r, r', theta at two points, (2, 7)
    kinetic: list[float] = field(default_factory=list)  # J
    events: list[Event] = field(default_factory=list)
    simulated: float = 0.0  # s
    cpu: float = 0.0  # s, of the steps alone

    def completed(self, what: str = "the winding") -> Winding:
        """Return the run; RuntimeError where it failed."""
        if not self.status.valid:
            raise RuntimeError(f"{what}: {self.status.message}")
        return self


def scene_of(rope: str, coupling: str) -> Scene:
    """The rope of a case between locked ends; uncoupled it is planar, which then is exact."""
    scene = rope_scene(find_case(rope).rope)
    scene = scene.with_(
        solver=fixed_steps(H),
        model=Model("torsional"),
        left=replace(scene.left, mode="locked"),
        right=replace(scene.right, mode="locked"),
    )
    if coupling == "coupled":
        return scene
    return scene.with_(rope=replace(scene.rope, Qb=0.0, Qc=0.0), model=Model("planar"))


class Reference(Protocol):
    """How the left end moves."""

    def at(self, t: float) -> TrajectoryPoint:
        """The motion at ``t``."""


def ends_at(reference: Reference, travel: float, t: float) -> tuple[EndMotion, EndMotion]:
    """Left end from height 0, right end from ``travel`` (m)."""
    p = reference.at(t)
    left = EndMotion(y=p.position, vy=p.speed, ay=p.acceleration)
    return left, EndMotion(y=travel - p.position, vy=-p.speed, ay=-p.acceleration)


def wind(
    scene: Scene,
    reference: Trajectory,
    travel: float,
    settle: float = 3.0,
    sample: int = 5,
    watch: Callable[[BalanceRope], None] | None = None,
    interval: float = H,
    build: Callable[[Scene], BalanceRope] = balance_rope,
) -> Winding:
    """Follow ``reference`` and ``settle`` seconds more, in communication steps of ``interval``.

    A record is made every ``sample`` steps; ``watch`` is called with the rope at every record.
    """
    rope = build(scene)
    read = rope.reader(READ)
    run = Winding(rope, rope.initialize(0.0, *ends_at(reference, travel, 0.0)))
    if not run.status.valid:
        return run
    for k in range(1, round((reference.duration + settle) / interval) + 1):
        ends = ends_at(reference, travel, k * interval)
        start = time.process_time()
        run.status = rope.advance_to(k * interval, *ends)
        run.cpu += time.process_time() - start
        if not run.status.valid:
            break
        run.simulated = k * interval
        run.events += rope.state.events
        if k % sample == 0:
            state = rope.state
            *bottom_at, kinetic = read()
            bottom = np.array(bottom_at)
            run.t.append(run.simulated)
            run.force.append(-state.motion.reaction[[0, -1], 1])
            run.bottom.append(bottom)
            run.observed.append(observation_points(state.motion.q, bottom))
            run.kinetic.append(kinetic)
            if watch is not None:
                watch(rope)
    return run


def observation_points(q: np.ndarray, bottom: np.ndarray) -> np.ndarray:
    """Return r, r', theta on the left and right leg, (2, 7), above the lowest point ``bottom``."""
    i = int(np.argmin(q[:, 1]))
    height = bottom[1] + OBSERVED_HEIGHT
    return np.array([_row_at(height, leg) for leg in (q[i::-1], q[i:])])


def _row_at(height: float, leg: np.ndarray) -> list[float]:
    """Return r, r', theta of a leg at this height, interpolated between its nodes."""
    return [float(np.interp(height, leg[:, 1], leg[:, k])) for k in range(OBSERVED)]
