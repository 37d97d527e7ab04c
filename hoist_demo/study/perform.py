"""A study from its file to its table: sample or search, run what is missing, write the results."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hoist_demo.design.tuning import Plan, Score, search
from hoist_demo.parameters.quantity import Value
from hoist_demo.recording.time_series import Array
from hoist_demo.study.definition import Study, StudyRun
from hoist_demo.study.metrics import UNITS
from hoist_demo.study.objective import ChoiceScore, Objective
from hoist_demo.study.sampling import Range
from hoist_demo.study.store import SEPARATOR, Store, kind_of
from hoist_demo.study.trends import not_monotonic

# columns of a study with an objective; those of a choice are the same in all its runs
JUDGED = "judged"  #: Column with the sum by which a choice is judged.
WITHIN = "within"  #: Column with the share of a choice's runs that keep the bounds.
EXCESS = "excess"  #: Column with the largest excess over a bound, as a part of it.
WARNINGS = "warnings"  #: Column with a run's warnings.
MISSING = "missing"  #: Column with the reason why a metric is missing.
MAX_WARNINGS = 3  #: Most warnings in the text on the best choice.
#: Carries out samples and returns their keys; `cluster.run_samples` with its first two arguments
#: given.
RunSamples = Callable[[Sequence[StudyRun]], list[str]]


@dataclass(frozen=True)
class Best:
    """Best choice, or the nearest where none keeps the bounds."""

    runs: tuple[int, ...]  # rows of its runs in the table
    text: str  # a sentence, the worst of its runs and their warnings included
    feasible: bool  # True if it keeps the bounds


@dataclass(frozen=True)
class StudyResult:
    """Outcome of a study: its table and remarks."""

    table: Path  # results.parquet
    runs: int
    causes: Mapping[str, str]  # causes of the runs that did not complete, by number and name
    passages: Mapping[str, str]  # bodies that the rope struck or passed through, by number and name
    # numbers and names of the runs, by the first text of each kind
    warnings: Mapping[str, list[str]]
    remarks: Sequence[str]  # sentences on results that are not monotonic in what varies
    choices: Sequence[int]  # number of each run's choice
    best: Best | None  # None where nothing says what is best, or no run can be compared

    @property
    def summary(self) -> str:
        """Number of runs that wound to the end, and of runs whose rope struck something."""
        count = len(self.passages)
        passed = f", in {count} the rope struck or passed through something" if count else ""
        return f"{self.runs - len(self.causes)} of {self.runs} runs wound to the end{passed}"

    @property
    def exit_code(self) -> int:
        """Exit code of the command: 1 if a run did not wind to the end."""
        return 1 if self.causes else 0


def run_study(study: Study, store: Store, run: RunSamples) -> StudyResult:
    """Run the study's samples, or its search, and write the table."""
    if study.plan is not None:
        return _write(study, store, *_search(study, study.plan, store, run))
    samples: list[StudyRun] = list(study.samples)
    return _write(study, store, samples, run(samples))


def write_what_is_there(study: Study, store: Store) -> Path | None:
    """Write the table of an interrupted study's runs, of a search return its folder.

    None without a run.
    """
    if study.plan is not None:
        return store.directory if any((store.directory / "runs").glob("*.json")) else None
    pairs = [(s, s.data.key(study.fmu_hash)) for s in study.samples]
    there = [(s, key) for s, key in pairs if store.read(key)]
    return (
        _write(study, store, [s for s, _ in there], [key for _, key in there]).table
        if there
        else None
    )


def _search(
    study: Study, plan: Plan, store: Store, run: RunSamples
) -> tuple[list[StudyRun], list[str]]:
    """Search, and return all its runs in their order, with their keys."""
    ranges = {key: r for key, r in study.varied.items() if isinstance(r, Range)}
    assert study.objective is not None
    objective = study.objective

    def samples_of(points: Array) -> list[list[StudyRun]]:
        return [
            study.samples_at(
                {key: r.at(float(u)) for (key, r), u in zip(ranges.items(), x, strict=True)}
            )
            for x in points
        ]

    def judged(points: Array) -> list[Score]:
        each = samples_of(points)
        keys = iter(run([sample for samples in each for sample in samples]))
        return [
            objective.assess([_record(store, next(keys))["outcome"] for _ in samples]).score
            for samples in each
        ]

    samples = [
        sample
        for samples in samples_of(search(judged, len(ranges), plan).points)
        for sample in samples
    ]
    return samples, [sample.data.key(study.fmu_hash) for sample in samples]


def _record(store: Store, key: str) -> dict[str, Any]:
    if (record := store.read(key)) is None:
        raise RuntimeError(
            f"run {key} has left no record in {store.directory}: start the study again"
        )
    return record


def _write(
    study: Study, store: Store, samples: Sequence[StudyRun], keys: Sequence[str]
) -> StudyResult:
    outcomes = [_record(store, key)["outcome"] for key in keys]
    varied = [
        name for name in study.units if len({sample.values.get(name) for sample in samples}) > 1
    ]
    named = [f"run {number}{_named(sample, varied)}" for number, sample in enumerate(samples, 1)]
    numbers: dict[tuple[Value, ...], int] = {}
    choices = [numbers.setdefault(study.choice(sample), len(numbers)) for sample in samples]
    scores = _choice_scores(study.objective, choices, outcomes)
    rows = [
        _row(study, number, sample, key, outcome, scores[choice] if scores else None)
        for number, (sample, key, outcome, choice) in enumerate(
            zip(samples, keys, outcomes, choices, strict=True), 1
        )
    ]
    warnings: dict[str, list[str]] = {}
    for name, outcome in zip(named, outcomes, strict=True):
        for text in outcome["warnings"]:
            alike = next((first for first in warnings if kind_of(first) == kind_of(text)), text)
            warnings.setdefault(alike, []).append(name)
    judged = {JUDGED: study.objective.unit if study.objective else "1", WITHIN: "1", EXCESS: "1"}
    return StudyResult(
        table=store.write_table(rows, {**study.units, **UNITS, **judged}, study.title),
        runs=len(rows),
        causes={
            n: o["cause"]
            for n, o in zip(named, outcomes, strict=True)
            if o["status"] != "completed"
        },
        passages={n: o["passed"] for n, o in zip(named, outcomes, strict=True) if o["passed"]},
        warnings=warnings,
        remarks=not_monotonic(study, samples, outcomes),
        choices=choices,
        best=_best(study, samples, outcomes, choices, scores),
    )


def _choice_scores(
    objective: Objective | None, choices: Sequence[int], outcomes: Sequence[Mapping[str, Any]]
) -> Mapping[int, ChoiceScore]:
    """Return the judgement of each choice."""
    if objective is None:
        return {}
    runs: dict[int, list[Mapping[str, Any]]] = {}
    for choice, outcome in zip(choices, outcomes, strict=True):
        runs.setdefault(choice, []).append(outcome)
    return {choice: objective.assess(own) for choice, own in runs.items()}


def _row(
    study: Study,
    number: int,
    sample: StudyRun,
    key: str,
    outcome: Mapping[str, Any],
    choice_score: ChoiceScore | None,
) -> dict[str, object]:
    head = {
        "run": number,
        "key": key,
        "variant": sample.variant,
        "controller": sample.data.controller,
    }
    row: dict[str, object] = head | {
        name: sample.values.get(name) for name in study.units if name != "controller"
    }
    row |= {name: outcome[name] for name in ("status", "cause", "fidelity")}
    if outcome["passed"]:
        row["status"] = f"{outcome['status']}, but {outcome['passed']}"
    row |= {WARNINGS: SEPARATOR.join(outcome["warnings"]), MISSING: outcome["missing"]}
    if choice_score is not None and study.objective is not None:
        cost = study.objective.sense * choice_score.score.cost
        row |= {JUDGED: cost if math.isfinite(cost) else math.nan, WITHIN: choice_score.within}
        if study.objective.constraints:
            row[EXCESS] = (
                max(choice_score.score.violations) if choice_score.score.finite else math.nan
            )
    return row | {name: outcome["metrics"].get(name, math.nan) for name in UNITS}


def _best(
    study: Study,
    samples: Sequence[StudyRun],
    outcomes: Sequence[Mapping[str, Any]],
    choices: Sequence[int],
    scores: Mapping[int, ChoiceScore],
) -> Best | None:
    """Return the best choice in words, with what its runs warn of."""
    objective = study.objective
    finite = [
        k for k, one in scores.items() if one.score.finite or (one.by_share and one.within > 0.0)
    ]
    if objective is None:
        return None
    if not finite:
        return Best(
            (),
            "no choice can be compared: each has a run that stopped, or misses a metric",
            feasible=False,
        )
    first = min(finite, key=lambda k: scores[k].rank)
    if not scores[first].comparable:
        first = min(finite, key=lambda k: scores[k].score.rank)
    one = scores[first]
    runs = tuple(k for k, choice in enumerate(choices) if choice == first)
    variant, *values = study.choice(samples[runs[0]])
    shown = [str(variant)] if variant else []
    chosen = zip(study.design_keys, values, strict=True)
    shown += [
        f"{key} = {_number(value)} {_unit(study.units[key])}".rstrip() for key, value in chosen
    ]
    what = ", ".join(shown) or f"run {runs[0] + 1}"
    if one.by_share:
        judged = f"{100.0 * one.within:.4g} % of its {len(runs)} runs keep the bounds"
    else:
        word = f", the {objective.judge} of {len(runs)} runs" if len(runs) > 1 else ""
        cost = _number(objective.sense * one.score.cost)
        judged = f"{objective.expression} = {cost} {_unit(objective.unit)}".rstrip() + word
    if not one.comparable:
        exceeded = objective.exceeded(one.score)
        sentence = (
            f"no choice keeps subject_to; nearest is {what}, where {exceeded}: loosen it, or vary "
            "more"
        )
    else:
        equal = sum(scores[k].rank == one.rank for k in finite)
        sentence = f"best is {what}: {judged}" + (
            f", the first of {equal} equal choices" if equal > 1 else ""
        )
    texts = dict.fromkeys(
        text for k in runs for text in (outcomes[k]["passed"], *outcomes[k]["warnings"]) if text
    )
    # a warning of all runs says least about this choice
    common = Counter(kind_of(text) for outcome in outcomes for text in outcome["warnings"])
    warned = sorted(texts, key=lambda text: common[kind_of(text)])
    sentence += "".join(f". Warning: {text}" for text in warned[:MAX_WARNINGS])
    sentence += (
        f". {len(warned) - MAX_WARNINGS} more warnings of its runs"
        if len(warned) > MAX_WARNINGS
        else ""
    )
    return Best(runs, sentence, one.comparable)


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit.replace(".", " ")


def _number(value: Value) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _named(sample: StudyRun, varied: Sequence[str]) -> str:
    """Return the variant and the varied values in brackets; "" if there are none."""
    values = {
        name: sample.values[name]
        for name in varied
        if name in sample.values and name != "controller"
    }
    words = [
        f"{name} = {v:.4g}" if isinstance(v, float) else f"{name} = {v}"
        for name, v in values.items()
    ]
    controller = sample.data.controller if "controller" in varied else ""
    text = ", ".join(filter(None, [sample.variant or controller, *words]))
    return f" ({text})" if text else ""
