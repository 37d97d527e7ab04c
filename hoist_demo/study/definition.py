"""A study file (TOML), read and checked as a whole before anything runs.

    [study]    title, fmu, case, signals, and minimise or maximise = a metric, which chooses the best run
    [fixed]    values of all runs
    [[variant]] name and values of one variant; the runs of [vary] are made for every variant
    [sample]   method = "grid" (the default), or "latin-hypercube" with runs and seed
    [vary]     lists (grid) or ranges { low, high } (latin-hypercube, tune)
    [tune]     instead of [sample]: minimise = { metric = weight }, subject_to = { metric = { below, above } },
               sample, searches, steps, seed

A value is a plain one in SI units, or { value, unit, status }, whose status tells where it comes from; a list is [...]
or { values, unit }; a range may have scale = "log". Later ones count: fixed, then variant, then vary; in fixed and
variant from = "FILE" takes the values of that file's [fixed] before all. All errors of a file are told at once.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hoist_demo.cases.table import NAMED, find_case
from hoist_demo.cosimulation.drive_signals import DRIVE_UNITS
from hoist_demo.cosimulation.participants.fmu_description import read_outputs, read_parameters
from hoist_demo.files.catalogue import SECTIONS, Catalogue
from hoist_demo.files.reading import FileError, flat
from hoist_demo.files.values import VARIED
from hoist_demo.parameters.quantity import Parameter, Value
from hoist_demo.recording.time_series import match_signals
from hoist_demo.study.metrics import UNITS
from hoist_demo.study.reading import Problems, read_statuses, read_tables, read_text, strip_unit, with_file
from hoist_demo.study.run import Probe, RunData, build_trip
from hoist_demo.study.tuning import Range, Tuning, grid, latin_hypercube, read_tuning, seed_of, whole_number
from rope_model.texts import printable

METHODS = ("grid", "latin-hypercube")

_TABLES = {"study": dict, "fixed": dict, "variant": list, "sample": dict, "vary": dict, "tune": dict}
_KEYS = {
    "study": {"title", "fmu", "hoist", "signals", "minimise", "maximise"},
    "variant": {"name", "values"},
    "sample": {"method", "runs", "seed"},
    "tune": {"minimise", "subject_to", "sample", "searches", "steps", "seed"},
}


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
    case: str
    signals: tuple[str, ...]
    units: Mapping[str, str]  # of every key that is set
    given: Mapping[str, str]  # where each of them comes from; varied where it differs between runs
    samples: tuple[Sample, ...]  # all runs; for a search the corners of its ranges
    variants: Mapping[str, Mapping[str, Value]]  # fixed values of each variant
    ranges: Mapping[str, Range]
    tuning: Tuning | None
    best: Mapping[str, str] | None = None  # metric and sense by which the best run is chosen; a search has its own

    def sample(self, variant: str, values: Mapping[str, Value]) -> Sample:
        """A run of this study with the given values."""
        everything = {**self.variants[variant], **values}
        return Sample(variant, everything, build_trip(self.case, everything, self.signals))


#: Passes the drawn values on one by one while they are checked, which takes a while.
Progress = Callable[[list[dict[str, Value]]], Iterable[dict[str, Value]]]


def read_study(path: Path, fmu: Path | None = None, progress: Progress = list) -> Study:
    """The study of a file; `fmu` replaces the file's. Raises FileError with all problems."""
    return _Reader(path, fmu).study(progress)


class _Reader:
    """Collects the problems while it reads."""

    def __init__(self, path: Path, fmu: Path | None) -> None:
        self.path, self.fmu = path, fmu
        self.problems = Problems()
        self.raw = read_tables(path, "a study", _TABLES, self.problems)
        self.catalogue, self.fmu_is_there = Catalogue({}), False

    def study(self, progress: Progress) -> Study:
        self._unknown_keys()
        head = self.raw.get("study", {})
        title = read_text("[study] title", head.get("title", printable(self.path.stem)), self.problems)
        fmu = self.fmu if self.fmu is not None else Path(str(head.get("fmu", "build/balance_rope.fmu")))
        with self.problems.collect("[study] fmu" if self.fmu is None else "--fmu"):
            self._open(fmu)
        case, signals = head.get("hoist", "rope-120"), tuple[str, ...]()
        with self.problems.collect("[study]"):
            find_case(str(case))
        with self.problems.collect("[study]"):
            signals = self._signals(head.get("signals", []), fmu)
        best: dict[str, str] | None = None
        with self.problems.collect("[study]"):
            best = self._best(head)
        variants = self._variants(self._values("fixed", self.raw.get("fixed", {})))
        vary = self._vary()
        tuning: Tuning | None = None
        if "tune" in self.raw:
            with self.problems.collect("[tune]"):
                tuning = read_tuning(self.raw.get("tune", {}), len(vary))
        drawn = self._draw(vary, tuning)
        if str(case) not in NAMED:
            raise FileError(self.path, self.problems)
        samples = self._accepted_samples(
            case, signals, Probe(fmu) if self.fmu_is_there else None, variants, progress(drawn)
        )
        if self.problems:
            raise FileError(self.path, self.problems)
        keys = {key: None for values in variants.values() for key in values} | dict.fromkeys(vary)
        return Study(
            title=title,
            fmu=fmu,
            fmu_hash=hashlib.sha256(fmu.read_bytes()).hexdigest(),
            case=case,
            signals=signals,
            units=self.catalogue.units(keys),
            given=self._given(vary, samples),
            samples=tuple(samples),
            variants=variants,
            ranges={key: r for key, r in vary.items() if isinstance(r, Range)},
            tuning=tuning,
            best=best,
        )

    def _given(self, vary: Iterable[str], samples: Sequence[Sample]) -> dict[str, str]:
        given = read_statuses(self.raw.get("fixed", {}))
        for table in self.raw.get("variant", []):
            given |= read_statuses(table.get("values", {}))
        differing = {key for key in given for sample in samples if sample.values.get(key) != samples[0].values.get(key)}
        return given | dict.fromkeys({*vary, *differing}, VARIED)

    def _accepted_samples(
        self,
        case: str,
        signals: tuple[str, ...],
        probe: Probe | None,
        variants: Mapping[str, dict[str, Value]],
        drawn: Iterable[dict[str, Value]],
    ) -> list[Sample]:
        """All runs, variant by variant, each accepted by the data classes and by the FMU, where there is one."""
        found: dict[str, list[Sample]] = {variant: [] for variant in variants}
        for values in drawn:
            for variant, fixed in variants.items():
                everything = {**fixed, **values}
                problems: list[str] = []
                try:
                    data = build_trip(case, everything, signals)
                    problems = probe.rejection(data) if probe is not None else []
                    found[variant].append(Sample(variant, everything, data))
                except ValueError:
                    possible, problems = _possible_values(case, everything)
                    # a rope hangs in its shaft: asked with another one, the FMU would tell a second error that is none
                    problems += probe.rejection(build_trip(case, possible)) if probe is not None else []
                for problem in problems:
                    problem = f"variant {variant}: {problem}" if variant else problem
                    if problem not in self.problems:
                        self.problems.append(problem)
        return [sample for samples in found.values() for sample in samples]

    def _open(self, fmu: Path) -> None:
        try:
            self.catalogue, self.fmu_is_there = Catalogue(read_parameters(fmu)), True
        except ValueError as error:
            raise ValueError(f"{error}; until then nothing of this file that is the FMU's can be checked") from error

    def _is_checkable(self, key: str) -> bool:
        """Return True if the key is the host's, or the FMU is there to ask."""
        return self.fmu_is_there or key == "controller" or key.partition(".")[0] in SECTIONS

    def _signals(self, names: Any, fmu: Path) -> tuple[str, ...]:
        if not isinstance(names, list):
            raise ValueError(f'signals = {names!r} must be a list of names: write ["loop.yaw"]')
        if self.fmu_is_there:
            return match_signals(map(str, names), [*DRIVE_UNITS, *read_outputs(fmu)])
        return tuple(map(str, names))

    def _best(self, head: dict[str, Any]) -> dict[str, str] | None:
        senses = {"minimise": "min", "maximise": "max"}
        given = {name: head[name] for name in senses if name in head}
        if not given:
            return None
        name, metric = next(iter(given.items()))
        if len(given) == 2 or "tune" in self.raw:
            raise ValueError(f"{name} = {metric!r} must be the only word on what is best: keep one, or [tune] minimise")
        if metric not in tuple(UNITS):
            raise ValueError(f"{name} = {metric!r} is not a metric: choose of {', '.join(UNITS)}")
        return {"metric": metric, "sense": senses[name]}

    def _unknown_keys(self) -> None:
        for name, allowed in _KEYS.items():
            content = self.raw.get(name, {})
            for table in content if isinstance(content, list) else [content]:
                for key in table.keys() - allowed:
                    self.problems.append(
                        f"[{name}] {key} = {table[key]!r} is not a key: the keys are {', '.join(sorted(allowed))}"
                    )
        if "tune" in self.raw and "sample" in self.raw:
            self.problems.append("[tune] must not stand beside [sample]: keep one of them")

    def _variants(self, fixed: dict[str, Value]) -> dict[str, dict[str, Value]]:
        """Values of each variant, fixed ones included; one variant without a name when there are none."""
        tables = self.raw.get("variant", [])
        if not tables:
            return {"": fixed}
        variants: dict[str, dict[str, Value]] = {}
        for number, table in enumerate(tables, 1):
            name = read_text("[[variant]] name", table.get("name", number), self.problems)
            if name in variants:
                self.problems.append(f"[[variant]] name = {name!r} must be given once: choose another name")
            variants[name] = fixed | self._values(f"variant {name}", table.get("values", {}))
        return variants

    def _values(self, where: str, table: Mapping[str, Any]) -> dict[str, Value]:
        found: dict[str, Value] = {}
        given: Mapping[str, Any] = {}
        with self.problems.collect(f"[{where}]"):
            given = with_file(table)
        for key, content in flat(given):
            with self.problems.collect(f"[{where}]"):
                if not self._is_checkable(key):
                    continue
                parameter = self.catalogue[key]
                content = strip_unit(parameter, content)
                if isinstance(content, (list, dict)):
                    raise ValueError(f"{key} = {content!r} must be one value here: vary it in [vary]")
                found[key] = parameter.read(content)
        return found

    def _vary(self) -> dict[str, tuple[Value, ...] | Range]:
        found: dict[str, tuple[Value, ...] | Range] = {}
        for key, content in flat(self.raw.get("vary", {})):
            with self.problems.collect("[vary]"):
                if not self._is_checkable(key):
                    continue
                parameter = self.catalogue[key]
                content = strip_unit(parameter, content)
                if isinstance(content, dict):
                    found[key] = self._range(parameter, content)
                elif isinstance(content, list) and content:
                    found[key] = tuple(parameter.read(value) for value in content)
                else:
                    raise ValueError(f"{key} = {content!r} must be a list or {{ low, high }}: fix it in [fixed]")
        return found

    def _range(self, parameter: Parameter, content: dict[str, Any]) -> Range:
        key = parameter.name
        if not {"low", "high"} <= content.keys() <= {"low", "high", "scale"}:
            raise ValueError(f"{key} = {content!r} must have low and high (and may have scale): give both")
        if parameter.kind not in ("Real", "Integer"):
            raise ValueError(f"{key} = {content!r} must be a list, for it is no number: list its values")
        low, high = (float(parameter.read(content[name])) for name in ("low", "high"))
        scale = content.get("scale", "linear")
        if scale not in ("linear", "log"):
            raise ValueError(f"{key}.scale = {scale!r} must be linear or log: choose one")
        if not low < high:
            raise ValueError(f"{key}.low = {low!r} must be below high = {high!r}: exchange them")
        if scale == "log" and low <= 0.0:
            raise ValueError(f"{key}.low = {low!r} must be above 0 for scale = 'log': raise it or take linear")
        return Range(low, high, scale == "log", parameter.kind == "Integer")

    def _draw(self, vary: Mapping[str, tuple[Value, ...] | Range], tuning: Tuning | None) -> list[dict[str, Value]]:
        """The samples of [vary]; for a search the corners of its ranges, to be checked."""
        sample = self.raw.get("sample", {})
        method = "tune" if tuning or "tune" in self.raw else sample.get("method", "grid")
        lists = {key: v for key, v in vary.items() if isinstance(v, tuple)}
        ranges = {key: v for key, v in vary.items() if isinstance(v, Range)}
        with self.problems.collect("[sample]" if method != "tune" else "[tune]"):
            if method not in (*METHODS, "tune"):
                raise ValueError(f"method = {method!r} must be one of {', '.join(METHODS)}: choose one")
            if method == "grid":
                for name in sample.keys() & {"runs", "seed"}:
                    raise ValueError(f"{name} = {sample[name]!r} has no meaning with method = 'grid': leave it out")
                if ranges:
                    raise ValueError(f"{next(iter(ranges))} is a range, a grid needs a list: give {{ values = [...] }}")
                return grid(lists)
            if lists:
                raise ValueError(f"{next(iter(lists))} is a list, {method} needs {{ low, high }}: give a range")
            if not ranges:
                raise ValueError(f"{method} needs ranges: give at least one {{ low, high }} in [vary]")
            if method == "tune":
                return grid({key: (r.at(0.0), r.at(1.0)) for key, r in ranges.items()})
            return latin_hypercube(ranges, whole_number(sample, "runs"), seed_of(sample))
        return [{}]  # the fixed values are still worth a look


def _possible_values(case: str, values: Mapping[str, Value]) -> tuple[dict[str, Value], list[str]]:
    """Return the compatible subset of a wrong run's values, and the conflict of each other value with it."""
    possible: dict[str, Value] = {}
    problems = dict.fromkeys(values, "")
    for _ in values:  # some become possible by others
        before = len(possible)
        for key in [key for key in values if key not in possible]:
            try:
                build_trip(case, {**possible, key: values[key]})
                possible[key] = values[key]
                del problems[key]
            except ValueError as error:
                problems[key] = f"{key} = {values[key]!r}: {error}"
        if len(possible) == before:
            break
    return possible, list(problems.values())
