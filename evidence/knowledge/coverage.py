"""Synthetic proof: ropes drawn from the ranges are measured with noise, and looked for again.

Each of SETS ropes has properties drawn evenly from the middle 70 % of their ranges and is measured by PLAN, with normal
errors of its sigma. Counted is how often the true value lies within the interval of 90 % that the fit states, and, to
tell the interval from the luck of the draw, in how many sets the errors that were drawn are such that an exact interval
would hold it: those in which the best linear estimate about the truth, J^+ e, is off by at most 1.645 standard errors.
"""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from tqdm import tqdm

from evidence.tables import Table, table
from hoist_demo.calibration.definition import Measured, read_measured
from hoist_demo.calibration.fit import REACH, Array, Residuals, fit, intervals, sensitivities
from hoist_demo.calibration.identify import OPEN, identify, residuals_of, stacked
from hoist_demo.cosimulation.participants.inprocess_rope import rope_parameters

#: what is measured, with sigma; its values are those of the worked example
PLAN = Path(__file__).resolve().parents[2] / "docs" / "measurements" / "example.toml"
SETS = 100
#: of the sets by which the method was judged while it was made, and of sets that were drawn once it stood
SEED, UNSEEN = 20261122, 7
#: sets of those measurements that have closed forms, which cost nothing
MORE_SETS = 600
#: shares from which the true ropes are drawn
DRAWN = (0.15, 0.85)
#: shares of the rope of the worked example, from which its values were made
TRUE = (0.5, 0.4, 0.6, 0.55, 0.35)
HANGING = ("at rest", "swing")
COUNTED = ("property", "told", "inside", "lucky", "reach")
COLUMNS = ("set", "property", "true", "found", "from", "to", "off")


def draw(sets: int, count: int, seed: int) -> tuple[np.random.Generator, Array]:
    """The generator of the errors, and the shares of the true ropes."""
    rng = np.random.default_rng(seed)
    low, high = DRAWN
    return rng, low + (high - low) * rng.random((sets, count))


def cover(plan: Measured, sets: int = SETS, seed: int = SEED) -> Table:
    """Of each set and property the true share, the one found, its interval, and how far off the errors make it."""
    bench = plan.bench
    _, sigmas = stacked(plan.measurements)
    rng, truths = draw(sets, len(bench.names), seed)
    rows = []
    for k, truth in enumerate(tqdm(truths, desc="synthetic ropes", unit="rope", leave=False), 1):
        errors = rng.standard_normal(sigmas.size)
        values = bench.predict(truth, plan.measurements) + sigmas * errors
        residuals = residuals_of(bench, plan.measurements, values, sigmas)
        found = fit(residuals, truth.size)
        ends, off = intervals(residuals, found), standard_errors_off(residuals, truth, errors)
        rows += [
            (k, *row) for row in zip(bench.names, truth, found.shares, *ends.T, off, strict=True)
        ]  # fmt: skip
    return table(COLUMNS, rows)


def standard_errors_off(residuals: Residuals, truth: Array, errors: Array) -> Array:
    """By how many standard errors the best linear estimate about the truth misses each share."""
    estimate = np.linalg.pinv(sensitivities(residuals, truth))
    return np.asarray(estimate @ errors / np.linalg.norm(estimate, axis=1))


def plan() -> Measured:
    """The plan of the measurements."""
    return read_measured(PLAN, rope_parameters())


def of_samples(measured: Measured) -> Measured:
    """The measurements that need no hanging rope."""
    return replace(measured, measurements=tuple(m for m in measured.measurements if m.what not in HANGING))


def inside(t: Table) -> list[tuple[str, int, int, int, float]]:
    """Per property: sets in which it was told, those whose interval then holds the true value, those in which an exact
    interval would, and the mean half width."""
    rows = []
    for name in dict.fromkeys(t["property"]):
        chosen = t["property"] == name
        true, low, high, off = (t[column][chosen] for column in ("true", "from", "to", "off"))
        reach = 0.5 * (high - low)
        told = reach < OPEN
        hits = int(np.sum((low <= true) & (true <= high) & told))
        lucky = int(np.sum((np.abs(off) <= REACH) & told))
        rows.append((str(name), int(np.sum(told)), hits, lucky, float(np.mean(reach))))
    return rows


def example(measured: Measured) -> dict[str, Table]:
    """What the fit of the example says: properties, and candidates for the next measurement."""
    begun = time.process_time()
    found = identify(measured)
    spent = time.process_time() - begun
    bench = measured.bench
    properties = [
        (
            name,
            bench.known.data[name].unit,
            bench.known.data[name].low,
            bench.known.data[name].high,
            bench.known.data[name].at(true),
            found.value(name),
            found.known.data[name].low,
            found.known.data[name].high,
        )
        for name, true in zip(bench.names, TRUE, strict=True)
    ]
    columns = ("property", "unit", "low", "high", "true", "found", "from", "to")
    candidates = [(c.measurement.name, c.error) for c in found.candidates]
    facts = [("wanted", found.wanted), ("error", found.wanted_error), ("seconds", spent)]
    return {
        "example": table(columns, properties),
        "candidates": table(("measurement", "error"), candidates),
        "facts": table(("fact", "value"), facts),
    }
