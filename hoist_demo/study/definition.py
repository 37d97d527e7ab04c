"""A study's file: what varies between runs, and what is best.

Read and checked as a whole before anything runs.

Values count in this order: the hoist's, [fixed], [[variant]], [vary]. The runs of [vary] are made
for every variant.
"""

import hashlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BeforeValidator,
    Field,
    PlainValidator,
    WithJsonSchema,
    WrapValidator,
    model_validator,
)

from hoist_demo.cases.run_values import FileHeader, ParameterValues
from hoist_demo.cases.table import NATIVE_ENDING, find_case, fmu_name
from hoist_demo.cosimulation.drive_signals import DRIVE_UNITS
from hoist_demo.cosimulation.participants.fmu_description import read_outputs
from hoist_demo.design.tuning import Plan
from hoist_demo.files.reading import (
    EMPTY,
    File,
    Flat,
    TomlTable,
    contents,
    errors_of_file,
    flat,
    read,
    table_of,
)
from hoist_demo.files.registry import parameters, run_fields
from hoist_demo.files.values import VARIED, ParameterValue, Text, statuses, values_of
from hoist_demo.parameters.problems import Problems
from hoist_demo.parameters.quantity import FileParameter, Value
from hoist_demo.recording.time_series import match_signals
from hoist_demo.run.data import RunData, build_single_trip
from hoist_demo.run.metrics import ARRIVALS, UNITS
from hoist_demo.run.probe import FmuProbe
from hoist_demo.study.objective import Constraint, Judge, Objective, constraints_on, read_weights
from hoist_demo.study.sampling import Range, grid, latin_hypercube, varied

#: Disturbances over which a study without variants compares its choices.
LOAD_KEYS = ("hoist.payload_left", "hoist.payload_right")
#: Points and steps of a search where its file states none, for each of its ranges.
POINTS_PER_RANGE = 4
STEPS_PER_RANGE = 8
Count = Annotated[int, Field(ge=1, strict=True)]
Seed = Annotated[int, Field(ge=0, strict=True)]
Varied = tuple[Value, ...] | Range
Weights = Annotated[
    Any, PlainValidator(read_weights), WithJsonSchema({"type": ["string", "object"]})
]


class Grid(TomlTable):
    """Sample of all combinations of lists."""

    method: Literal["grid"] = "grid"


class LatinHypercube(TomlTable):
    """Sample of so many points of the ranges."""

    method: Literal["latin-hypercube"]
    runs: Count
    seed: Seed = 0


class Tune(TomlTable):
    """Search of the ranges for the best point: sizes left out follow from their number."""

    method: Literal["tune"]
    points: Count | None = None
    searches: Count = 2
    steps: Count | None = None
    seed: Seed = 0

    def plan(self, dimensions: int) -> Plan:
        """Return the extent of the search; ValueError where it is too small."""
        plan = Plan(
            sample=self.points or POINTS_PER_RANGE * dimensions,
            searches=self.searches,
            steps=self.steps or STEPS_PER_RANGE * dimensions,
            seed=self.seed,
        )
        if plan.searches > plan.sample:
            raise ValueError(
                f"searches = {plan.searches} must be at most points = {plan.sample}: each begins "
                "at one"
            )
        min_steps = 2 * dimensions + 2
        if plan.steps < min_steps:
            raise ValueError(
                f"steps = {plan.steps} must be at least {min_steps}, two per range and two more: "
                "give "
                "more"
            )
        return plan


_METRICS = table_of(
    "subject_to",
    [FileParameter(f"subject_to.{metric}", unit, "Real") for metric, unit in UNITS.items()],
    constraints_on,
)


def _constraints(table: TomlTable) -> tuple[Constraint, ...]:
    """Return the bounds of [study.subject_to]; a metric may have two."""
    bounds: list[Constraint] = []
    for _, of_metric in contents(table):
        bounds += of_metric
    return tuple(bounds)


class StudyHeader(FileHeader):
    """Table [study] at the head of a study's file."""

    fmu: Text = Field("", description="the rope; else what export makes of the hoist")
    signals: tuple[Text, ...] = ()
    minimise: Weights = None
    maximise: Weights = None
    constraints: Annotated[tuple[Constraint, ...], Flat(_METRICS, _constraints)] = Field(
        (), alias="subject_to"
    )
    judge: Judge = "worst"
    over: list[Text] | None = None

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if self.minimise and self.maximise:
            raise ValueError(
                f"minimise = {self.minimise!r} must stand without maximise: keep one of them"
            )
        if self.judge == "share" and not self.constraints:
            raise ValueError("judge = 'share' must have bounds: give subject_to")
        if self.constraints and not (self.minimise or self.maximise or self.judge == "share"):
            raise ValueError(
                "subject_to must have minimise or maximise beside it, or judge = 'share': give one"
            )
        return self

    @property
    def objective(self) -> Objective | None:
        """Objective of the study; None if the file states none."""
        if not (self.minimise or self.maximise or self.constraints):
            return None
        weights = self.minimise or self.maximise or {}
        sense = -1.0 if self.maximise else 1.0
        return Objective(weights, sense, self.constraints, self.judge)


class Variant(TomlTable):
    """Table [[variant]]: values that are fixed in its runs."""

    name: Text = ""
    values: ParameterValues = EMPTY


def _in_order(content: Any, handler: Callable[[Any], dict[str, Any]]) -> dict[str, Any]:
    """Return what is varied in the order of the file."""
    values = handler(content)

    def keys(table: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
        for name, inner in table.items():
            key = f"{prefix}{name}"
            if key in values:
                yield key
            else:
                yield from keys(inner, f"{key}.")

    return {key: values[key] for key in keys(content)}


_VARY = flat("Vary", run_fields(varied))


def _with_method(table: object) -> object:
    """Return [sample] with its method: a grid where it states none."""
    if isinstance(table, dict):
        return {"method": "grid", **table}
    return table


class StudyFile(File):
    """Schema of a study's TOML file."""

    study: StudyHeader = EMPTY
    fixed: ParameterValues = EMPTY
    variant: list[Variant] = Field([])
    vary: Annotated[dict[str, Varied], WrapValidator(_in_order), _VARY] = Field({})
    sample: Annotated[
        Annotated[Grid | LatinHypercube | Tune, Field(discriminator="method")],
        BeforeValidator(_with_method),
    ] = Grid()

    @model_validator(mode="after")
    def _is_given_once(self) -> Self:
        places = {"[fixed]": self.fixed}
        for k, variant in enumerate(self.variant, 1):
            places[f"variant {variant.name or k}"] = variant.values
        problems = Problems()
        for place, values in places.items():
            for name, entry in values.items():
                if name in self.vary:
                    problems.append(
                        f"{place} {name} = {entry.value!r} is also in [vary], whose values would "
                        "replace it: leave one of them out"
                    )
        problems.refuse()
        return self

    @property
    def variants(self) -> dict[str, dict[str, ParameterValue]]:
        """Fixed values of each variant, by its name."""
        variants = {
            one.name or str(k): {**self.fixed, **one.values}
            for k, one in enumerate(self.variant, 1)
        }
        if len(variants) < len(self.variant):
            raise ValueError(f"names {', '.join(variants)} must be given once each: name others")
        return variants or {"": self.fixed}

    def drawn(self) -> tuple[Plan | None, list[dict[str, Value]]]:
        """Return the plan of a search, if it is one, and the points of [vary].

        The points of a search are the corners of its ranges.
        """
        lists = {key: v for key, v in self.vary.items() if isinstance(v, tuple)}
        ranges = {key: v for key, v in self.vary.items() if isinstance(v, Range)}
        sample = self.sample
        objective = self.study.objective
        if isinstance(sample, Grid):
            if ranges:
                raise ValueError(
                    f"{next(iter(ranges))} is a range, a grid needs a list: give "
                    "{ values = [...] }"
                )
            return None, grid(lists)
        if not ranges:
            raise ValueError(
                f"method = {sample.method!r} needs ranges: give at least one {{ low, high }} in "
                "[vary]"
            )
        if isinstance(sample, LatinHypercube):
            if lists:
                raise ValueError(
                    f"{next(iter(lists))} is a list, {sample.method} needs {{ low, high }}: give a "
                    "range"
                )
            return None, latin_hypercube(ranges, sample.runs, sample.seed)
        if objective is None or objective.judge == "share":
            raise ValueError(
                "method = 'tune' must have a cost: give minimise in [study], and no judge = 'share'"
            )
        ends = {key: (interval.at(0.0), interval.at(1.0)) for key, interval in ranges.items()}
        return sample.plan(len(ranges)), grid({**lists, **ends})

    def design_keys(self) -> tuple[str, ...]:
        """Return the varied keys that tell one choice from another.

        The rest is what they are compared over.
        """
        if self.sample.method == "tune":
            return tuple(key for key, v in self.vary.items() if isinstance(v, Range))
        over = self.study.over
        if over is None and len(self.variant) > 1:
            over = list(self.vary)
        elif over is None:
            over = [key for key in self.vary if key in LOAD_KEYS]
        for key in {*over} - {*self.vary}:
            raise ValueError(f"over = {key!r} must be varied: name keys of [vary]")
        design_keys = tuple(key for key in self.vary if key not in over)
        once = self.sample.method == "latin-hypercube"
        if self.study.objective and once and over and design_keys:
            raise ValueError(
                f"over = {over!r} must be all of [vary], or none: a hypercube meets each choice "
                "once, so its best would be the luckiest. Compare [[variant]]s, take a grid, or "
                "write over = [] to compare single runs"
            )
        return design_keys


@dataclass(frozen=True)
class StudyRun:
    """Run of a study: the variant, what varies, and the complete data."""

    variant: str
    values: Mapping[str, Value]
    data: RunData


@dataclass(frozen=True)
class Study:
    """Study that has been read and checked."""

    title: str
    hoist: str
    fmu: Path
    fmu_hash: str
    objective: Objective | None
    signals: tuple[str, ...]
    variants: Mapping[str, Mapping[str, ParameterValue]]  # fixed values of each variant
    varied: Mapping[str, Varied]
    design_keys: tuple[str, ...]  # varied keys that distinguish choices
    plan: Plan | None  # None without a search
    samples: tuple[StudyRun, ...] = ()  # all runs; for a search the corners of its ranges

    @property
    def status_by_name(self) -> dict[str, str]:
        """Status of each value that is set; varied if it differs between runs."""
        status_by_key: dict[str, str] = {}
        for values in self.variants.values():
            status_by_key |= statuses(values)
        for key in status_by_key:
            if len({sample.values.get(key) for sample in self.samples}) > 1:
                status_by_key[key] = VARIED
        return status_by_key | dict.fromkeys(self.varied, VARIED)

    @property
    def units(self) -> dict[str, str]:
        """Unit of every key that is set."""
        return {name: parameters()[name].unit for name in self.status_by_name}

    def run(self, variant: str, values: Mapping[str, Value]) -> StudyRun:
        """Return the run of a variant at a point of [vary]."""
        fixed = self.variants[variant]
        chosen = {key: value for key, value in values.items() if key in self.design_keys}
        disturbances = {key: value for key, value in values.items() if key not in chosen}
        run = build_single_trip(self.hoist, {**fixed, **chosen}, self.signals, varied=disturbances)
        metrics = self.objective.metrics if self.objective else {}
        of_arrival = [name for name in ARRIVALS if name in metrics]
        stopped_at = run.winding.emergency_at
        if stopped_at is not None and of_arrival:
            raise ValueError(
                f"{of_arrival[0]} must be left out, for winding.emergency_at = {stopped_at:g} s: "
                "judge stop_distance"
            )
        return StudyRun(variant, {**values_of(fixed), **values}, run)

    def samples_at(self, values: Mapping[str, Value]) -> list[StudyRun]:
        """Return the runs of a search at a point: for every variant and all values of the lists."""
        lists = {key: v for key, v in self.varied.items() if isinstance(v, tuple)}
        samples = []
        for variant in self.variants:
            samples += [self.run(variant, {**values, **of_lists}) for of_lists in grid(lists)]
        return samples

    def choice(self, sample: StudyRun) -> tuple[Value, ...]:
        """Return what is chosen in a run; runs of one choice are judged together."""
        variant = "" if self.plan else sample.variant
        return (variant, *(sample.values[key] for key in self.design_keys))


def _require_one_rope(hoist: str) -> None:
    """Refuse a hoist whose ropes one FMU cannot be."""
    if ropes := find_case(hoist).distinct_ropes:
        names = ", ".join(rope.name for rope in ropes)
        raise ValueError(
            f"study.hoist = {hoist!r} must have equal ropes ([[rope]] with number = N), not the "
            f"[[rope]] {names} with places, data or breaks of their own, for a study winds one "
            "FMU: wind each variant with `balance-rope wind --set NAME=VALUE`, trips with duty, "
            "and ranges with uncertain"
        )


#: Starts tried before a study winds, spread evenly over more runs; what another refuses is the
#: cause in its row.
MAX_CHECKED = 200
#: Passes the drawn values on one by one while they are checked, which takes a while.
CheckProgress = Callable[[list[dict[str, Value]]], Iterable[dict[str, Value]]]


def read_study(path: Path, fmu: Path | None = None, progress: CheckProgress = list) -> Study:
    """Return a file's study; ``fmu`` replaces the file's. FileError lists all problems."""
    file = read(path, StudyFile)
    with errors_of_file(path):
        header = file.study
        _require_one_rope(header.hoist)
        rope = fmu or Path(header.fmu or f"build/{fmu_name(header.hoist, NATIVE_ENDING)}")
        with Problems() as problems:
            with problems.at("study"):
                available = [*DRIVE_UNITS, *read_outputs(rope, header.hoist)]
                signals = match_signals(header.signals, available)
            with problems.at("study"):
                design_keys = file.design_keys()
            with problems.at("variant"):
                variants = file.variants
            with problems.at("sample"):
                plan, points = file.drawn()
        study = Study(
            title=header.title,
            hoist=header.hoist,
            fmu=rope,
            fmu_hash=hashlib.sha256(rope.read_bytes()).hexdigest(),
            objective=header.objective,
            signals=signals,
            variants=variants,
            varied=file.vary,
            design_keys=design_keys,
            plan=plan,
        )
        return replace(study, samples=tuple(_samples(study, points, progress)))


def _samples(
    study: Study, points: list[dict[str, Value]], progress: CheckProgress
) -> list[StudyRun]:
    """Return the runs of all points, those of a variant one after the other; check all of them."""
    probe = FmuProbe(study.fmu)
    samples: list[StudyRun] = []
    every = math.ceil(len(points) * len(study.variants) / MAX_CHECKED)
    with Problems() as problems:
        for values in progress(points):
            for name in study.variants:
                with problems.at(f"variant {name}" if name else ""):
                    samples.append(study.run(name, values))
                    if not len(samples) % every:
                        probe.require_hoist(samples[-1].data)
                        probe.require_start(samples[-1].data)
    place = {name: k for k, name in enumerate(study.variants)}
    samples.sort(key=lambda sample: place[sample.variant])
    return samples
