"""A study from its file to its table: sample or search, run what is missing, write the results."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from hoist_demo.design.tuning import Judged, search
from hoist_demo.parameters.quantity import Value
from hoist_demo.recording.time_series import Array
from hoist_demo.study.definition import Sample, Study
from hoist_demo.study.metrics import UNITS
from hoist_demo.study.store import Store
from hoist_demo.study.tuning import Tuning

_NUMBER = re.compile(r"\d[\d.e+-]*")  #: Warnings that differ in their numbers only are of one kind.

#: Column of a search: the weighted sum that it minimises, over all variants of the point; none where it exceeds a
#: bound.
COST = "cost"
EXCESS = "excess"  #: Column of a search with bounds: the largest excess, as a part of its bound.

WARNINGS = "warnings"  #: Column with what a run has warned of.

#: Carries out samples and returns their keys; `cluster.run_samples` with its first two arguments given.
Run = Callable[[Sequence[Sample]], list[str]]


@dataclass(frozen=True)
class Performed:
    """Outcome of a study."""

    table: Path  # results.parquet
    runs: int
    causes: Mapping[str, str]  # of the runs that did not complete, by number and name
    passages: Mapping[str, str]  # what the rope passed through, likewise
    warnings: Mapping[str, list[str]]  # numbers and names of the runs, by the first text of each kind
    best: Mapping[str, Value] | None  # values of a search; None where no point keeps its bounds
    nearest: str  # what the best point of a search exceeds, where none keeps its bounds
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


@dataclass(frozen=True)
class _Searched:
    """A search's outcome for the table."""

    costs: Sequence[float]  # of each run, that of its point; NaN where a run failed or a bound is exceeded
    excesses: Sequence[float]  # of each run, the largest of its point; none without bounds
    best: Mapping[str, Value] | None
    nearest: str


def _search(study: Study, store: Store, run: Run) -> tuple[list[Sample], list[str], _Searched]:
    """All runs of the search in their order; every point is run for every variant."""
    assert study.tuning is not None
    tuning, names = study.tuning, list(study.ranges)

    def values(x: Array) -> dict[str, Value]:
        return {name: study.ranges[name].at(float(u)) for name, u in zip(names, x, strict=True)}

    def samples_of(points: Array) -> list[Sample]:
        return [study.sample(variant, values(x)) for x in points for variant in study.variants]

    def judged(points: Array) -> list[Judged]:
        width = len(study.variants)
        each = [_judged(store, key, tuning) for key in run(samples_of(points))]
        return [_together(each[k : k + width]) for k in range(0, len(each), width)]

    found = search(judged, len(names), tuning.plan)
    best = found.judged[found.best]
    each = [point for point in found.judged for _ in study.variants]
    samples = samples_of(found.points)
    return (
        samples,
        [sample.data.key(study.fmu_hash) for sample in samples],
        _Searched(
            costs=[point.cost if point.kept else math.nan for point in each],
            excesses=[max(point.excess) if point.finite else math.nan for point in each] if tuning.bounds else [],
            best=values(found.points[found.best]) if best.kept else None,
            nearest="" if best.kept else _told(tuning, best),
        ),
    )


def _judged(store: Store, key: str, tuning: Tuning) -> Judged:
    """Weighted sum and excesses of a run; infinite where it failed or did not show one of the metrics."""
    record = store.read(key)
    failed = Judged(math.inf, (math.inf,) * len(tuning.bounds))
    if record is None or record["outcome"]["status"] != "completed":
        return failed
    metrics = record["outcome"]["metrics"]
    cost = sum(weight * float(metrics[name]) for name, weight in tuning.minimise.items())
    found = Judged(cost, tuple(bound.excess(metrics) for bound in tuning.bounds))
    return found if found.finite else failed


def _together(variants: Sequence[Judged]) -> Judged:
    """A point that is run for several variants: the sum of their costs, and the largest of each excess."""
    excess = tuple(max(found) for found in zip(*(one.excess for one in variants), strict=True))
    return Judged(sum(one.cost for one in variants), excess)


def _told(tuning: Tuning, best: Judged) -> str:
    """Return the bounds that the point exceeds, in words."""
    parts = [
        f"{bound.metric} is {100.0 * excess:.3g} % {'above' if bound.sense > 0.0 else 'below'} {bound.value:g}"
        for bound, excess in zip(tuning.bounds, best.excess, strict=True)
        if excess > 0.0
    ]
    return f"no point keeps subject_to, in the nearest one {', '.join(parts)}: loosen it, or widen the ranges"


def _write(
    study: Study, store: Store, samples: Sequence[Sample], keys: Sequence[str], searched: _Searched | None = None
) -> Performed:
    rows: list[dict[str, object]] = []
    causes: dict[str, str] = {}
    passages: dict[str, str] = {}
    warnings: dict[str, list[str]] = {}
    varied = [name for name in study.units if len({sample.values.get(name) for sample in samples}) > 1]
    for number, (sample, key) in enumerate(zip(samples, keys, strict=True), 1):
        record = store.read(key)
        if record is None:
            raise RuntimeError(f"run {key} has left no record in {store.directory}: start the study again")
        outcome, named = record["outcome"], f"run {number}{_named(sample, varied)}"
        if outcome["status"] != "completed":
            causes[named] = outcome["cause"]
        for text in outcome.get("warnings", ()):
            alike = next((first for first in warnings if _NUMBER.sub("", first) == _NUMBER.sub("", text)), text)
            warnings.setdefault(alike, []).append(named)
        chosen = {name: sample.values.get(name) for name in study.units if name != "controller"}
        head = {"run": number, "key": key, "variant": sample.variant, "controller": sample.data.controller}
        result = {name: outcome[name] for name in ("status", "cause", "fidelity")}
        if passed := outcome.get("passed", ""):
            result["status"] += f", but {passed}"
            passages[named] = passed
        result[WARNINGS] = "; ".join(outcome["warnings"])
        if searched is not None:
            result[COST] = searched.costs[number - 1]
            if searched.excesses:
                result[EXCESS] = searched.excesses[number - 1]
        rows.append(head | chosen | result | {name: outcome["metrics"].get(name, math.nan) for name in UNITS})
    table = store.write_table(rows, {**study.units, **UNITS, COST: "1", EXCESS: "1"}, study.title)
    if searched is None:
        return Performed(table, len(rows), causes, passages, warnings, None, "", study.best)
    judged = {"metric": COST, "sense": "min"}
    return Performed(table, len(rows), causes, passages, warnings, searched.best, searched.nearest, judged)


def _named(sample: Sample, varied: Sequence[str]) -> str:
    """The variant and the varied values in brackets; "" where there are none."""
    values = {name: sample.values[name] for name in varied if name in sample.values and name != "controller"}
    words = [f"{name} = {v:.4g}" if isinstance(v, float) else f"{name} = {v}" for name, v in values.items()]
    words = [sample.variant or sample.data.controller * ("controller" in varied), *words]
    text = ", ".join(word for word in words if word)
    return f" ({text})" if text else ""
