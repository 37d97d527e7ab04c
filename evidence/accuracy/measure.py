"""Windings of the points, their errors against the reference solution, and their processor times."""

import math
from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from benchmarks.kinematic import wind
from evidence.accuracy import depth
from evidence.accuracy.front import pareto
from evidence.accuracy.points import FINEST, SAMPLE, SETTLE, TRIP, Point, points
from evidence.errors import force_error, place_error
from evidence.machine import machine
from evidence.reproduction.windings import COUPLINGS, TRAVEL
from evidence.tables import Array, Measures, Tables, table
from hoist_demo.control.trajectory import s_curve
from rope_model.parameters import Scene
from rope_model.reference.mesh import fitted

ROUNDS = 3
#: families of which every point is repeated
ALWAYS = ("levels", "fidelities")
#: s of processor time; a longer run is not repeated
SLOW = 3.0
ERRORS = ("force error", "loop error [m]", "twist error [rad]")
COST = "processor time [s/s]"
COLUMNS = (
    *("family", "name", "coupling", "fidelity", "kernels", "mesh", "elements"),
    *("largest step [s]", "communication step [s]"),
    *("rounds", COST, *ERRORS),
    "failure",
)


@dataclass
class Run:
    """What is kept of a winding: records at the samples, and s of processor time per simulated second."""

    force: Array  # (samples, 2), N
    bottom: Array  # (samples, 3), m
    theta: Array  # (samples, 2), rad, at the observation points
    fidelity: str
    kernels: str
    elements: int
    simulated: float  # s
    costs: list[float]  # one per round
    failure: str

    @property
    def cost(self) -> float:
        """Median over the rounds."""
        return float(np.median(self.costs)) if not self.failure else float("nan")


def follow(point: Point) -> Run:
    """One winding."""
    sample = round(SAMPLE / point.communication)
    trip = s_curve(TRIP)
    end = SAMPLE * math.ceil(
        (trip.duration + SETTLE) / SAMPLE
    )  # the same for every communication step
    run = wind(point.scene, trip, TRAVEL, end - trip.duration, sample, interval=point.communication)
    if not run.t:
        return Run(*3 * (np.zeros((0, 2)),), "", "", 0, 0.0, [], run.status.message or "no sample")
    state = run.rope.state
    return Run(
        np.array(run.force),
        np.array(run.bottom),
        np.array(run.observed)[:, :, 6],
        state.fidelity,
        run.rope.form,
        state.partition.lengths.size,
        run.simulated,
        [run.cpu / run.simulated],
        run.status.message,
    )


def errors(run: Run, exact: Run, coupling: str) -> tuple[float, float, float]:
    """ERRORS: RMS of both end forces over the largest, greatest distance of the loop's lowest point, and of theta.

    Theta is not compared where nothing twists the rope.
    """
    if run.failure:
        return float("nan"), float("nan"), float("nan")
    twisted = coupling == "coupled" and run.fidelity == "torsional"
    theta = float(np.max(np.abs(run.theta - exact.theta))) if twisted else float("nan")
    return force_error(run.force, exact.force), place_error(run.bottom, exact.bottom), theta


def measure() -> Tables:
    """Every point once, those on a front and those of ALWAYS again in each further round."""
    exact = {p.coupling: p for p in points() if (p.family, p.name) == ("reference", FINEST)}
    runs: dict[tuple[Scene, float], Run] = {}
    for p in tqdm(points(), desc="round 1", unit="run", leave=False):
        if _key(p) not in runs:
            runs[_key(p)] = follow(p)
    failed = {c: runs[_key(p)].failure for c, p in exact.items() if runs[_key(p)].failure}
    if failed:
        raise RuntimeError(f"the reference solution fails: {failed}")
    found = {
        p: (run := runs[_key(p)], errors(run, runs[_key(exact[p.coupling])], p.coupling))
        for p in points()
    }
    again = {_key(p): p for p in _worth_repeating(found)}
    for k in range(2, ROUNDS + 1):
        for key, p in tqdm(again.items(), desc=f"round {k}", unit="run", leave=False):
            runs[key].costs += follow(p).costs
    rows = [_row(p, runs[_key(p)], e) for p, (_, e) in found.items()]
    return {"points": table(COLUMNS, rows), "machine": machine()}


def _key(point: Point) -> tuple[Scene, float]:
    """The same for points that are the same run."""
    scene = point.scene
    return scene.with_(mesh=fitted(scene)), point.communication


def _worth_repeating(found: dict[Point, tuple[Run, tuple[float, float, float]]]) -> list[Point]:
    kept = [p for p in found if p.family in ALWAYS]
    for coupling in COUPLINGS:
        for family in ("eem", "tmn"):
            group = [p for p in found if (p.coupling, p.family) == (coupling, family)]
            cost = np.array([found[p][0].cost for p in group])
            for k in range(len(ERRORS) - 1):  # the twist's front would be a third set of runs
                error = np.array([found[p][1][k] for p in group])
                kept += [group[i] for i in pareto(cost, error)]
    quick = [
        p
        for p in kept
        if not found[p][0].failure and found[p][0].cost * found[p][0].simulated < SLOW
    ]
    return list(dict.fromkeys(quick))


def _row(p: Point, run: Run, errors: tuple[float, float, float]) -> tuple[object, ...]:
    return (
        *(p.family, p.name, p.coupling, run.fidelity, run.kernels, _describe(p), run.elements),
        *(p.solver.step_max, p.communication, len(run.costs), run.cost),
        *errors,
        run.failure,
    )


def _describe(p: Point) -> str:
    """The mesh in words."""
    mesh = fitted(p.scene.with_(mesh=p.mesh))
    if mesh.kind == "eem":
        return f"EEM, {mesh.elements}"
    return f"TMN-ETM, l = {mesh.coarse_length:.3g} m, IV of {mesh.counts[2]}, ends halved {mesh.end_levels} times"


#: what ``python -m evidence --measure accuracy`` measures
MEASURES: Measures = {"points": measure, "depth": depth.tables}
