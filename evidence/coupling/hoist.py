"""Runs of the hoist with the rope in process, and their errors against the converged exchange.

The reference iterates every exchange to convergence on the rope's own steps: both partners then fulfil the interface
at every step of the rope, which is the monolithic solution of that time integration.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cases.table import CASES
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_data
from hoist_demo.cosimulation.result import Result
from hoist_demo.cosimulation.schemes.interface import Scheme
from hoist_demo.cosimulation.schemes.iterative import Iterative
from hoist_demo.parameters import Coupling, Winding
from rope_model.parameters import Level

Array = NDArray[np.float64]

CONVERGED = Iterative("secant", tolerance=1e-3)
"""Tolerance in N, of a force of 8 kN."""


@dataclass(frozen=True)
class Case:
    """A trip of a case of the hoist."""

    name: str  # in CASES
    winding: Winding
    level: Level = "standard"
    rope_step: float | None = None  # s, the rope's own steps at most; None: those of the level
    sample: float = 0.04  # s, of the controller


@dataclass(frozen=True)
class Run:
    """What is kept of a run."""

    force: Array  # (samples, 2), N
    processor: float  # s
    simulated: float  # s
    exchanges: float
    taken_back: float
    power: float  # W, largest mean over a sample that the exchange made up
    growth: float  # predicted before the start, of a disturbance per step
    cause: str


def wind(case: Case, scheme: str | Scheme, H: float) -> Run:
    """One run; a scheme may be given that has no name."""
    scene = CASES[case.name]
    data = rope_data(scene.rope, case.level)
    if case.rope_step is not None:
        data = data.with_(solver=replace(data.solver, step_max=case.rope_step))
    coupling, unnamed = Coupling(step=H, sample=case.sample), None
    if isinstance(scheme, str):
        coupling = replace(coupling, scheme=scheme)
    else:
        unnamed = scheme
    host = Host(InProcessRope(data), scene.hoist, case.winding, coupling, scene.gains, scheme=unnamed)
    start = time.process_time()
    result: Result = host.run()
    spent = time.process_time() - start
    r = result.recording
    power = np.abs(np.diff(r["coupling.energy"])) / case.sample
    return Run(
        np.column_stack([r["left.fy"], r["right.fy"]]),
        spent,
        result.steps * H,
        float(r["coupling.exchanges"][-1]),
        float(r["coupling.exchanges"][-1]) - result.steps,
        float(np.max(power, initial=0.0)),
        host.stability.growth if host.stability is not None else float("nan"),
        result.cause,
    )


def errors(run: Run, exact: Run) -> tuple[float, float]:
    """RMS and largest error of both end forces over the largest force; infinite when the run stopped."""
    if run.cause:
        return float("inf"), float("inf")
    difference, largest = run.force - exact.force, np.max(np.abs(exact.force))
    return float(np.sqrt(np.mean(difference**2)) / largest), float(np.max(np.abs(difference)) / largest)
