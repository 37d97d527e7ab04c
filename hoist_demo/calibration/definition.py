"""A file of measurements, from which a rope is identified; a list of values is a series."""

from functools import cached_property
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from hoist_demo.calibration.fit import MIDDLE, NotComputed
from hoist_demo.calibration.measurements import InShaft, MeasurementEntry, OutputName
from hoist_demo.calibration.prediction import FIDELITY
from hoist_demo.calibration.problem import CalibrationProblem
from hoist_demo.calibration.tracks import Markers
from hoist_demo.cases.run_values import RopeAnalysisFile
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene, values_by_name
from hoist_demo.files.reading import EMPTY, FileError, TomlTable, flat
from hoist_demo.files.registry import group_table, rope_parameters
from hoist_demo.files.rope_file import FOLLOWING
from hoist_demo.files.values import ParameterValue, statuses, unreached, value_type, values_of
from hoist_demo.parameters.problems import Problems
from hoist_demo.parameters.quantity import FileParameter
from rope_model import Datum

_FIDELITY = "model.fidelity"
SOUGHT = ("rope", "air")  #: Groups of parameters that may be sought beside the properties.


class Wanted(TomlTable):
    """An output at rest that is to be known."""

    signal: OutputName = "loop.yaw"
    left_y: float = Field(0.0, allow_inf_nan=False)  # m
    right_y: float = Field(0.0, allow_inf_nan=False)  # m


def _sought(parameter: FileParameter) -> Any:
    """Return the type of a parameter that is looked for."""

    def checked(entry: ParameterValue) -> ParameterValue:
        if parameter.name in {f"rope.{name}" for name in FOLLOWING}:
            raise ValueError(
                f"{parameter.name} follows from the properties, all of which are sought: give "
                "[known]"
            )
        if entry.low is None or entry.high is None or entry.low >= entry.high:
            raise ValueError(
                f"{parameter.name} = {entry.value!r} must be {{ low, high }}, in order"
            )
        return entry

    return Annotated[value_type(parameter), AfterValidator(checked)]


_Sought = flat("Sought", {group: (group_table(group, _sought), None) for group in SOUGHT})


class MeasurementFile(RopeAnalysisFile):
    """Schema of a TOML file of measurements."""

    sought: Annotated[dict[str, ParameterValue], _Sought] = EMPTY
    measurements: list[MeasurementEntry] = Field(alias="measured", min_length=1)
    wanted: Wanted = EMPTY

    @cached_property
    def problem(self) -> CalibrationProblem:
        """Calibration problem of the rope, with the ranges of [sought]."""
        where = f"range of [sought], {self.path.name}"
        ranges = {
            name: Datum(
                entry.low or 0.0, entry.high or 0.0, rope_parameters()[name].unit, "assumed", where
            )
            for name, entry in self.sought.items()
        }
        return CalibrationProblem(self.catalogue_rope, rope_scene(values_of(self.fixed)), ranges)

    @property
    def status_by_name(self) -> dict[str, str]:
        """Status of each value of [fixed] by name."""
        return statuses(self.fixed)

    @model_validator(mode="after")
    def _reaches_the_rope(self) -> Self:
        twice = sorted(self.fixed.keys() & self.sought.keys())
        problems = Problems(
            f"[fixed] {name} = {self.fixed[name].value!r} is also in [sought], with a range: leave "
            "one of them out"
            for name in twice
        )
        fidelity = self.fixed.get(_FIDELITY)
        if fidelity is not None and fidelity.value != rope_parameters()[_FIDELITY].read(FIDELITY):
            problems.append(
                f'[fixed] {_FIDELITY} = {fidelity.value!r} must be "{FIDELITY}", the fidelity at '
                "which [[measured]] is predicted, as torsion is among the properties: leave it out"
            )
        others = {
            name: entry for name, entry in self.fixed.items() if name not in (*twice, _FIDELITY)
        }
        names = self.problem.names
        rope = self.problem.predictor(np.full(len(names), MIDDLE)).scene
        problems += unreached(others, values_by_name(rope))
        problems.refuse()
        return self

    def require_hangs(self) -> None:
        """Refuse a rope of the ranges' middle that cannot hang where it is measured.

        FileError says why.
        """
        predictor = self.problem.predictor(np.full(len(self.problem.names), MIDDLE))
        for k, one in enumerate(self.measurements, 1):
            if not isinstance(one, InShaft):
                continue
            for left, right, _ in one.end_places:
                try:
                    predictor.signal("left.fy", left, right)
                except NotComputed as error:
                    problem = f"measured {k}: the rope cannot hang {error}"
                    raise FileError(self.path, [problem]) from error

    @model_validator(mode="after")
    def _is_within_reach(self) -> Self:
        length = self.problem.catalogue_rope.length
        problems = Problems()
        of_lengths = Problems()
        for k, one in enumerate(self.measurements, 1):
            if isinstance(one, InShaft):
                for left, right, distance in one.end_places:
                    if abs(distance) >= length:
                        problems.append(
                            f"measured {k}: left_y = {left:g}, right_y = {right:g}: the ends must "
                            f"be less than the rope's length = {length:g} m apart, before and "
                            f"after a trip, and are {abs(distance):g} m: correct left_y, right_y "
                            "or travel"
                        )
            if isinstance(one, Markers):
                for name, s in one.lengths.items():
                    if not 0.0 <= s <= length:
                        of_lengths.append(
                            f"measured {k}: {name} = {s:.6g} m must be from 0 to {length:g} m, "
                            "its length: correct one or the unit"
                        )
        problems += of_lengths
        problems.refuse()
        return self
