"""File of an uncertain winding: the rope's properties vary within their ranges."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Literal, Self

from pydantic import Field, field_validator, model_validator

from hoist_demo.cases.case import BalanceRopeData, Case
from hoist_demo.cases.rules import case_with_values
from hoist_demo.cases.run_values import LevelHeader, RopeAnalysisFile, RunFile
from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data_of, values_by_name
from hoist_demo.files.reading import FileError
from hoist_demo.files.registry import rope_parameters
from hoist_demo.files.rope_file import FOLLOWING, following_statuses
from hoist_demo.files.values import DERIVED, GIVEN, VARIED, ParameterValue, statuses, unreached
from hoist_demo.parameters import SIDES, start_heights
from hoist_demo.parameters.problems import Problems
from hoist_demo.parameters.quantity import Value
from hoist_demo.run.data import RunData, build_single_trip
from hoist_demo.run.metrics import ROPE_SIGNALS, UNITS, names_of
from hoist_demo.run.provenance import SourcedValue, host_provenance, rope_provenance
from hoist_demo.run.ropes import Ropes, require_unbroken, ropes_of
from rope_model import BEARINGS, Datum, EndMotion, KnownRope, Scene, balance_rope
from rope_model.scene_names import choices_of

MEASURES = ("clearance", "loop_yaw", "left_swivel_torque", "rope_force_ripple")


#: Code of the model that yaw and torques need.
TORSIONAL = choices_of("model.fidelity").index("torsional")
_COUPLING = ("rope.Qb", "rope.Qc")  #: Parameters whose sign is that of the lay.
Drawn = Value | ParameterValue


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
            raise ValueError(
                f"samples = {samples} must be a power of two from 8 on: 64 suits a first look"
            )
        return samples


#: Friction of both swivels, which follows from a bearing.
_FRICTION = (
    "left.swivel.mu_kinetic",
    "left.swivel.mu_static",
    "right.swivel.mu_kinetic",
    "right.swivel.mu_static",
)


class UncertaintyFile(RopeAnalysisFile, RunFile):
    """Schema of a TOML file that asks how uncertain a winding is."""

    header: UncertaintyHeader = Field({}, alias="uncertain", validate_default=True)

    @cached_property
    def known_rope(self) -> KnownRope:
        """Rope with its ranges, as long as the hoist's unless the file states a length."""
        if "length" in self.catalogue_arguments:
            return self.catalogue_rope
        return replace(
            self.catalogue_rope, length=find_case(self.header.hoist).hoist.tail_rope_length
        )

    @property
    def data(self) -> dict[str, Datum]:
        """Ranges of the data that vary, by name."""
        ranges = {
            name: datum for name, datum in self.known_rope.data.items() if datum.high > datum.low
        }
        if self.header.bearing:
            ranges |= BEARINGS[self.header.bearing]
        return ranges

    @model_validator(mode="after")
    def _varies(self) -> Self:
        require_unbroken(find_case(self.header.hoist), "a rope in pieces has no such results")
        if not self.data:
            raise ValueError("nothing varies: give a property of [known] a range, { low, high }")
        Problems(self._contradictions()).refuse()
        ropes = self.middle_ropes()
        if self.header.bearing:
            self._require_friction([rope.scene for rope in ropes.ropes])
        fixed = dict(self.fixed)
        if ropes.case.distinct_ropes:
            # each rope has the distance of its own suspension points
            fixed.pop("layout.spacing", None)
        for rope in ropes.ropes:
            values = {**ropes.run.host_values(), **values_by_name(rope.scene)}
            Problems(unreached(fixed, values)).refuse()
        return self

    def _require_friction(self, scenes: Sequence[Scene]) -> None:
        """Refuse a bearing whose friction no swivel has."""
        last = scenes[-1]
        if "coulomb" in (last.left.mode, last.right.mode):
            return
        modes = f'left.swivel.mode = "{last.left.mode}" and right.swivel.mode = "{last.right.mode}"'
        raise ValueError(
            f"[uncertain] bearing = {self.header.bearing!r} varies a friction that swivels with "
            f'{modes} do not have: set [fixed] swivels.mode = "coulomb", or leave bearing out'
        )

    def _contradictions(self) -> Iterator[str]:
        """Yield a sentence for each value of [fixed] which follows from the varied data."""
        places = {
            "hoist.tail_rope_mass": "the rope's [known] mass_per_length",
            "hoist.tail_rope_length": "the rope's [rope] length",
        }
        if self.header.bearing:
            places |= dict.fromkeys(_FRICTION, f"[uncertain] bearing = {self.header.bearing!r}")
        for name, entry in self.fixed.items():
            if name in places:
                yield (
                    f"[fixed] {name} = {entry.value!r} follows from {places[name]}: leave it out, "
                    "and set that"
                )

    @cached_property
    def measured(self) -> tuple[str, ...]:
        """Names of the results, of several ropes those of each with its name."""
        ropes = [rope.name for rope in self._case.distinct_ropes] or [""]
        names: list[str] = []
        for metric in self.header.measures:
            names += names_of(metric, ropes)
        return tuple(names)

    @cached_property
    def _case(self) -> Case:
        """Hoist with the values of the file, as far as they are not drawn."""
        return case_with_values(find_case(self.header.hoist), self._fixed)

    @property
    def _fixed(self) -> Mapping[str, ParameterValue]:
        """Values of [fixed]; the rope is torsional where neither it nor the hoist says another."""
        for rope in find_case(self.header.hoist).balance_ropes:
            if "model.fidelity" in rope.values:
                return self.fixed
        return {"model.fidelity": ParameterValue(TORSIONAL), **self.fixed}

    def provenance(self) -> list[SourcedValue]:
        """Return the provenance of the data; a property that varies has the status of its range."""
        data = self.data
        ropes = self.middle_ropes()
        of_properties: dict[str, str] = {}
        for name, datum in self.known_rope.data.items():
            of_properties[name] = VARIED if name in data else datum.status
        status = {"rope.diameter": GIVEN, **statuses(self.fixed)}
        status |= following_statuses(of_properties)
        if "length" in self.catalogue_arguments:
            status |= dict.fromkeys(("rope.length", "hoist.tail_rope_length"), GIVEN)
        if self.header.bearing:
            status |= dict.fromkeys(_FRICTION, VARIED)
        if not ropes.case.distinct_ropes:
            rope = rope_data_of(ropes.ropes[0].scene)
            return [
                *host_provenance(ropes.run, status),
                *rope_provenance(find_case(self.header.hoist), rope, status),
            ]
        return [*host_provenance(ropes.run, status), *ropes.provenance(status)]

    def ropes(self, values: Mapping[str, float]) -> Ropes:
        """Return the balance ropes and their run with these values of the varied data.

        The drive has their data, too. All of several ropes are of the drawn kind: each keeps its
        place, its length unless the file states one, and its sense of lay relative to the first
        rope's.
        """
        drawn = self._drawn(values)
        case = self._case
        if not case.distinct_ropes:
            return ropes_of(case, self._run(drawn), {}, self.level, ROPE_SIGNALS)
        first = case.distinct_ropes[0]
        balance_ropes = []
        for rope in case.distinct_ropes:
            rope_values = {**rope.values, **self._for_rope(rope, first, drawn)}
            balance_ropes.append(replace(rope, values=rope_values))
        case = replace(case, balance_ropes=tuple(balance_ropes))
        run = self._run(
            {name: value for name, value in drawn.items() if not name.startswith("hoist.tail_rope")}
        )
        ropes = ropes_of(case, run, {}, self.level, ROPE_SIGNALS)
        return replace(ropes, run=replace(run, hoist=ropes.hoist))

    @property
    def _middles(self) -> dict[str, float]:
        """Middles of the ranges of what varies, by name."""
        return {name: datum.middle for name, datum in self.data.items()}

    def middle_ropes(self) -> Ropes:
        """Return the balance ropes of a winding with the middle of each range."""
        return self.ropes(self._middles)

    def require_hangs(self) -> None:
        """Refuse a rope of the ranges' middle that cannot hang where the trip begins.

        FileError says why.
        """
        ropes = self.middle_ropes()
        run = ropes.run
        left, right = start_heights(run.hoist, run.winding)
        for each in ropes.ropes:
            rope = balance_rope(each.scene)
            status = rope.initialize(run.coupling.start, EndMotion(y=left), EndMotion(y=right))
            if not status.valid:
                name = each.name or "the rope"
                where = (
                    f"at rest with its ends at {left:g} m and {right:g} m, in the middle of all "
                    "ranges"
                )
                raise FileError(self.path, [f"{where}, {name} cannot hang: {status.message}"])

    def run(self, values: Mapping[str, float]) -> RunData:
        """Return the data of a winding with these values of what varies."""
        return self.ropes(values).run

    def _for_rope(
        self, rope: BalanceRopeData, first: BalanceRopeData, drawn: Mapping[str, Drawn]
    ) -> dict[str, ParameterValue]:
        """Return the drawn values of one of several ropes."""
        keeps_length = "length" not in self.catalogue_arguments
        values: dict[str, ParameterValue] = {}
        for name, value in drawn.items():
            if name.startswith("hoist.") or (keeps_length and name == "rope.length"):
                continue
            if isinstance(value, ParameterValue):
                values[name] = value
            else:
                values[name] = ParameterValue(value)
        if _lay(rope) * _lay(first) < 0.0:
            for name in _COUPLING:
                values[name] = ParameterValue(-float(values[name].value))
        return values

    def _run(self, drawn: Mapping[str, Drawn]) -> RunData:
        """Return the data of a winding with these values.

        The drive's feed-forward takes the rope as it is; its trip is designed for the middle of all
        ranges.
        """
        middle = self._drawn(self._middles)
        nominal = {name: middle[name] for name in drawn}
        hoist = self.header.hoist
        return build_single_trip(hoist, self._fixed, varied=drawn, nominal=nominal)

    def _drawn(self, values: Mapping[str, float]) -> dict[str, Drawn]:
        """Return the values of rope and drive that follow from these of the varied data."""
        properties: dict[str, float] = {}
        for name, datum in self.known_rope.data.items():
            if name in values:
                properties[name] = values[name]
            elif name not in self.data:
                properties[name] = datum.low
        rope = self.known_rope.rope(**properties)
        drawn: dict[str, Drawn] = {f"rope.{name}": float(getattr(rope, name)) for name in FOLLOWING}
        drawn["hoist.tail_rope_mass"] = rope.mass_per_length
        drawn["hoist.tail_rope_length"] = ParameterValue(rope.length, DERIVED)
        if self.header.bearing:
            kinetic = values["running_friction"]
            static = kinetic * values["starting_ratio"]
            for side in SIDES:
                drawn[f"{side}.swivel.mu_kinetic"] = kinetic
                drawn[f"{side}.swivel.mu_static"] = static
        return drawn


def _lay(rope: BalanceRopeData) -> float:
    """Return the number with the sign of the coupling of tension and torsion, that of the lay."""
    return float(rope.parameters.get(_COUPLING[0], rope_parameters()[_COUPLING[0]].start))
