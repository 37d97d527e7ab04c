"""A rope's properties from a file of measurements.

Found are values with intervals, what stays undetermined, and what to measure next.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from hoist_demo.calibration import measurements as kinds
from hoist_demo.calibration.definition import MeasurementFile
from hoist_demo.calibration.findings import Finding, findings_of
from hoist_demo.calibration.fit import (
    Fit,
    Residuals,
    error_of,
    fit,
    intervals,
    sensitivities,
    with_measurement,
)
from hoist_demo.calibration.measurements import Measurements, RopeMeasurement
from hoist_demo.calibration.problem import CalibrationProblem
from hoist_demo.calibration.tracks import Markers
from hoist_demo.cases.case import DEFAULT_HOIST
from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data_of
from hoist_demo.files.rope_file import following_statuses
from hoist_demo.files.values import GIVEN
from hoist_demo.run.provenance import SourcedValue, rope_provenance
from rope_model import Datum, KnownRope
from rope_model.arrays import Array

#: Is told of each rope that was computed, with the number of its windings.
Computed = Callable[[int], None]
MIN_COMPONENT = 0.3  #: Least part of a property in a direction that names it.
STRONG = 0.7  #: Least correlation that is reported.


@dataclass(frozen=True)
class Candidate:
    """Measurement that could be added, and the standard error of the wanted output with it."""

    measurement: RopeMeasurement
    error: float


@dataclass(frozen=True)
class CalibrationResult:
    """Result of a calibration; ``data`` are the calibrated ranges."""

    measurement_file: MeasurementFile
    fit: Fit
    intervals: Array  # intervals of the shares, (n, 2)
    data: Mapping[str, Datum]
    predicted: Array
    findings: Mapping[str, Finding]  # what was found of each property and parameter sought
    wanted: float
    wanted_error: float
    candidates: tuple[Candidate, ...]  # best first
    warnings: tuple[str, ...]  # warnings of the identified rope at rest

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the properties and parameters that were identified."""
        return self.measurement_file.problem.names

    def is_determined(self, name: str) -> bool:
        """Return True if the data give a property an interval that is narrower than its range."""
        return self.findings[name] == Finding.CALIBRATED

    def value(self, name: str) -> float:
        """Return the identified value of a property in its SI unit."""
        return self.measurement_file.problem.value(name, self.fit.norm_params)

    @property
    def calibrated_rope(self) -> KnownRope:
        """Rope of the catalogue with the calibrated ranges."""
        before = self.measurement_file.problem.catalogue_rope
        return replace(before, data={name: self.data[name] for name in before.data})

    def open_directions(self) -> list[str]:
        """List the properties of each direction that the data leave open, equal sets once."""
        sets: dict[str, None] = {}
        for direction in self.fit.undetermined_directions():
            parts = zip(self.names, direction, strict=True)
            names = [name for name, part in parts if abs(part) > MIN_COMPONENT]
            sets[" and ".join(names)] = None
        return list(sets)

    def provenance(self) -> list[SourcedValue]:
        """Sources of the numbers of the rope and its shaft."""
        problem = self.measurement_file.problem
        status_by_name = {
            "rope.length": GIVEN,
            "rope.diameter": GIVEN,
            **self.measurement_file.status_by_name,
        }
        data_statuses = {name: datum.status for name, datum in self.data.items()}
        status_by_name |= {name: data_statuses[name] for name in problem.sought}
        status_by_name |= following_statuses(data_statuses)
        rope = rope_data_of(problem.scene_at(self.fit.norm_params))
        return rope_provenance(find_case(DEFAULT_HOIST), rope, status_by_name)

    def strong_correlations(self) -> list[tuple[str, str, float]]:
        """Return pairs of properties with their strong correlations."""
        matrix = np.tril(self.fit.correlations, k=-1)
        pairs = []
        for i, j in np.argwhere(np.abs(matrix) > STRONG):
            pairs.append((self.names[j], self.names[i], float(matrix[i, j])))
        return pairs


def identify(
    file: MeasurementFile, computed: Computed = lambda windings: None
) -> CalibrationResult:
    """Fit the properties, find their intervals, and rank candidates for the next measurement."""
    problem = file.problem
    residuals = residuals_of(problem, file.measurements, *stacked(file.measurements), computed)
    tracks = [m for m in file.measurements if isinstance(m, Markers)]
    count = len(problem.names)
    whole = replace(
        fit(residuals, count + sum(m.starts for m in tracks)),
        nuisance=sum(m.unknowns for m in tracks),
    )
    properties_fit = whole.of_first_params(count)
    ends = _interval_ends(residuals, whole, properties_fit)
    findings = dict(zip(problem.names, findings_of(properties_fit, ends), strict=True))
    where: Any = dict(file.wanted)
    wanted = kinds.AtRest(value=(0.0,), sigma=1.0, **where)
    ranking = _ranking(problem, wanted, properties_fit)
    predictor = problem.predictor(properties_fit.norm_params)
    predicted = problem.predict(whole.norm_params, [*file.measurements, wanted], predictor)
    return CalibrationResult(
        file,
        properties_fit,
        ends,
        data=calibrated(file, findings, ends),
        predicted=predicted[:-1],
        findings=findings,
        wanted=float(predicted[-1]),
        wanted_error=ranking.error_now,
        candidates=ranking.candidates,
        warnings=predictor.warnings,
    )


def _interval_ends(residuals: Residuals, whole: Fit, properties_fit: Fit) -> Array:
    """Return the ends (n, 2) of the properties' intervals, as shares of the ranges."""
    count = properties_fit.norm_params.size
    ranges = np.tile([0.0, 1.0], (count, 1))
    if properties_fit.contradicted:  # no interval follows from such measurements
        return ranges
    if whole.norm_params.size == count:
        return intervals(residuals, properties_fit)
    # with a start, residuals are too nonlinear for a profile's few corrections
    reaches = np.outer(properties_fit.reaches, [-1.0, 1.0])
    linear = np.clip(properties_fit.norm_params[:, None] + reaches, 0.0, 1.0)
    return np.where(properties_fit.held[:, None] == 0, linear, ranges)


class _Ranking(NamedTuple):
    """Standard errors of the output wanted."""

    error_now: float
    candidates: tuple[Candidate, ...]  # further measurements, the one of the smallest error first


def _ranking(problem: CalibrationProblem, wanted: RopeMeasurement, properties_fit: Fit) -> _Ranking:
    """Rank candidates for the next measurement by what they would leave of the error."""
    possible = candidates(problem, properties_fit.norm_params)
    rows = sensitivities(
        lambda u: problem.predict(u, [wanted, *possible]), properties_fit.norm_params
    )
    gradient = rows[0]
    covariance = properties_fit.covariance
    ranked: list[Candidate] = []
    for m, row in zip(possible, rows[1:], strict=True):
        after = with_measurement(covariance, row / m.sigma)
        ranked.append(Candidate(m, error_of(after, gradient)))
    ranked.sort(key=lambda candidate: candidate.error)
    return _Ranking(error_of(covariance, gradient), tuple(ranked))


def stacked(measurements: Measurements) -> tuple[Array, Array]:
    """Stack all values and their standard errors, each (m,)."""
    values: list[float] = []
    sigmas: list[float] = []
    for m in measurements:
        values += [*m.values]
        sigmas += [m.sigma] * len(m.values)
    return np.array(values), np.array(sigmas)


def residuals_of(
    problem: CalibrationProblem,
    measurements: Measurements,
    values: Array,
    sigmas: Array,
    computed: Computed = lambda windings: None,
) -> Residuals:
    """Return the function (norm_params) -> (predictions - values) / sigmas, (m,).

    ``computed`` hears of each rope.
    """
    lock = Lock()  # several ropes are computed at once

    def residuals(norm_params: Array) -> Array:
        predictor = problem.predictor(norm_params)
        try:
            return np.asarray(
                (problem.predict(norm_params, measurements, predictor) - values) / sigmas
            )
        finally:
            with lock:
                computed(predictor.windings)

    return residuals


def calibrated(
    file: MeasurementFile, findings: Mapping[str, Finding], ends: Array
) -> dict[str, Datum]:
    """Replace ranges by calibrated intervals.

    If the model is contradicted, ranges stand with that status.
    """
    data = file.problem.data
    source = file.path.name
    for (name, finding), interval in zip(findings.items(), ends, strict=True):
        if finding == Finding.CONTRADICTED:
            data[name] = replace(data[name], status="contradicted", source=source)
        elif finding == Finding.CALIBRATED:
            low, high = (data[name].at(float(share)) for share in interval)
            data[name] = Datum(low, high, data[name].unit, "calibrated", source)
    return data


def candidates(problem: CalibrationProblem, norm_params: Array) -> list[RopeMeasurement]:
    """List possible next measurements, each with its usual error [assumed]."""
    predictor = problem.predictor(norm_params)
    data = predictor.scene.rope
    load = 0.5 * data.length * data.mass_per_length * predictor.scene.layout.gravity
    torsion = predictor.properties["torsional_stiffness"]
    width = problem.predict(norm_params, [kinds.LoopWidth(value=(1.0,), sigma=1.0)])[0]
    turn = 0.05 * load * data.diameter / torsion  # rad/m, for a torque like those of torque factors
    torque = 5e-4 * load * data.diameter
    kilonewtons = f"under {1e-3 * load:.3g} kN"
    share = "to 0.05 % of load times diameter"
    sample: Any = {"value": 1.0, "load": load}
    level: Any = {"value": 0.0, "left_y": 0.0, "right_y": 0.0}
    twisted = f"torque of a sample {kilonewtons} turned in by {turn:.2g} rad/m, {share}"
    rotation = f"rotation of a 10 m sample {kilonewtons}, to 5 degrees"
    extension = f"extension of a 10 m sample {kilonewtons}, to 0.5 mm"
    yaw = "yaw of the loop at equal heights, by camera, to 1 degree"
    torque_at_rest = "torque of the left end at equal heights, to 0.5 N m"
    return [
        kinds.LoopWidth(name="width of the free loop, to 1 %", value=(1.0,), sigma=0.01 * width),
        kinds.Mass(name="mass, to 0.5 %", value=(1.0,), sigma=5e-3 * data.mass_per_length),
        kinds.SampleTorque(
            name=f"torque of a sample {kilonewtons}, {share}", sigma=torque, **sample
        ),
        kinds.SampleTorque(name=twisted, sigma=torque, twist=(turn,), **sample),
        kinds.SampleRotation(name=rotation, sigma=np.deg2rad(5), length=(10.0,), **sample),
        kinds.SampleExtension(name=extension, sigma=5e-4, length=(10.0,), **sample),
        kinds.AtRest(name=yaw, sigma=np.deg2rad(1), signal="loop.yaw", **level),
        kinds.AtRest(name=torque_at_rest, sigma=0.5, signal="left.swivel.torque", **level),
    ]
