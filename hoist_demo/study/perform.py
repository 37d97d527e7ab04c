"""A study from its file to its table: sample or search, run what is missing, write the results."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from hoist_demo.design.tuning import Plan, Score, search
from hoist_demo.parameters.quantity import Value
from hoist_demo.recording.time_series import Array
from hoist_demo.run.metrics import UNITS
from hoist_demo.study.definition import Study, StudyRun
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
#: Carries out samples and returns their keys; ``cluster.run_samples`` with its first two arguments
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
        text = f"{self.runs - len(self.causes)} of {self.runs} runs wound to the end"
        if self.passages:
            text += f", in {len(self.passages)} the rope struck or passed through something"
        return text

    @property
    def exit_code(self) -> int:
        """Exit code of the command: 1 if a run did not wind to the end."""
        if self.causes:
            return 1
        return 0


def run_study(study: Study, store: Store, run: RunSamples) -> StudyResult:
    """Run the study's samples, or its search, and write the table."""
    if study.plan is not None:
        return _write(study, store, _search(study, study.plan, store, run))
    run(study.samples)
    return _write(study, store, study.samples)


def write_partial_results(study: Study, store: Store) -> Path | None:
    """Write the table of an interrupted study's runs, of a search return its folder.

    None without a run.
    """
    if study.plan is not None:
        if any((store.directory / "runs").glob("*.json")):
            return store.directory
        return None
    finished = [one for one in study.samples if store.read(one.data.key(study.fmu_hash))]
    if not finished:
        return None
    return _write(study, store, finished).table


def _search(study: Study, plan: Plan, store: Store, run: RunSamples) -> list[StudyRun]:
    """Search, and return all its runs in their order."""
    ranges = {key: r for key, r in study.varied.items() if isinstance(r, Range)}
    assert study.objective is not None
    objective = study.objective

    def samples_at(point: Array) -> list[StudyRun]:
        values: dict[str, Value] = {}
        for (key, interval), share in zip(ranges.items(), point, strict=True):
            values[key] = interval.at(float(share))
        return study.samples_at(values)

    def scores(points: Array) -> list[Score]:
        samples_by_point = [samples_at(point) for point in points]
        keys = iter(run([*chain.from_iterable(samples_by_point)]))
        scores = []
        for samples in samples_by_point:
            outcomes = [_outcome(store, next(keys)) for _ in samples]
            scores.append(objective.assess(outcomes).score)
        return scores

    samples: list[StudyRun] = []
    for point in search(scores, len(ranges), plan).points:
        samples += samples_at(point)
    return samples


def _outcome(store: Store, key: str) -> dict[str, Any]:
    record = store.read(key)
    if record is None:
        raise RuntimeError(
            f"run {key} has left no record in {store.directory}: start the study again"
        )
    outcome: dict[str, Any] = record["outcome"]
    return outcome


def _write(study: Study, store: Store, samples: Sequence[StudyRun]) -> StudyResult:
    """Write the table of runs that the store has, and return what is to be said of them."""
    keys = [sample.data.key(study.fmu_hash) for sample in samples]
    outcomes = [_outcome(store, key) for key in keys]
    varied = [name for name in study.units if _differs(name, samples)]
    numbers: dict[tuple[Value, ...], int] = {}
    choices = [numbers.setdefault(study.choice(sample), len(numbers)) for sample in samples]
    scores = _choice_scores(study.objective, choices, outcomes)
    rows: list[dict[str, object]] = []
    causes: dict[str, str] = {}
    passages: dict[str, str] = {}
    warnings: dict[str, list[str]] = {}
    runs = zip(samples, keys, outcomes, choices, strict=True)
    for number, (sample, key, outcome, choice) in enumerate(runs, 1):
        head: dict[str, object] = {"run": number, "key": key}
        rows.append(head | _row(study, sample, outcome, scores.get(choice)))
        name = f"run {number}{_values_in_brackets(sample, varied)}"
        if outcome["status"] != "completed":
            causes[name] = outcome["cause"]
        if outcome["passed"]:
            passages[name] = outcome["passed"]
        for text in outcome["warnings"]:
            _add_warning(warnings, text, name)
    units = {**study.units, **UNITS, JUDGED: "1", WITHIN: "1", EXCESS: "1"}
    if study.objective:
        units[JUDGED] = study.objective.unit
    return StudyResult(
        table=store.write_table(rows, units, study.title),
        runs=len(rows),
        causes=causes,
        passages=passages,
        warnings=warnings,
        remarks=not_monotonic(study, samples, outcomes),
        choices=choices,
        best=_best(study, samples, outcomes, choices, scores),
    )


def _add_warning(warnings: dict[str, list[str]], text: str, run: str) -> None:
    """Add a run to those with a warning of this kind, which stand under the first text of it."""
    kind = kind_of(text)
    first = next((first for first in warnings if kind_of(first) == kind), text)
    warnings.setdefault(first, []).append(run)


def _differs(name: str, samples: Sequence[StudyRun]) -> bool:
    """Return True if a value differs between runs."""
    return len({sample.values.get(name) for sample in samples}) > 1


def _choice_scores(
    objective: Objective | None, choices: Sequence[int], outcomes: Sequence[Mapping[str, Any]]
) -> Mapping[int, ChoiceScore]:
    """Return the judgement of each choice."""
    if objective is None:
        return {}
    runs: dict[int, list[Mapping[str, Any]]] = {}
    for choice, outcome in zip(choices, outcomes, strict=True):
        runs.setdefault(choice, []).append(outcome)
    return {choice: objective.assess(of_choice) for choice, of_choice in runs.items()}


def _row(
    study: Study,
    sample: StudyRun,
    outcome: Mapping[str, Any],
    choice_score: ChoiceScore | None,
) -> dict[str, object]:
    """Return the columns of a run behind its number and key."""
    row: dict[str, object] = {"variant": sample.variant, "controller": sample.data.controller}
    for name in study.units:
        if name != "controller":
            row[name] = sample.values.get(name)
    for name in ("status", "cause", "fidelity"):
        row[name] = outcome[name]
    if outcome["passed"]:
        row["status"] = f"{outcome['status']}, but {outcome['passed']}"
    row[WARNINGS] = SEPARATOR.join(outcome["warnings"])
    row[MISSING] = outcome["missing"]
    if choice_score is not None and study.objective is not None:
        score = choice_score.score
        cost = study.objective.sense * score.cost
        row[JUDGED] = cost if math.isfinite(cost) else math.nan
        row[WITHIN] = choice_score.within
        if study.objective.constraints:
            row[EXCESS] = max(score.violations) if score.finite else math.nan
    for name in UNITS:
        row[name] = outcome["metrics"].get(name, math.nan)
    return row


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
    choice_text = _choice_text(study, samples[runs[0]]) or f"run {runs[0] + 1}"
    if one.comparable:
        sentence = f"best is {choice_text}: {_judgement(objective, one, len(runs))}"
        equal = sum(scores[k].rank == one.rank for k in finite)
        if equal > 1:
            sentence += f", the first of {equal} equal choices"
    else:
        exceeded = objective.exceeded(one.score)
        sentence = (
            f"no choice keeps subject_to; nearest is {choice_text}, where {exceeded}: loosen it, "
            "or vary more"
        )
    sentence += _warnings_of_choice([outcomes[k] for k in runs], outcomes)
    return Best(runs, sentence, one.comparable)


def _choice_text(study: Study, sample: StudyRun) -> str:
    """Return the values of a run's choice, in words; "" for none."""
    variant, *values = study.choice(sample)
    shown = [str(variant)] if variant else []
    for key, value in zip(study.design_keys, values, strict=True):
        shown.append(f"{key} = {_number(value)} {_unit(study.units[key])}".rstrip())
    return ", ".join(shown)


def _judgement(objective: Objective, choice_score: ChoiceScore, runs: int) -> str:
    """Return by what a choice of so many runs is the best, in words."""
    if choice_score.by_share:
        return f"{100.0 * choice_score.within:.4g} % of its {runs} runs keep the bounds"
    cost = _number(objective.sense * choice_score.score.cost)
    text = f"{objective.expression} = {cost} {_unit(objective.unit)}".rstrip()
    if runs > 1:
        return f"{text}, the {objective.judge} of {runs} runs"
    return text


def _warnings_of_choice(
    of_choice: Sequence[Mapping[str, Any]], outcomes: Sequence[Mapping[str, Any]]
) -> str:
    """Return the first warnings of a choice's runs as sentences, the rarest first."""
    texts: dict[str, None] = {}
    for outcome in of_choice:
        texts |= dict.fromkeys(filter(None, (outcome["passed"], *outcome["warnings"])))
    # a warning of all runs says least about this choice
    frequency = Counter[str]()
    for outcome in outcomes:
        frequency.update(map(kind_of, outcome["warnings"]))
    warnings = sorted(texts, key=lambda text: frequency[kind_of(text)])
    sentences = "".join(f". Warning: {text}" for text in warnings[:MAX_WARNINGS])
    if len(warnings) > MAX_WARNINGS:
        sentences += f". {len(warnings) - MAX_WARNINGS} more warnings of its runs"
    return sentences


def _unit(unit: str) -> str:
    if unit == "1":
        return ""
    return unit.replace(".", " ")


def _number(value: Value) -> str:
    if isinstance(value, float):
        return f"{value:.5g}"
    return str(value)


def _values_in_brackets(sample: StudyRun, varied: Sequence[str]) -> str:
    """Return the variant and the varied values in brackets; "" if there are none."""
    words = []
    if sample.variant:
        words.append(sample.variant)
    elif "controller" in varied:
        words.append(sample.data.controller)
    for name in varied:
        if name in sample.values and name != "controller":
            value = sample.values[name]
            text = f"{value:.4g}" if isinstance(value, float) else str(value)
            words.append(f"{name} = {text}")
    if words:
        return f" ({', '.join(words)})"
    return ""
