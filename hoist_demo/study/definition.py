"""A study file (TOML), read and checked as a whole before anything runs.

    [study]     title, fmu, hoist, signals; minimise or maximise = a metric, or { metric = weight };
                subject_to = { metric = { below, above } }; judge and over say how choices are compared
    [fixed]     values of all runs
    [[variant]] name and values of one variant; the runs of [vary] are made for every variant
    [sample]    method = "grid" (the default); "latin-hypercube" with runs and seed; "tune" with points, searches, steps
                and seed
    [vary]      lists, or ranges { low, high } to draw from; a search keeps every bound for all values of a list

A value is that of a hoist's file. A list is [...] or { values, unit }; a range may have scale = "log". Later ones
count: the hoist, fixed, variant, vary; in fixed and variant from = "FILE" takes a rope's parameter file first.
"""

from __future__ import annotations

import difflib
import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, PlainValidator, WithJsonSchema, create_model, model_validator

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.drive_signals import DRIVE_UNITS
from hoist_demo.cosimulation.participants.fmu_description import read_outputs
from hoist_demo.design.tuning import Plan
from hoist_demo.files.catalogue import Catalogue, of_run
from hoist_demo.files.fixed import Head, cure, fixed_model, fixed_values, plain, statuses
from hoist_demo.files.reading import FileError, Table, contents, flat, nested, read_toml, table_of, validated
from hoist_demo.files.values import VARIED, Given, Text
from hoist_demo.parameters.quantity import Parameter, Value
from hoist_demo.recording.time_series import match_signals
from hoist_demo.study.goal import Goal, Judge, bounds_on, read_weights
from hoist_demo.study.metrics import UNITS
from hoist_demo.study.run import Probe, RunData, build_trip
from hoist_demo.study.tuning import Range, grid, latin_hypercube, varied
from rope_model.texts import printable

#: what a study without variants compares its choices over
LOADS = ("hoist.payload_left", "hoist.payload_right")
Count = Annotated[int, Field(ge=1, strict=True)]
Varied = tuple[Value, ...] | Range
Weights = Annotated[Any, PlainValidator(read_weights), WithJsonSchema({"type": ["string", "object"]})]


class Grid(Table):
    """All combinations of lists."""

    method: Literal["grid"] = "grid"


class LatinHypercube(Table):
    """So many points of the ranges."""

    method: Literal["latin-hypercube"]
    runs: Count
    seed: int = Field(default=0, ge=0, strict=True)


class Tune(Table):
    """A search of the ranges for the best point: sizes left out follow from their number."""

    method: Literal["tune"]
    points: Count | None = None
    searches: Count = 2
    steps: Count | None = None
    seed: int = Field(default=0, ge=0, strict=True)

    def plan(self, dimensions: int) -> Plan:
        """Return the extent of the search; ValueError where it is too small."""
        plan = Plan(self.points or 4 * dimensions, self.searches, self.steps or 8 * dimensions, self.seed)
        if plan.searches > plan.sample:
            raise ValueError(f"searches = {plan.searches} must be at most points = {plan.sample}: each begins at one")
        if plan.steps < (least := 2 * dimensions + 2):
            raise ValueError(f"steps = {plan.steps} must be at least {least}, two per range and two more: give more")
        return plan


_BOUNDS = table_of("subject_to", [Parameter(f"subject_to.{m}", unit, "Real") for m, unit in UNITS.items()], bounds_on)


class _Study(Head):
    fmu: Text = "build/balance_rope.fmu"
    signals: tuple[Text, ...] = ()
    minimise: Weights = None
    maximise: Weights = None
    subject_to: _BOUNDS | None = None  # type: ignore[valid-type]
    judge: Judge = "worst"
    over: list[Text] | None = None

    @model_validator(mode="after")
    def _is_one(self) -> _Study:
        if self.minimise and self.maximise:
            raise ValueError(f"minimise = {self.minimise!r} must stand without maximise: keep one of them")
        if self.judge == "share" and not self.subject_to:
            raise ValueError("judge = 'share' must have bounds: give subject_to")
        if self.subject_to and not (self.minimise or self.maximise or self.judge == "share"):
            raise ValueError("subject_to must have minimise or maximise beside it, or judge = 'share': give one")
        return self

    @property
    def goal(self) -> Goal | None:
        """What is best, where the file says so."""
        if not (self.minimise or self.maximise or self.subject_to):
            return None
        bounds = tuple(bound for _, pair in contents(self.subject_to) for bound in pair)
        return Goal(self.minimise or self.maximise or {}, -1.0 if self.maximise else 1.0, bounds, self.judge)


@cache
def study_model() -> type[Table]:
    """Return the model of a study's file."""
    one_of = Annotated[Grid | LatinHypercube | Tune, Field(discriminator="method")]
    sample = Annotated[one_of, BeforeValidator(lambda t: {"method": "grid", **t} if isinstance(t, dict) else t)]
    values: Any = fixed_model() | None
    variant = create_model("Variant", __base__=Table, name=(Text, ""), values=(values, None))
    vary = create_model("Vary", __base__=Table, **of_run(varied))
    fields: dict[str, Any] = {"study": (_Study, _Study()), "fixed": (values, None), "vary": (vary | None, None)}
    fields |= {"variant": (list[variant], []), "sample": (sample, Grid())}  # type: ignore[valid-type]
    made: type[Table] = create_model("StudyFile", __base__=Table, **fields)
    return made


@dataclass(frozen=True)
class Sample:
    """One run of a study: the variant, what varies, and the complete data."""

    variant: str
    values: Mapping[str, Value]
    data: RunData


@dataclass(frozen=True)
class Study:
    """A checked study."""

    title: str
    fmu: Path
    fmu_hash: str
    hoist: str
    signals: tuple[str, ...]
    units: Mapping[str, str]  # of every key that is set
    given: Mapping[str, str]  # where each of them comes from; varied where it differs between runs
    samples: tuple[Sample, ...]  # all runs; for a search the corners of its ranges
    variants: Mapping[str, Mapping[str, Value]]  # fixed values of each variant
    varied: Mapping[str, Varied]
    chosen: tuple[str, ...]  # of these, what tells one choice from another; the rest is what they are compared over
    goal: Goal | None
    plan: Plan | None  # of a search

    def samples_at(self, values: Mapping[str, Value]) -> list[Sample]:
        """Return the runs of a search at a point: for every variant and all values of the lists."""
        lists = {key: v for key, v in self.varied.items() if isinstance(v, tuple)}
        return [
            Sample(name, run, build_trip(self.hoist, run, self.signals))
            for name, fixed in self.variants.items()
            for drawn in grid(lists)
            for run in [{**fixed, **values, **drawn}]
        ]

    def choice(self, sample: Sample) -> tuple[Value, ...]:
        """Return what is chosen in a run; runs of one choice are judged together."""
        return ("" if self.plan else sample.variant, *(sample.values[key] for key in self.chosen))


#: Passes the drawn values on one by one while they are checked, which takes a while.
Progress = Callable[[list[dict[str, Value]]], Iterable[dict[str, Value]]]


def read_study(path: Path, fmu: Path | None = None, progress: Progress = list) -> Study:
    """Return the study of a file; `fmu` replaces the file's. Raises FileError with all problems."""
    raw = nested(read_toml(path))
    file: Any = validated(path, study_model(), raw, _cure)
    head, problems = file.study, list[str]()
    rope = fmu or Path(head.fmu)

    def tried(where: str, make: Callable[[], Any], otherwise: Any) -> Any:
        try:
            return make()
        except ValueError as error:
            problems.append(f"{where}: {error}")
            return otherwise

    outputs = tried("study.fmu" if fmu is None else "--fmu", lambda: read_outputs(rope), None)
    known = [*DRIVE_UNITS, *(outputs or ())]
    signals = head.signals if outputs is None else tried("study", lambda: match_signals(head.signals, known), ())
    if find_case(head.hoist).ropes:
        problems.append(f"study.hoist = {head.hoist!r} must have one balance rope, at its middle: leave [[rope]]s out")
    given = tried("fixed", lambda: fixed_values(file.fixed), {})
    variants: dict[str, dict[str, Given]] = {} if file.variant else {"": given}
    for k, table in enumerate(file.variant, 1):
        if (name := table.name or str(k)) in variants:
            problems.append(f"variant {k}: name = {name!r} must be given once: name another")
        variants[name] = {**given, **tried(f"variant {k}", partial(fixed_values, table.values), {})}
    found = dict(contents(file.vary))
    vary: dict[str, Varied] = {key: found[key] for key, _ in flat(raw.get("vary", {}))}
    chosen = tried("study", lambda: _chosen(head, file.sample, vary, len(variants)), ())
    plan, points = tried("sample", lambda: _draw(file.sample, vary, head.goal), (None, [{}]))
    probe = None if outputs is None else Probe(rope)
    samples: dict[str, list[Sample]] = {name: [] for name in variants}
    for values in progress(points):
        for name, fixed in variants.items():
            run = {**plain(fixed), **values}
            try:
                sample = Sample(name, run, build_trip(head.hoist, run, tuple(signals)))
                samples[name].append(sample)
                rejected = [] if probe is None else probe.rejection(sample.data)
            except ValueError as error:
                rejected = [str(error)]
            problems += [f"variant {name}: {text}" if name else text for text in rejected]
    if problems:
        raise FileError(path, problems)
    everything = tuple(sample for found in samples.values() for sample in found)
    stated = {key: status for values in variants.values() for key, status in statuses(values).items()}
    differing = {k for k in stated if len({sample.values.get(k) for sample in everything}) > 1}
    return Study(
        title=head.title or printable(path.stem),
        fmu=rope,
        fmu_hash=hashlib.sha256(rope.read_bytes()).hexdigest(),
        hoist=head.hoist,
        signals=tuple(signals),
        units=Catalogue().units({**stated, **vary}),
        given=stated | dict.fromkeys([*differing, *vary], VARIED),
        samples=everything,
        variants={name: plain(values) for name, values in variants.items()},
        varied=vary,
        chosen=chosen,
        goal=head.goal,
        plan=plan,
    )


def _draw(sample: Any, vary: Mapping[str, Varied], goal: Goal | None) -> tuple[Plan | None, list[dict[str, Value]]]:
    """Return the plan of a search, and the samples of [vary]: of a search the corners of its ranges, to be checked."""
    lists = {key: v for key, v in vary.items() if isinstance(v, tuple)}
    ranges = {key: v for key, v in vary.items() if isinstance(v, Range)}
    if sample.method == "grid":
        if ranges:
            raise ValueError(f"{next(iter(ranges))} is a range, a grid needs a list: give {{ values = [...] }}")
        return None, grid(lists)
    if not ranges:
        raise ValueError(f"method = {sample.method!r} must have ranges: give at least one {{ low, high }} in [vary]")
    if sample.method == "tune":
        if goal is None or goal.judge == "share":
            raise ValueError("method = 'tune' must have a cost: give minimise in [study], and no judge = 'share'")
        corners = grid(lists | {key: (r.at(0.0), r.at(1.0)) for key, r in ranges.items()})
        return sample.plan(len(ranges)), corners
    if lists:
        raise ValueError(f"{next(iter(lists))} is a list, {sample.method} needs {{ low, high }}: give a range")
    return None, latin_hypercube(ranges, sample.runs, sample.seed)


def _chosen(head: Any, sample: Any, vary: Mapping[str, Any], variants: int) -> tuple[str, ...]:
    """Return the varied keys that tell choices apart."""
    if sample.method == "tune":
        return tuple(key for key, v in vary.items() if isinstance(v, Range))
    over = head.over
    if over is None:
        over = list(vary) if variants > 1 else [key for key in vary if key in LOADS]
    for key in {*over} - {*vary}:
        raise ValueError(f"over = {key!r} must be varied: name keys of [vary]")
    chosen = tuple(key for key in vary if key not in over)
    if head.goal and sample.method == "latin-hypercube" and over and chosen:
        raise ValueError(
            f"over = {over!r} must be all of [vary], or none: a hypercube meets each choice once, so its best would be "
            "the luckiest. Compare [[variant]]s, take a grid, or write over = [] to compare single runs"
        )
    return chosen


_OLD = {"tune": '[sample] method = "tune", and minimise and subject_to in [study]'}


def _cure(place: str) -> str:
    """Return what may have been meant by an unknown key."""
    table, _, key = place.rpartition(".")
    if table.endswith("subject_to"):
        return f"metrics are {', '.join(difflib.get_close_matches(key, UNITS, n=3) or UNITS)}"
    if place in _OLD:
        return f"write {_OLD[place]}"
    models: dict[str, type[Table]] = {"study": _Study, "sample": Tune, "": study_model()}
    model = models.get(table.partition(".")[0])
    return cure(place) if model is None or key == "case" else f"the keys are {', '.join(model.model_fields)}"
