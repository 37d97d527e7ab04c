"""A file that asks how uncertain a winding is (TOML), read and checked before anything runs.

    [uncertain]  title, case, level, samples, seed, measures, and bearing = that of the swivels, in the catalogue
    [rope]       construction, diameter, length (else the case's), lay: what the catalogue is asked for
    [known]      properties that are known better than the catalogue does: a number, or { low, high }
    [fixed]      values of all windings, as in a study

[rope] and [known] are those of a file of measurements, and of the parameter file that its fit writes: in [rope],
from = "FILE" takes both of it. All errors of a file are told at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from hoist_demo.calibration.definition import read_known
from hoist_demo.calibration.measurements import FOLLOWING
from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.inprocess_rope import rope_data, scene_parameters
from hoist_demo.files.catalogue import Catalogue
from hoist_demo.files.reading import FileError, read_toml
from hoist_demo.files.rope_file import following_statuses
from hoist_demo.files.values import GIVEN, VARIED
from hoist_demo.parameters.quantity import Parameter, Value
from hoist_demo.study.metrics import UNITS
from hoist_demo.study.provenance import Known, of_host, of_rope
from hoist_demo.study.reading import Problems, read_head, read_statuses, read_tables, read_values
from hoist_demo.study.run import RunData, build_trip
from rope_model import BEARINGS, Datum, KnownRope, Level

_TABLES = {"uncertain": dict, "rope": dict, "known": dict, "fixed": dict}
MEASURES = ("clearance", "loop_yaw", "left_swivel_torque", "rope_force_ripple")
_OWN: dict[str, Any] = {"samples": 64, "seed": 1, "measures": list(MEASURES), "bearing": ""}
SWIVELS = ("left", "right")


@dataclass(frozen=True)
class Uncertain:
    """A checked file."""

    title: str
    case: str
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
        return [*of_host(run, given), *of_rope(find_case(self.case), rope, given)]

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
        return build_trip(self.case, chosen)


def read_uncertain(path: Path, parameters: Mapping[str, Parameter]) -> Uncertain:
    """Return the questions of a file about a rope with these parameters; raise FileError with all problems."""
    problems = Problems()
    raw = read_tables(path, "an uncertain winding", _TABLES, problems)
    head = read_head(path, "uncertain", raw.get("uncertain", {}), _OWN, problems)
    _check(head, problems)
    fixed = read_values(Catalogue(parameters), "[fixed]", raw.get("fixed", {}), problems)
    for key in fixed.keys() & {f"rope.{name}" for name in FOLLOWING}:
        problems.append(f"[fixed] {key} follows from the properties: give [known] or [rope] instead")
    both = _with_file(raw, problems)
    known = None if both is None else read_known(path, both, problems)
    if problems or both is None or known is None:
        raise FileError(path, problems)
    given = read_statuses(raw.get("fixed", {}))
    if "length" in both["rope"]:
        given |= dict.fromkeys(("rope.length", "hoist.tail_rope_length"), GIVEN)
    else:
        length = find_case(head["hoist"]).rope["rope.length"]
        known = replace(known, length=float(length))
    asked = Uncertain(known=known, fixed=fixed, given=given, **{**head, "measures": tuple(head["measures"])})
    if not asked.data:
        raise FileError(path, ["nothing varies: give a property of [known] a range, { low, high }"])
    try:
        asked.run({name: datum.middle for name, datum in asked.data.items()})
    except ValueError as error:
        raise FileError(path, [str(error)]) from error
    return asked


def _with_file(raw: Mapping[str, Any], problems: Problems) -> Mapping[str, Any] | None:
    """[rope] and [known] over those of the file that `from` names; None where that cannot be read."""
    table = raw.get("rope", {})
    if "from" not in table:
        return {"rope": table, "known": raw.get("known", {})}
    try:
        other = read_toml(Path(str(table["from"])))
    except FileError as error:
        problems.append(f"[rope] {error}")
        return None
    own = {key: value for key, value in table.items() if key != "from"}
    return {"rope": other.get("rope", {}) | own, "known": other.get("known", {}) | raw.get("known", {})}


def _check(head: Mapping[str, Any], problems: Problems) -> None:
    samples, seed, bearing = head["samples"], head["seed"], head["bearing"]
    if type(samples) is not int or samples < 8 or samples & (samples - 1):
        problems.append(f"[uncertain] samples = {samples!r} must be a power of two from 8 on: 64 suits a first look")
    if type(seed) is not int or seed < 0:
        problems.append(f"[uncertain] seed = {seed!r} must be a whole number from 0 on: take 1")
    if bearing and bearing not in tuple(BEARINGS):
        problems.append(f"[uncertain] bearing = {bearing!r} must be one of {', '.join(BEARINGS)}: choose one")
    if not isinstance(head["measures"], list) or not head["measures"]:
        problems.append(f"[uncertain] measures = {head['measures']!r} must be a list: write {list(MEASURES)}")
        return
    for name in head["measures"]:
        if name not in tuple(UNITS):
            problems.append(f"[uncertain] measures: {name!r} is not a metric: choose of {', '.join(UNITS)}")
