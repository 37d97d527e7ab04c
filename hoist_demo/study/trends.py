"""Sentences on results that do not rise or fall with what varies: what a reader of a few runs would take for granted.

Along one varied number, all else equal: whether the rope struck, the run failed, or a bound was exceeded, where that
comes and goes; and metrics with an extremum inside, which stands out by more than PROMINENCE of their range.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

from hoist_demo.files.catalogue import Catalogue
from hoist_demo.parameters.quantity import Value
from hoist_demo.study.definition import Sample, Study
from hoist_demo.study.metrics import UNITS

PROMINENCE = 0.1
MOST = 12  #: Sentences of a study at most.
_WATCHED = ("slip_safety", "clearance", "loop_turns")  #: Metrics of a study that does not say what matters.

Outcome = Mapping[str, Any]


def not_monotonic(study: Study, samples: Sequence[Sample], outcomes: Sequence[Outcome]) -> list[str]:
    """Return a sentence for each such result."""
    found: dict[str, None] = {}
    lists = {key: v for key, v in study.varied.items() if isinstance(v, tuple)}
    catalogue = Catalogue()
    if study.plan is None and len(lists) == len(study.varied):
        for key in (key for key in lists if not catalogue[key].choices):
            for line in _lines(key, lists, samples, outcomes):
                found |= dict.fromkeys(_along(study, key, line))
    told = list(found)
    return told[:MOST] + ([f"{len(told) - MOST} more results come and go with what varies"] if told[MOST:] else [])


Line = tuple[str, list[tuple[float, Outcome]]]


def _lines(
    key: str, lists: Mapping[str, Sequence[Value]], samples: Sequence[Sample], outcomes: Sequence[Outcome]
) -> Iterator[Line]:
    """Yield the runs along a number, from its smallest value, by all else."""
    lines: dict[str, dict[float, Outcome]] = {}
    for sample, outcome in zip(samples, outcomes, strict=True):
        value = sample.values[key]
        if isinstance(value, int | float) and not isinstance(value, bool):
            others = [f"{name} = {sample.values[name]}" for name in lists if name != key and len(lists[name]) > 1]
            lines.setdefault(", ".join(filter(None, [sample.variant, *others])), {})[value] = outcome
    for rest, line in lines.items():
        if len(line) > 2:
            yield rest, sorted(line.items(), key=lambda pair: pair[0])


def _along(study: Study, key: str, line: Line) -> Iterable[str]:
    rest, runs = line
    where = f" ({rest})" if rest else ""
    for words, happened in _events(study):
        said = [happened(outcome) for _, outcome in runs]
        if any(said) and sum(a != b for a, b in pairwise(said)) > 1 - (said[0] and not said[-1]):
            yield f"{words} at {key} = {_values(runs, said, True)}, not at {_values(runs, said, False)}{where}"
    goal = study.goal
    for metric in goal.metrics if goal else _WATCHED:
        pairs = [(x, float(o["metrics"].get(metric, math.nan))) for x, o in runs if o["status"] == "completed"]
        if turn := _turn([pair for pair in pairs if math.isfinite(pair[1])]):
            x, y, word = turn
            shown = f"{y:.4g}" if UNITS[metric] == "1" else f"{y:.4g} {UNITS[metric]}"
            yield f"{metric} has its {word}, {shown}, at {key} = {x:g}, within what was varied{where}"


def _events(study: Study) -> Iterator[tuple[str, Callable[[Outcome], bool]]]:
    yield "The rope struck or passed through something", lambda outcome: bool(outcome["passed"])
    yield "Runs stopped early", lambda outcome: outcome["status"] != "completed"
    for bound in study.goal.bounds if study.goal else ():
        name = f"{bound.metric} exceeded its bound {bound.value:g}"
        yield name, lambda o, b=bound: b.excess({b.metric: float(o["metrics"].get(b.metric, math.nan))}) > 0.0  # type: ignore[misc]


def _values(runs: Sequence[tuple[float, Outcome]], said: Sequence[bool], wanted: bool) -> str:
    """The values of some runs: 12, 14 to 18."""
    groups: list[list[float]] = []
    for k, ((x, _), one) in enumerate(zip(runs, said, strict=True)):
        if one is wanted and k and said[k - 1] is wanted:
            groups[-1].append(x)
        elif one is wanted:
            groups.append([x])
    return ", ".join(f"{g[0]:g}" if len(g) == 1 else f"{g[0]:g} to {g[-1]:g}" for g in groups)


def _turn(pairs: Sequence[tuple[float, float]]) -> tuple[float, float, str] | None:
    """Return place, value and kind of an extremum inside; None for a result that only rises, or only falls."""
    if len(pairs) < 3:
        return None
    y = [value for _, value in pairs]
    least = PROMINENCE * (max(y) - min(y))
    for word, sign in (("largest value", 1.0), ("smallest value", -1.0)):
        k = max(range(len(y)), key=lambda i: sign * y[i])
        if 0 < k < len(y) - 1 and sign * y[k] - max(sign * y[0], sign * y[-1]) > least > 0.0:
            return pairs[k][0], y[k], word
    return None
