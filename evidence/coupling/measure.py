"""Runs of the hoist with the rope in process, and their errors against the converged exchange.

The reference iterates every exchange to convergence on the rope's own steps: both partners then fulfil the interface
at every step of the rope, which is the monolithic solution of that time integration.
"""

import math
import time
from dataclasses import dataclass, replace

import numpy as np
from tqdm import tqdm

from evidence.errors import force_error
from evidence.tables import Measures, Tables, table
from hoist_demo.cases.case import HOISTS
from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.cosimulation.schemes.interface import Scheme
from hoist_demo.cosimulation.schemes.iterative import Iterative
from hoist_demo.parameters import Coupling, Winding
from rope_model.cases import Level

#: N, of a force of 8 kN
CONVERGED = Iterative("secant", tolerance=1e-3)
#: s, communication steps of the schemes, and of the rope in those runs and in the reference's exchange
STEPS = (0.04, 0.02, 0.01, 0.005)
ROPE_STEP = 0.0025
#: s, of the cases' runs
CASE_STEP = 0.01
CASE_REFERENCE = 0.005
#: m, of the installed cases, whose whole trips take long: from the landing with the heaviest leg, full acceleration
SHORTENED = 60.0


@dataclass(frozen=True)
class Case:
    """A trip of a case of the hoist."""

    name: str  # in HOISTS
    winding: Winding
    level: Level = "standard"
    rope_step: float | None = None  # s, the rope's own steps at most; None: those of the level
    sample: float = 0.04  # s, of the controller


SHORT = Case("rope-120", Winding(travel=0.5, settle=0.4, start_delay=0.1), "draft", ROPE_STEP)


@dataclass(frozen=True)
class Run:
    """What is kept of a run."""

    force: np.ndarray  # (samples, 2), N
    processor: float  # s, per simulated second
    exchanges: float  # per step
    growth: float  # predicted before the start, of a disturbance per step
    cause: str


def wind(case: Case, scheme: Scheme, H: float) -> Run:
    """Make one run."""
    scene = find_case(case.name)
    data = rope_scene(scene.rope, case.level)
    if case.rope_step is not None:
        data = data.with_(solver=replace(data.solver, step_max=case.rope_step))
    coupling = Coupling(step=H, sample=case.sample)
    host = Host(
        InProcessRope(data), scene.hoist, case.winding, coupling, scene.gains, scheme=scheme
    )
    start = time.process_time()
    result: Result = host.run()
    spent = time.process_time() - start
    r = result.recording
    growth = host.stability.growth_per_step if host.stability is not None else math.nan
    exchanges = float(r["coupling.exchanges"][-1]) / result.steps
    force = np.column_stack([r["left.fy"], r["right.fy"]])
    return Run(force, spent / (result.steps * H), exchanges, growth, result.cause)


def schemes() -> Tables:
    """Measure error and cost of every scheme on the hoist's first half metre."""
    exact = wind(SHORT, CONVERGED, ROPE_STEP)
    rows = []
    for name, given in tqdm(SCHEMES.items(), desc="schemes", unit="scheme", leave=False):
        scheme = replace(given, tolerance=0.01) if isinstance(given, Iterative) else given
        for H in STEPS:
            run = wind(SHORT, scheme, H)
            error, cost = (
                (math.inf, math.nan)
                if run.cause
                else (force_error(run.force, exact.force), run.processor)
            )
            rows.append((name, H, error, run.exchanges, cost, run.cause))
    names = ("scheme", "H [s]", "force error", "exchanges per step", "cost [s/s]", "cause")
    return {"schemes": table(names, rows)}


def cases() -> Tables:
    """Measure the default scheme at 10 ms on every case's trip."""
    rows = []
    for name in tqdm(HOISTS, desc="cases", unit="case", leave=False):
        setup = find_case(name)
        travel = SHORTENED if not name.startswith("rope-") else setup.winding.travel
        winding = replace(setup.winding, travel=travel, settle=2.0)
        case = Case(name, winding, rope_step=CASE_REFERENCE, sample=CASE_STEP)
        exact = wind(case, CONVERGED, CASE_REFERENCE)
        run = wind(replace(case, rope_step=None), SCHEMES[Coupling().scheme], CASE_STEP)
        largest = float(np.max(np.abs(run.force - exact.force)) / np.max(np.abs(exact.force)))
        ratio = setup.hoist.tail_mass * setup.hoist.tail_rope_length / setup.hoist.conveyance_mass
        errors = force_error(run.force, exact.force), largest
        rows.append((name, ratio, travel, *errors, run.growth, run.cause or exact.cause))
    names = (
        *("case", "ropes over conveyance", "travel [m]"),
        *("force error", "largest error", "predicted growth", "cause"),
    )
    return {"cases": table(names, rows)}


MEASURES: Measures = {"schemes": schemes, "cases": cases}
