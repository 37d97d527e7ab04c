"""A file that asks how uncertain a winding is: what is known of the rope varies within its ranges."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Literal, Self

from pydantic import Field, field_validator, model_validator

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data_of, rope_scene
from hoist_demo.files.rope_file import FOLLOWING, following_statuses
from hoist_demo.files.run_values import LevelHeader, RopeAnalysisFile, RunFile
from hoist_demo.files.values import DERIVED, GIVEN, VARIED, ParameterValue, statuses
from hoist_demo.parameters import SIDES
from hoist_demo.parameters.quantity import Value
from hoist_demo.study.metrics import UNITS
from hoist_demo.study.provenance import SourcedValue, host_provenance, rope_provenance
from hoist_demo.study.run import RunData, build, from_landing
from rope_model import BEARINGS, Datum, KnownRope

MEASURES = ("clearance", "loop_yaw", "left_swivel_torque", "rope_force_ripple")


class UncertaintyHeader(LevelHeader):
    """Table [uncertain] at the head of the file."""

    samples: int = Field(64, ge=8, description="a power of two")
    seed: int = Field(1, ge=0)
    measures: tuple[Literal[tuple(UNITS)], ...] = Field(MEASURES, min_length=1)  # type: ignore[valid-type]
    bearing: Literal["", *BEARINGS] = ""  # type: ignore[valid-type]  # bearing of both swivels, whose friction then varies

    @field_validator("samples")
    @classmethod
    def _power_of_two(cls, samples: int) -> int:
        if samples & (samples - 1):
            raise ValueError(f"samples = {samples} must be a power of two from 8 on: 64 suits a first look")
        return samples


class UncertaintyFile(RopeAnalysisFile, RunFile):
    """Schema of a TOML file that asks how uncertain a winding is."""

    header: UncertaintyHeader = Field({}, alias="uncertain", validate_default=True)

    @cached_property
    def known_rope(self) -> KnownRope:
        """Rope with its ranges, as long as the hoist's unless the file states a length."""
        if "length" in self.catalogue_arguments:
            return self.catalogue_rope
        return replace(self.catalogue_rope, length=find_case(self.header.hoist).hoist.tail_rope_length)

    @property
    def data(self) -> dict[str, Datum]:
        """Ranges of the data that vary, by name."""
        ranges = {name: datum for name, datum in self.known_rope.data.items() if datum.high > datum.low}
        return ranges | (BEARINGS[self.header.bearing] if self.header.bearing else {})

    @model_validator(mode="after")
    def _varies(self) -> Self:
        if not self.data:
            raise ValueError("nothing varies: give a property of [known] a range, { low, high }")
        self.provenance()
        return self

    def provenance(self) -> list[SourcedValue]:
        """Return the provenance of the data; a property that varies has the status of its range."""
        data = self.data
        run = self.run({name: datum.middle for name, datum in data.items()})
        status_of = {name: VARIED if name in data else datum.status for name, datum in self.known_rope.data.items()}
        status = {"rope.diameter": GIVEN, **statuses(self.fixed), **following_statuses(status_of)}
        if "length" in self.catalogue_arguments:
            status |= dict.fromkeys(("rope.length", "hoist.tail_rope_length"), GIVEN)
        if self.header.bearing:
            status |= {f"{side}.swivel.{name}": VARIED for side in SIDES for name in ("mu_kinetic", "mu_static")}
        rope = rope_data_of(rope_scene(run.rope_values, self.level))
        return [*host_provenance(run, status), *rope_provenance(find_case(self.header.hoist), rope, status)]

    def run(self, values: Mapping[str, float]) -> RunData:
        """Return the data of a winding with these values of what varies.

        The drive's feed-forward takes the rope as it is; its trip is designed for the middle of all ranges.
        """
        fixed: dict[str, Value | ParameterValue] = {"model.fidelity": 1, **self.fixed}
        middle = self._drawn({name: datum.middle for name, datum in self.data.items()})
        return from_landing(build(self.header.hoist, fixed, varied=self._drawn(values), nominal=middle))

    def _drawn(self, values: Mapping[str, float]) -> dict[str, Value | ParameterValue]:
        """Return the values of rope and drive that follow from these of what varies."""
        held = {name: datum.low for name, datum in self.known_rope.data.items() if name not in self.data}
        rope = self.known_rope.rope(**held, **{name: values[name] for name in self.known_rope.data if name in values})
        drawn: dict[str, Value | ParameterValue] = {
            **{f"rope.{name}": float(getattr(rope, name)) for name in FOLLOWING},
            "hoist.tail_rope_mass": rope.mass_per_length,
            "hoist.tail_rope_length": ParameterValue(rope.length, DERIVED),
        }
        if self.header.bearing:
            for side in SIDES:
                drawn[f"{side}.swivel.mu_kinetic"] = values["running_friction"]
                drawn[f"{side}.swivel.mu_static"] = values["running_friction"] * values["starting_ratio"]
        return drawn
