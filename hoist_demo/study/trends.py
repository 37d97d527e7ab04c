"""Sentences on results that neither only rise nor only fall with a varied number.

A reader of a few runs would take a monotonic result for granted.

Along one varied number, all else equal: whether the rope struck, the run failed, or a bound was
exceeded, where that comes and goes; and metrics with an extremum inside, which stands out.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from functools import partial
from itertools import pairwise
from typing import Any

from hoist_demo.files.registry import parameters
from hoist_demo.parameters.quantity import Value
from hoist_demo.run.metrics import UNITS
from hoist_demo.study.definition import Study, StudyRun
from hoist_demo.study.objective import Constraint, Objective

PROMINENCE = 0.1  #: Least height of an extremum, in parts of the range of a result.
NOISE = 0.01  #: Least height of an extremum, in parts of the largest size of a result.
#: Metrics of a study that does not say what matters.
_WATCHED = ("slip_safety", "clearance", "loop_turns")
OutcomeRecord = Mapping[str, Any]


def not_monotonic(
    study: Study, samples: Sequence[StudyRun], outcomes: Sequence[OutcomeRecord]
) -> list[str]:
    """Return a sentence, with the first place, for each result that is not monotonic."""
    sentences: dict[tuple[str, str], list[str]] = {}
    lists = {key: v for key, v in study.varied.items() if isinstance(v, tuple)}
    if study.plan is None and len(lists) == len(study.varied):
        for key in (key for key in lists if not parameters()[key].choices):
            for rest, runs in _lines(key, lists, samples, outcomes):
                for what, sentence in _along(study.objective, key, runs):
                    whole = f"{sentence} ({rest})" if rest else sentence
                    sentences.setdefault((key, what), []).append(whole)
    return [_first_and_number(alike) for alike in sentences.values()]


def _first_and_number(sentences: Sequence[str]) -> str:
    first, *more = sentences
    if more:
        return f"{first}, and so in {len(more)} more rows"
    return first


RunLine = Sequence[tuple[float, OutcomeRecord]]


def _lines(
    key: str,
    lists: Mapping[str, Sequence[Value]],
    samples: Sequence[StudyRun],
    outcomes: Sequence[OutcomeRecord],
) -> Iterator[tuple[str, RunLine]]:
    """Yield the runs along a number, from its smallest value, behind all else that was varied."""
    lines: dict[str, dict[float, OutcomeRecord]] = {}
    for sample, outcome in zip(samples, outcomes, strict=True):
        value = sample.values[key]
        if isinstance(value, int | float) and not isinstance(value, bool):
            others = [
                f"{name} = {sample.values[name]}"
                for name in lists
                if name != key and len(lists[name]) > 1
            ]
            rest = ", ".join(filter(None, [sample.variant, *others]))
            lines.setdefault(rest, {})[value] = outcome
    for rest, line in lines.items():
        if len(line) > 2:
            yield rest, sorted(line.items(), key=lambda pair: pair[0])


def _along(objective: Objective | None, key: str, runs: RunLine) -> Iterator[tuple[str, str]]:
    """Yield each result that is not monotonic, and the words on it."""
    counted = {"completed"}
    metrics: Iterable[str] = _WATCHED
    if objective:
        counted = objective.counted
        metrics = objective.metrics
    for what, happened in _events(objective, counted):
        happens = [happened(outcome) for _, outcome in runs]
        # an event at the lower end only counts, too: more is expected to be worse
        changes = sum(before != after for before, after in pairwise(happens))
        expected = 0 if happens[0] and not happens[-1] else 1
        if any(happens) and changes > expected:
            yield (
                what,
                f"{what} at {key} = {_values(runs, happens, True)}, not at "
                f"{_values(runs, happens, False)}",
            )
    for metric in metrics:
        pairs: list[tuple[float, float]] = []
        for x, outcome in runs:
            value = _metric(outcome, metric)
            if outcome["status"] in counted and math.isfinite(value):
                pairs.append((x, value))
        turn = _turn(pairs)
        if turn is not None:
            x, y, word = turn
            if UNITS[metric] == "1":
                shown = f"{y:.4g}"
            else:
                shown = f"{y:.4g} {UNITS[metric]}"
            yield (
                metric + word,
                f"{metric} has its {word}, {shown}, at {key} = {x:g}, inside its range",
            )


def _metric(outcome: OutcomeRecord, name: str) -> float:
    return float(outcome["metrics"].get(name, math.nan))


def _events(
    objective: Objective | None, counted: Set[str]
) -> Iterator[tuple[str, Callable[[OutcomeRecord], bool]]]:
    yield "The rope struck or passed through something", lambda outcome: bool(outcome["passed"])
    yield "Runs stopped early", lambda outcome: outcome["status"] not in counted
    if objective is None:
        return
    for bound in objective.constraints:
        word = "above" if bound.sense > 0.0 else "below"
        yield f"{bound.metric} is {word} {bound.value:g}", partial(_is_beyond, bound)


def _is_beyond(bound: Constraint, outcome: OutcomeRecord) -> bool:
    return bound.violation({bound.metric: _metric(outcome, bound.metric)}) > 0.0


def _values(
    runs: Sequence[tuple[float, OutcomeRecord]], happens: Sequence[bool], wanted: bool
) -> str:
    """List the values of some runs: 12, 14 to 18."""
    groups: list[list[float]] = []
    for k, ((x, _), one) in enumerate(zip(runs, happens, strict=True)):
        if one is wanted and k and happens[k - 1] is wanted:
            groups[-1].append(x)
        elif one is wanted:
            groups.append([x])
    texts = []
    for group in groups:
        text = f"{group[0]:g}"
        texts.append(text if len(group) == 1 else f"{text} to {group[-1]:g}")
    return ", ".join(texts)


def _turn(pairs: Sequence[tuple[float, float]]) -> tuple[float, float, str] | None:
    """Return place, value and kind of an extremum inside.

    None for a result that only rises, or only falls.
    """
    if len(pairs) < 3:
        return None
    y = [value for _, value in pairs]
    prominence = max(PROMINENCE * (max(y) - min(y)), NOISE * max(map(abs, y)))
    for word, sign in (("largest value", 1.0), ("smallest value", -1.0)):
        k = max(range(len(y)), key=lambda i: sign * y[i])
        if 0 < k < len(y) - 1 and sign * y[k] - max(sign * y[0], sign * y[-1]) > prominence > 0.0:
            return pairs[k][0], y[k], word
    return None
