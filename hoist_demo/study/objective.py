"""Objective of a study.

It judges a choice by all its runs, against the same disturbances, and by bounds on every run.

A run that failed keeps no bound and has no finite cost; nor does one that the safety circuit cut
short, unless its objective names a metric of stops. Runs are judged by the worst, by the mean, or
by the share that keeps the bounds.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, Literal

from pydantic import PlainValidator, WithJsonSchema

from hoist_demo.design.tuning import Score
from hoist_demo.files.values import read_value
from hoist_demo.parameters.quantity import FileParameter
from hoist_demo.run.metrics import SIGNED, STOPS, UNITS
from hoist_demo.study.outcome import CUT_SHORT
from rope_model.physics.elementary import sum_of

Judge = Literal["worst", "mean", "share"]
_SENSES = {"below": 1.0, "above": -1.0}


@dataclass(frozen=True)
class Constraint:
    """Bound on a metric in every run."""

    metric: str
    value: float
    sense: float  # 1: below the value, -1: above it

    def violation(self, metrics: Mapping[str, float]) -> float:
        """Return the violation of the bound, as a fraction of it unless it is 0.

        0 or less if it is kept.
        """
        scale = abs(self.value) or 1.0
        return self.sense * (size_of(self.metric, metrics) - self.value) / scale


def size_of(metric: str, metrics: Mapping[str, float]) -> float:
    """Return a metric as bounds and objectives count it: an error by its magnitude."""
    value = float(metrics[metric])
    if metric in SIGNED:
        return abs(value)
    return value


def constraints_on(parameter: FileParameter) -> Any:
    """Return the type of a metric in subject_to for pydantic: a tuple of Constraints."""
    return Annotated[
        Any,
        PlainValidator(partial(_read_constraints, parameter)),
        WithJsonSchema({"type": "object"}),
    ]


def _read_constraints(parameter: FileParameter, content: Any) -> tuple[Constraint, ...]:
    name = parameter.name
    words = {*content} if isinstance(content, Mapping) else set()
    if not words & {*_SENSES} or not words <= {*_SENSES, "unit"}:
        raise ValueError(
            f"{name} = {content!r} must have below or above, and may have unit: write "
            "{ below = 0.3 }"
        )
    metric = name.rpartition(".")[2]
    constraints = []
    for word, sense in _SENSES.items():
        if word in content:
            value = read_value(parameter, content[word], content.get("unit"))
            constraints.append(Constraint(metric, float(value), sense))
    return tuple(constraints)


def read_weights(content: Any) -> dict[str, float]:
    """Return the weights of metrics: of a name it is 1.

    A ValueError names metric, value and cure.
    """
    weights = {content: 1.0} if isinstance(content, str) else content
    if not isinstance(weights, Mapping) or not weights:
        raise ValueError(
            f"{content!r} must be a metric, or metrics with weights: write {{ cycle_time = 1.0 }}"
        )
    for name, weight in weights.items():
        if name not in UNITS:
            raise ValueError(f"{name} is not a metric: choose one of {', '.join(UNITS)}")
        is_number = isinstance(weight, int | float) and not isinstance(weight, bool)
        if not is_number or not math.isfinite(weight):
            raise ValueError(f"{name} = {weight!r} must be a finite number: give its weight")
    return {name: float(weight) for name, weight in weights.items()}


@dataclass(frozen=True)
class ChoiceScore:
    """Choice, judged by all its runs."""

    score: Score
    within: float  # share of runs that are complete and keep all bounds
    by_share: bool

    @property
    def rank(self) -> tuple[float, ...]:
        """Key by which choices are sorted, smaller is better."""
        if self.by_share:
            return -self.within, self.score.cost
        return self.score.rank

    @property
    def comparable(self) -> bool:
        """True if the choice can be the best."""
        if self.by_share:
            return self.within > 0.0
        return self.score.feasible


@dataclass(frozen=True)
class Objective:
    """Cost that is to be small, and bounds that every run must keep."""

    weights: Mapping[str, float]  # by metric, in 1 / its unit
    sense: float  # 1: the smallest sum is best, -1: the largest
    constraints: tuple[Constraint, ...] = ()
    judge: Judge = "worst"

    @property
    def counted(self) -> set[str]:
        """Status of runs that count.

        A run that the safety circuit cut short counts if a metric of stops is named.
        """
        if STOPS.isdisjoint(self.metrics):
            return {"completed"}
        return {"completed", CUT_SHORT}

    def of_run(self, outcome: Mapping[str, Any]) -> Score:
        """Return cost and violations of a run's recorded outcome.

        Infinite where it failed or a metric is missing.
        """
        metrics = outcome["metrics"]
        sizes = [weight * size_of(name, metrics) for name, weight in self.weights.items()]
        cost = self.sense * sum_of(sizes)
        score = Score(cost, tuple(bound.violation(metrics) for bound in self.constraints))
        if score.finite and outcome["status"] in self.counted:
            return score
        return Score(math.inf, (math.inf,) * len(self.constraints))

    def assess(self, outcomes: Sequence[Mapping[str, Any]]) -> ChoiceScore:
        """Return the judgement of a choice by its runs."""
        runs = [self.of_run(outcome) for outcome in outcomes]
        feasible = [run for run in runs if run.feasible]
        by_share = self.judge == "share"
        costs = [run.cost for run in (feasible if by_share and feasible else runs)]
        if self.judge == "worst":
            cost = max(costs)
        else:
            cost = sum_of(costs) / len(costs)
        violations_by_bound = zip(*(run.violations for run in runs), strict=True)
        score = Score(cost, tuple(map(max, violations_by_bound)))
        return ChoiceScore(score, within=len(feasible) / len(runs), by_share=by_share)

    @property
    def metrics(self) -> dict[str, None]:
        """Metrics that the objective names, in order."""
        return dict.fromkeys([*self.weights, *(bound.metric for bound in self.constraints)])

    @property
    def expression(self) -> str:
        """Weighted sum of the metrics in words."""
        terms = []
        for name, weight in self.weights.items():
            terms.append(name if weight == 1.0 else f"{weight:g} {name}")
        return " + ".join(terms)

    @property
    def unit(self) -> str:
        """Unit of the sum, "1" for none."""
        units = {UNITS[name] for name, weight in self.weights.items() if weight == 1.0}
        if len(self.weights) == 1 and units:
            return units.pop()
        return "1"

    def exceeded(self, judged: Score) -> str:
        """Return the bounds that are not kept, in words; "" for none."""
        texts = []
        for bound, violation in zip(self.constraints, judged.violations, strict=True):
            if violation > 0.0:
                side = "above" if bound.sense > 0.0 else "below"
                texts.append(f"{bound.metric} is {100.0 * violation:.3g} % {side} {bound.value:g}")
        return ", ".join(texts)
