"""A study from its file to its table: sample or search, run what is missing, write the results."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hoist_demo.design.tuning import search
from hoist_demo.study.definition import Sample, Study
from hoist_demo.study.metrics import UNITS
from hoist_demo.study.store import Store

Array = NDArray[np.float64]

_NUMBER = re.compile(r"\d[\d.e+-]*")
"""Warnings that differ in their numbers only are of one kind."""

COST = "cost"
"""Column of a search: the weighted sum that it minimises, over all variants of the point."""

Run = Callable[[Sequence[Sample]], list[str]]
"""Carries out samples and returns their keys; `cluster.run_samples` with its first two arguments given."""


@dataclass(frozen=True)
class Performed:
    """What a study has come to."""

    table: Path  # results.parquet
    runs: int
    causes: Mapping[str, str]  # of the runs that did not complete, by number and key
    warnings: Mapping[str, list[int]]  # numbers of the runs, by the first text of each kind
    best: Mapping[str, float | int | bool | str] | None  # values of a search
    judged: Mapping[str, str] | None  # by what column the best run is chosen, and in which sense


def perform(study: Study, store: Store, run: Run) -> Performed:
    """Run the study's samples, or its search, and write the table."""
    if study.tuning is None:
        samples: list[Sample] = list(study.samples)
        return _write(study, store, samples, run(samples))
    return _write(study, store, *_search(study, store, run))


def write_what_is_there(study: Study, store: Store) -> Path | None:
    """Table of an interrupted study's recorded runs, of a search their folder; None where nothing is recorded."""
    if study.tuning is not None:
        return store.directory if store.holds_runs else None
    pairs = [(s, s.data.key(study.fmu_hash)) for s in study.samples]
    there = [(s, key) for s, key in pairs if store.read(key)]
    return _write(study, store, [s for s, _ in there], [key for _, key in there]).table if there else None


def _search(
    study: Study, store: Store, run: Run
) -> tuple[list[Sample], list[str], Mapping[str, float | int | bool | str], list[float]]:
    """All runs of the search in their order, the best values, and each run's cost, which is that of its point.

    Every point is run for every variant.
    """
    assert study.tuning is not None
    tuning, names = study.tuning, list(study.ranges)
    samples: list[Sample] = []
    keys: list[str] = []
    told: list[float] = []

    def values(x: Array) -> dict[str, float | int | bool | str]:
        return {name: study.ranges[name].at(float(u)) for name, u in zip(names, x, strict=True)}

    def costs(points: Array) -> list[float]:
        asked = [[study.sample(variant, values(x)) for variant in study.variants] for x in points]
        new = [sample for group in asked for sample in group]
        new_keys = run(new)
        samples.extend(new)
        keys.extend(new_keys)
        each = [_cost(store, key, tuning.minimise) for key in new_keys]
        width = len(study.variants)
        found = [sum(each[k : k + width]) for k in range(0, len(each), width)]
        told.extend(cost for cost in found for _ in range(width))
        return found

    best = search(costs, len(names), tuning.generations, tuning.population, tuning.seed)
    return samples, keys, values(best), told


def _cost(store: Store, key: str, weights: Mapping[str, float]) -> float:
    """Weighted sum of a run's metrics; infinite where it failed or did not show one of them."""
    record = store.read(key)
    if record is None or record["outcome"]["status"] != "completed":
        return math.inf
    cost = sum(weight * float(record["outcome"]["metrics"][name]) for name, weight in weights.items())
    return cost if math.isfinite(cost) else math.inf


def _write(
    study: Study,
    store: Store,
    samples: Sequence[Sample],
    keys: Sequence[str],
    best: Mapping[str, float | int | bool | str] | None = None,
    costs: Sequence[float] = (),
) -> Performed:
    rows: list[dict[str, object]] = []
    causes: dict[str, str] = {}
    warnings: dict[str, list[int]] = {}
    for number, (sample, key) in enumerate(zip(samples, keys, strict=True), 1):
        record = store.read(key)
        if record is None:
            raise RuntimeError(f"run {key} has left no record in {store.directory}: start the study again")
        outcome = record["outcome"]
        if outcome["status"] != "completed":
            causes[f"run {number} ({key})"] = outcome["cause"]
        for text in outcome.get("warnings", ()):
            alike = next((first for first in warnings if _NUMBER.sub("", first) == _NUMBER.sub("", text)), text)
            warnings.setdefault(alike, []).append(number)
        chosen = {name: sample.values.get(name) for name in study.units if name != "controller"}
        head = {"run": number, "key": key, "variant": sample.variant, "controller": sample.data.controller}
        result = {"status": outcome["status"], "cause": outcome["cause"], "fidelity": outcome.get("fidelity", "")}
        if costs:
            result[COST] = costs[number - 1] if math.isfinite(costs[number - 1]) else math.nan
        rows.append(head | chosen | result | {name: outcome["metrics"].get(name, math.nan) for name in UNITS})
    table = store.write_table(rows, {**study.units, **UNITS, COST: "1"}, study.title)
    judged = {"metric": COST, "sense": "min"} if costs else study.best
    return Performed(table, len(rows), causes, warnings, best, judged)
