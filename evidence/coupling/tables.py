"""The tables of docs/data/coupling: errors, costs, energies and stability of the schemes, from runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from tqdm import tqdm

from evidence.machine import machine
from evidence.tables import Table, Tables, table
from hoist_demo.cases.installed import INSTALLED
from hoist_demo.cases.table import CASES
from hoist_demo.cosimulation.schemes.catalogue import SCHEMES
from hoist_demo.cosimulation.schemes.energy import EnergyControlled
from hoist_demo.cosimulation.schemes.gauss_seidel import ImpulsePreserving
from hoist_demo.cosimulation.schemes.iterative import Iterative
from hoist_demo.parameters import Coupling, Winding

from . import light, oscillator
from .hoist import CONVERGED, Case, errors, wind

#: s, communication steps of the error charts
STEPS = (0.04, 0.02, 0.01, 0.005)
#: s, of the rope in the error charts, the same in all runs, and of the reference's exchange
ROPE_STEP = 0.0025
SHORT = Case("rope-120", Winding(travel=0.5, settle=0.4, start_delay=0.1), "draft", ROPE_STEP)
#: s, of the cases' runs
CASE_STEP, CASE_REFERENCE = 0.01, 0.005
#: m, of the installed cases, whose whole trips take long: from the landing with the heaviest leg, full acceleration
SHORTENED = 60.0
#: W, bounds of the energy control
BOUNDS = (4.0, 1.0, 0.25)
#: N, of iterations where the error is to show and not the tolerance
TIGHT = 1e-9


def oscillators() -> Table:
    """Error of every scheme on two masses."""
    rows = []
    for name, given in tqdm(SCHEMES.items(), desc="oscillator", unit="scheme", leave=False):
        scheme = replace(given, tolerance=TIGHT) if isinstance(given, Iterative) else given
        rows += [(name, H, oscillator.error(scheme, H)) for H in STEPS]
    return table(("scheme", "H [s]", "force error"), rows)


def schemes() -> Table:
    """Error and cost of every scheme on the hoist's first half metre."""
    exact = wind(SHORT, CONVERGED, ROPE_STEP)
    rows = []
    for name in tqdm(SCHEMES, desc="hoist", unit="scheme", leave=False):
        given = SCHEMES[name]
        scheme = replace(given, tolerance=0.01) if isinstance(given, Iterative) else name
        for H in STEPS:
            run = wind(SHORT, scheme, H)
            rms, largest = errors(run, exact)
            steps = run.simulated / H
            cost = run.processor / run.simulated if not run.cause else float("nan")
            rows.append((name, H, rms, largest, run.exchanges / steps, run.power, cost, run.cause))
    names = (
        "scheme",
        "H [s]",
        "force error",
        "largest error",
        "exchanges per step",
        "power [W]",
        "cost [s/s]",
        "cause",
    )
    return table(names, rows)


def cases() -> Table:
    """The default scheme at 10 ms on every case's trip."""
    rows = []
    for name, setup in tqdm(CASES.items(), desc="cases", unit="case", leave=False):
        travel = SHORTENED if name in INSTALLED else setup.winding.travel
        winding = replace(setup.winding, travel=travel, settle=2.0)
        case = Case(name, winding, rope_step=CASE_REFERENCE, sample=CASE_STEP)
        exact = wind(case, CONVERGED, CASE_REFERENCE)
        run = wind(replace(case, rope_step=None), Coupling().scheme, CASE_STEP)
        ratio = setup.hoist.tail_mass * setup.hoist.tail_rope_length / setup.hoist.conveyance_mass
        rows.append(
            (
                name,
                ratio,
                travel,
                Coupling().scheme,
                CASE_STEP,
                *errors(run, exact),
                run.growth,
                run.simulated,
                run.cause or exact.cause,
            )
        )
    names = (
        "case",
        "ropes over conveyance",
        "travel [m]",
        "scheme",
        "H [s]",
        "force error",
        "largest error",
        "predicted growth",
        "simulated [s]",
        "cause",
    )
    return table(names, rows)


def energies() -> Table:
    """The energy control at several bounds, around the impulse-preserving scheme, which makes up most."""
    exact = wind(SHORT, CONVERGED, ROPE_STEP)
    rows = []
    for bound in BOUNDS:
        run = wind(SHORT, EnergyControlled(ImpulsePreserving(), bound, order=1), 0.02)
        rows.append((bound, run.power, run.exchanges, run.taken_back, run.simulated, errors(run, exact)[0], run.cause))
    names = ("bound [W]", "power [W]", "exchanges", "extra exchanges", "simulated [s]", "force error", "cause")
    return table(names, rows)


def stability() -> Table:
    """The map of stability."""
    rows = [(p.scheme, p.mass, p.H, float(p.stable), p.growth, p.added_mass) for p in light.points()]
    return table(("scheme", "mass [kg]", "H [s]", "stable", "predicted growth", "added mass [kg]"), rows)


TABLES: dict[str, Callable[[], Table]] = {
    "oscillator": oscillators,
    "schemes": schemes,
    "energy": energies,
    "stability": stability,
    "cases": cases,
    "machine": machine,
}


def measure(only: str | None = None) -> Tables:
    """All tables, or one."""
    return {name: measure() for name, measure in TABLES.items() if only in (None, name)}
