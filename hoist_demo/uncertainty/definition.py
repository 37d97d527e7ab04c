"""A file that asks how uncertain a winding is (TOML), read and checked before anything runs.

    [uncertain]  title, hoist, level, samples, seed, measures, and bearing = that of the swivels, in the catalogue
    [rope]       construction, diameter, length (else the hoist's), lay: what the catalogue is asked for
    [known]      properties that are known better than the catalogue does: a number, or { low, high }
    [fixed]      values of all windings, as in a study

[rope] and [known] are those of a file of measurements, and of the parameter file that its fit writes: in [rope],
from = "FILE" takes both of it. All errors of a file are told at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, create_model, field_validator

from hoist_demo.calibration.definition import Properties, RopeAsked, follows_from_properties, known_rope
from hoist_demo.calibration.measurements import FOLLOWING
from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data, scene_parameters
from hoist_demo.files.fixed import Head, cure, fixed_model, fixed_values, plain, statuses
from hoist_demo.files.reading import FileError, Table, optional, read_toml, validated
from hoist_demo.files.rope_file import following_statuses
from hoist_demo.files.values import GIVEN, VARIED
from hoist_demo.parameters.quantity import Value
from hoist_demo.study.metrics import UNITS
from hoist_demo.study.provenance import Known, of_host, of_rope
from hoist_demo.study.run import RunData, build_trip
from rope_model import BEARINGS, Datum, KnownRope, Level
from rope_model.texts import printable

MEASURES = ("clearance", "loop_yaw", "left_swivel_torque", "rope_force_ripple")
SWIVELS = ("left", "right")


@dataclass(frozen=True)
class Uncertain:
    """A checked file."""

    title: str
    hoist: str  # name or file
    level: Level
    samples: int
    seed: int
    measures: tuple[str, ...]
    bearing: str  # "" where friction does not vary
    known: KnownRope
    fixed: Mapping[str, Value]
    given: Mapping[str, str]  # where each value of `fixed` comes from

    @property
    def data(self) -> dict[str, Datum]:
        """Data that vary, by name."""
        found = {name: datum for name, datum in self.known.data.items() if datum.high > datum.low}
        return found | (BEARINGS[self.bearing] if self.bearing else {})

    def provenance(self) -> list[Known]:
        """Sources of the numbers; of a property that varies, its range has the status."""
        run = self.run({name: datum.middle for name, datum in self.data.items()})
        known = {name: VARIED if name in self.data else datum.status for name, datum in self.known.data.items()}
        given = {"rope.diameter": GIVEN, **self.given, **following_statuses(known)}
        if self.bearing:
            given |= {f"{side}.swivel.{name}": VARIED for side in SWIVELS for name in ("mu_kinetic", "mu_static")}
        rope = scene_parameters(rope_data(run.fmu, self.level))
        return [*of_host(run, given), *of_rope(find_case(self.hoist), rope, given)]

    def run(self, values: Mapping[str, float]) -> RunData:
        """The winding with these values of what varies; the drive takes the rope for what it is."""
        held = {name: datum.low for name, datum in self.known.data.items() if name not in self.data}
        rope = self.known.rope(**held, **{name: values[name] for name in self.known.data if name in values})
        chosen: dict[str, Value] = {
            "model.fidelity": 1,
            **self.fixed,
            **{f"rope.{name}": float(getattr(rope, name)) for name in FOLLOWING},
            "hoist.tail_rope_mass": rope.mass_per_length,
            "hoist.tail_rope_length": rope.length,
        }
        if self.bearing:
            for side in SWIVELS:
                chosen[f"{side}.swivel.mu_kinetic"] = values["running_friction"]
                chosen[f"{side}.swivel.mu_static"] = values["running_friction"] * values["starting_ratio"]
        return build_trip(self.hoist, chosen)


class _Head(Head):
    level: Level | None = None
    samples: int = Field(default=64, ge=8, description="a power of two")
    seed: int = Field(default=1, ge=0)
    measures: tuple[Literal[tuple(UNITS)], ...] = Field(default=MEASURES, min_length=1)  # type: ignore[valid-type]
    bearing: Literal["", *BEARINGS] = ""  # type: ignore[valid-type]

    @field_validator("samples")
    @classmethod
    def _power_of_two(cls, samples: int) -> int:
        if samples & (samples - 1):
            raise ValueError(f"samples = {samples} must be a power of two from 8 on: 64 suits a first look")
        return samples


@cache
def _model() -> type[Table]:
    made: type[Table] = create_model(
        "UncertainFile",
        __base__=Table,
        uncertain=(_Head, _Head()),
        rope=(RopeAsked, RopeAsked()),
        known=(Properties, {}),
        fixed=optional(fixed_model()),
    )
    return made


def read_uncertain(path: Path) -> Uncertain:
    """Return the questions of a file; raise FileError with all problems."""
    file: Any = validated(path, _model(), _with_file(path, read_toml(path)), cure)
    head, problems = file.uncertain, list[str]()
    known, fixed = known_rope(path, file.rope, file.known, problems), fixed_values(file.fixed)
    problems += follows_from_properties(fixed)
    if problems or known is None:
        raise FileError(path, problems)
    given, case = statuses(fixed), find_case(head.hoist)
    if file.rope.length is not None:
        given |= dict.fromkeys(("rope.length", "hoist.tail_rope_length"), GIVEN)
    else:
        known = replace(known, length=case.hoist.tail_rope_length)
    title, level = head.title or printable(path.stem), head.level or case.level
    asked = Uncertain(
        title,
        head.hoist,
        level,
        head.samples,
        head.seed,
        tuple(head.measures),
        head.bearing,
        known,
        plain(fixed),
        given,
    )
    if not asked.data:
        raise FileError(path, ["nothing varies: give a property of [known] a range, { low, high }"])
    try:
        asked.run({name: datum.middle for name, datum in asked.data.items()})
    except ValueError as error:
        raise FileError(path, [str(error)]) from error
    return asked


def _with_file(path: Path, raw: dict[str, Any]) -> dict[str, Any]:
    """Return the tables, [rope] and [known] over those of the file that `from` names."""
    table = raw.get("rope", {})
    if not isinstance(table, dict) or "from" not in table:
        return raw
    try:
        other = read_toml(Path(str(table["from"])))
    except FileError as error:
        raise FileError(path, [f"[rope] {error}"]) from error
    own, known = {key: one for key, one in table.items() if key != "from"}, raw.get("known", {})
    below = {name: part if isinstance(part := other.get(name, {}), dict) else {} for name in ("rope", "known")}
    return {**raw, "rope": below["rope"] | own, "known": below["known"] | known if isinstance(known, dict) else known}
