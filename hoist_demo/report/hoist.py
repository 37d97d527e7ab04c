"""A hoist before it is wound: its values with their sources, and what follows from them."""

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

from hoist_demo.cases.case import Case
from hoist_demo.cases.rules import RuleInputs
from hoist_demo.cases.writing import hoist_text
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.design.statics import at_rest, pulls, reached, static_slip_safeties
from hoist_demo.files.registry import rope_parameters
from hoist_demo.files.values import ASSUMED, GIVEN, STATUSES, ParameterValue
from hoist_demo.parameters import SIDES, Hoist, Winding
from hoist_demo.parameters.components import Brake
from hoist_demo.parameters.quantity import Value
from hoist_demo.report.rows import SummaryRow, render
from hoist_demo.run.data import RunData, build, from_landing
from hoist_demo.run.provenance import SETTING, SourcedValue, host_provenance, statuses
from hoist_demo.run.ropes import OneRope, ropes_of
from rope_model import EndMotion, Scene, balance_rope
from rope_model.analysis.modes import natural_modes
from rope_model.engine import NativeRope

MODES = 4  #: Number of the rope's lowest modes in the table.
SHOWN_CLEARANCE = 1e3  #: Clearances below it are shown [m]: beyond there is no body.
_AT_REST = "Rope at rest, left conveyance at"
_HOLD = "Hold on the sheave"
_DRIVE = "Motor and brake"
#: Most yaw of a loop in a trip over that at rest [assumed]: 2.1 in a trip of 870 m at 16 m/s.
YAWS = 3.0
Values = Mapping[str, Value]


def complete_file(
    case: Case, run: RunData, ropes: Sequence[RopeData], provenance: Iterable[SourcedValue]
) -> str:
    """Return a hoist's file with every value of a run and its status.

    Wound again, it gives the same bits.
    """
    entries = _Entries(case, statuses(provenance))
    level = ropes[0].level or case.level
    lines = {
        "controller": entries.entry("controller", run.controller),
        "level": entries.entry("level", level),
    }
    for row in host_provenance(run, {}):
        lines[row.name] = entries.entry(row.name, row.value)
    ropes = [
        replace(one, parameters={**one.parameters, _SPACING: _spacing(one, run)}) for one in ropes
    ]
    shared = _shared_parameters(ropes)
    first = ropes[0]
    for key in shared:
        lines[key] = entries.entry(key, first.parameters[key], first.prefix)
    tables = [_rope_table(rope, run, shared, entries) for rope in ropes]
    return hoist_text(case.name, lines, tables)


class _Entries:
    """Entries of a hoist's file with statuses and sources."""

    def __init__(self, case: Case, status_by_name: Mapping[str, str]) -> None:
        self._status_by_name = status_by_name
        self._values = case.values
        self._values_by_prefix = {f"{one.name}.": one.values for one in case.distinct_ropes}
        self._values_by_prefix[""] = case.values

    def entry(self, name: str, value: Value, prefix: str = "") -> ParameterValue:
        """Return the entry of a value; `prefix` is that of one of several ropes."""
        of_rope = self._values_by_prefix.get(prefix, {})
        entry_in_file = of_rope.get(name) or self._values.get(name)
        status = self._status_by_name.get(f"{prefix}{name}", SETTING)
        # the spacing of several ropes contains their places
        if status == SETTING or name == _SPACING:
            if entry_in_file is not None and entry_in_file.value == value:
                status = entry_in_file.status
            else:
                status = GIVEN if isinstance(value, str | bool) else ASSUMED
        elif status not in STATUSES:
            status = GIVEN
        if entry_in_file is not None and name in self._values:
            return ParameterValue(value, status, entry_in_file.source)
        return ParameterValue(value, status)


def _shared_parameters(ropes: Sequence[RopeData]) -> list[str]:
    """Return the parameters of the shaft and of the computation that all ropes share."""
    first = ropes[0].parameters
    return [
        key
        for key in rope_parameters()
        if not key.startswith(("rope.", "left.", "right."))
        and all(one.parameters.get(key) == first[key] for one in ropes)
    ]


def _rope_table(
    rope: RopeData, run: RunData, shared: Collection[str], entries: _Entries
) -> dict[str, ParameterValue]:
    """Return the [[rope]] table: number or name and place, break, and parameters of its own."""
    values = dict[str, Value]()
    if rope.name:
        values["rope.name"] = rope.name
        for key, x in vars(rope.suspension).items():
            values[f"rope.{key}"] = x
    else:
        values["rope.number"] = run.hoist.tail_rope_number
    if rope.breaks:
        values["rope.breaks_at"], values["rope.breaks_s"] = rope.breaks
    names = rope_parameters()
    for key, value in rope.parameters.items():
        if key in names and key not in shared:
            values[key] = value
    return {key: entries.entry(key, value, rope.prefix) for key, value in values.items()}


_SPACING = "layout.spacing"


def _spacing(rope: RopeData, run: RunData) -> float:
    """Return the spacing of the conveyances' centres [m], from a rope's and its place."""
    of_rope = float(rope.parameters[_SPACING])
    set_spacing = float(run.rope_values.get(_SPACING, rope_parameters()[_SPACING].start))
    if rope.suspension.end_distance(set_spacing) == of_rope:
        return set_spacing
    return of_rope - rope.suspension.x_right + rope.suspension.x_left


def as_file(case: Case, name: str, values: Values) -> str:
    """Return the complete file of a hoist.

    `name` is how it is found, `values` are set beside it.
    """
    run, ropes, sources = _wound(case, name, values)
    return complete_file(case, run, ropes, sources)


def hoist_provenance(case: Case, name: str, values: Values | None = None) -> list[SourcedValue]:
    """Return the provenance of all values.

    `name` is how the hoist is found, `values` are set beside its file.
    """
    return _wound(case, name, values or {})[2]


def _wound(
    case: Case, name: str, values: Values
) -> tuple[RunData, list[RopeData], list[SourcedValue]]:
    """Return the run that winds the hoist, its ropes and the sources of both."""
    run = from_landing(build(name, values))
    ropes = ropes_of(case, run, {}, case.level)
    run = replace(run, hoist=ropes.hoist)
    return run, ropes.data(), [*host_provenance(run, {}), *ropes.provenance({})]


@dataclass(frozen=True)
class CheckRow:
    """Bound that a hoist keeps or breaks before it is wound, with the sentence on a broken one."""

    group: str
    quantity: str
    value: str
    bound: str
    holds: bool
    problem: str  # told where it does not hold

    @property
    def summary(self) -> SummaryRow:
        """Row of the table of what follows."""
        kept = "kept" if self.holds else "NOT KEPT"
        return SummaryRow(self.group, self.quantity, f"{self.value}, at least {self.bound}: {kept}")


@dataclass(frozen=True)
class HoistCheck:
    """Judgements of a hoist before it is wound: bounds, remarks on values and on ropes.

    Sentences and exit code follow from the rows that the table prints.
    """

    rows: tuple[CheckRow, ...]
    remarks: tuple[str, ...] = ()

    @property
    def problems(self) -> list[str]:
        """Sentences on broken bounds, then the remarks."""
        return [*(row.problem for row in self.rows if not row.holds), *self.remarks]

    @property
    def summary(self) -> str:
        """The check in words."""
        count = len(self.problems)
        if count == 0:
            return "no problems found"
        plural = "s" if count > 1 else ""
        return f"{count} problem{plural} found"

    @property
    def exit_code(self) -> int:
        """Exit code of `check`."""
        if self.problems:
            return 1
        return 0


def checks(case: Case) -> list[CheckRow]:
    """Return a row for each bound of a hoist at rest, in its trip and in emergency stops."""
    return [*_slip_checks(case), *_drive_checks(case)]


def _slip_checks(case: Case) -> Iterator[CheckRow]:
    """Yield a row for each instant at which the head ropes must hold on the sheave."""
    limit = case.hoist.tension_ratio_limit
    for one in static_slip_safeties(case.hoist, case.winding):
        motion = "stop" if "stop" in one.when else "trip"
        yield CheckRow(
            _HOLD,
            quantity=f"slip safety {one.when}, without swing",
            value=f"{one.safety:.3g}",
            bound=f"{one.required:g}",
            holds=one.safety >= one.required,
            problem=(
                f"slip safety {one.when} is {one.safety:.3g} (tension ratio {one.ratio:.3g}, limit "
                f"{limit:.3g}), and {one.required:g} is asked for: more weight on the light side, "
                f"a better lining, or a gentler {motion}"
            ),
        )


class _DriveLimit(NamedTuple):
    """Limit of motor or brake, and what the trip needs of it."""

    name: str  # parameter of the hoist
    limit: float
    needed: float
    unit: str
    cure: str


def _drive_checks(case: Case) -> Iterator[CheckRow]:
    """Yield a row for each limit of motor and brake."""
    trip = reached(case.winding)
    limits = [*_motor_limits(case.hoist, trip)]
    if case.hoist.brake is not None:
        limits += _brake_limits(case.hoist, case.hoist.brake, trip)
    for one in limits:
        value = f"{one.limit:g} {one.unit}"
        bound = f"{one.needed:.3g} {one.unit}"
        yield CheckRow(
            _DRIVE,
            quantity=f"hoist.{one.name}",
            value=value,
            bound=bound,
            holds=one.limit >= one.needed,
            problem=f"hoist.{one.name} = {value} must be at least {bound}, {one.cure}",
        )


def _motor_limits(hoist: Hoist, trip: Winding) -> Iterator[_DriveLimit]:
    inputs = RuleInputs(hoist, trip, hoist)
    speed = max(0.0, trip.speed - 0.5 * trip.acceleration**2 / trip.jerk)  # at full acceleration
    way = speed**2 / (2.0 * trip.acceleration)
    power = inputs.torque(way) * speed / hoist.sheave_radius
    cure = (
        "which speeding up with the payload asks for: raise it, or wind more gently "
        "(winding.acceleration, winding.speed)"
    )
    yield _DriveLimit("torque_limit", hoist.torque_limit, inputs.torque(), "N m", cure)
    yield _DriveLimit("power_limit", hoist.power_limit or math.inf, power, "W", cure)


def _brake_limits(hoist: Hoist, brake: Brake, trip: Winding) -> Iterator[_DriveLimit]:
    holding = hoist.sheave_radius * hoist.imbalance()
    cure = "which holds the heavier side: fit a stronger brake"
    yield _DriveLimit("brake.torque", brake.torque, holding, "N m", cure)
    first_torque = brake.first_stage * brake.torque
    if trip.emergency_law == "two-stage" and brake.torque >= holding:
        # the second stage holds what the first lets run
        yield _DriveLimit(
            "brake.first_stage",
            limit=brake.first_stage,
            needed=holding / brake.torque,
            unit="of brake.torque",
            cure=(
                f"of which the first stage gives {first_torque:.3g} N m to hold the heavier side: "
                f"until first_stage_time = {brake.first_stage_time:g} s it runs on; raise the "
                "first stage, or shorten it"
            ),
        )


def examine(case: Case, name: str, values: Values) -> tuple[str, HoistCheck]:
    """Return the table of what follows from a hoist, and its check.

    RuntimeError where a rope cannot hang.
    """
    checked = checks(case)
    text, warnings = _consequences(case, name, values, checked)
    return text, HoistCheck(tuple(checked), (*case.remarks, *warnings))


def _consequences(
    case: Case, name: str, values: Values, checked: Sequence[CheckRow]
) -> tuple[str, list[str]]:
    """Return the table of what follows, and the ropes' warnings at rest.

    RuntimeError where a rope cannot hang.
    """
    hoist = case.hoist
    rows = [row.summary for row in checked if row.group == _HOLD]
    for height in (0.0, hoist.shaft_travel):
        left, right = pulls(hoist, height)
        label = f"{left / 1e3:.4g} and {right / 1e3:.4g} kN"
        heads = f"pull of all head ropes, left and right, left conveyance at {height:g} m"
        rows.append(SummaryRow(_HOLD, heads, label))
    rows.append(SummaryRow(_HOLD, "all moving masses", hoist.moving_mass, "kg"))
    rows += [row.summary for row in checked if row.group != _HOLD]
    warnings = list[str]()
    yaws = dict[str, float]()
    ropes = ropes_of(case, from_landing(build(name, values)), {}, case.level).ropes
    for rope in ropes:
        prefix = f"{rope.name}: " if rope.name else ""
        plant = balance_rope(rope.scene)
        heights = [0.0, 0.5 * hoist.shaft_travel, hoist.shaft_travel]
        for height, signals in at_rest(plant, hoist, heights):
            yaws[rope.name] = max(yaws.get(rope.name, 0.0), signals["loop.yaw"], key=abs)
            rows += _rows_at_rest(f"{prefix}{_AT_REST} {height:g} m", signals)
        model = f"{plant.fidelity} with {plant.elements} elements ({plant.fidelity_reason})"
        rows.append(SummaryRow(f"{prefix}Model", "fidelity and mesh", model))
        warnings += [f"{prefix}{text}" for text in plant.warnings().values()]
        frequencies = _frequencies(rope.scene, hoist.shaft_travel)
        rows.append(SummaryRow(f"{prefix}Model", "frequencies, mid-trip", frequencies))
    warnings += _neighbours(ropes, yaws)
    return render(rows), list(dict.fromkeys(warnings))


def _rows_at_rest(group: str, signals: Mapping[str, float]) -> Iterator[SummaryRow]:
    """Yield the rows of a rope at rest, by its signals."""
    left_pull, right_pull = (-1e-3 * signals[f"{end}.fy"] for end in SIDES)
    pulls_text = f"{left_pull:.4g} and {right_pull:.4g} kN"
    yield SummaryRow(group, "its pull on the left and right conveyance", pulls_text)
    yield SummaryRow(group, "loop's lowest point", signals["loop.y"], "m")
    yield SummaryRow(group, "loop's yaw", math.degrees(signals["loop.yaw"]), "deg")
    yield SummaryRow(group, "torque at the left end", abs(signals["left.my"]), "N.m")
    for key, value in signals.items():
        if key.startswith("clearance.") and abs(value) < SHOWN_CLEARANCE:
            yield SummaryRow(group, key.replace(".", " to ", 1), value, "m")


def _neighbours(ropes: Sequence[OneRope], yaws: Mapping[str, float]) -> Iterator[str]:
    """Yield remarks on ropes that may touch, by the `yaws` [rad] of their loops at rest.

    They yaw more in a trip.
    """
    for one, other in combinations(ropes, 2):
        x, _, z = one.suspension.origin
        x_other, _, z_other = other.suspension.origin
        distance = abs(z - z_other)
        radii = 0.5 * (one.scene.rope.diameter + other.scene.rope.diameter)
        required_distance = (
            abs(_reach(one, yaws[one.name]) - _reach(other, yaws[other.name])) + radii
        )
        if abs(x - x_other) < one.scene.layout.spacing and distance < required_distance:
            angle = f"{math.degrees(yaws[one.name]):.2g}"
            angle_other = f"{math.degrees(yaws[other.name]):.2g}"
            yield (
                f"{one.name} and {other.name}, {distance:.3g} m apart in z, may touch: their "
                f"loops yaw by up to {angle} and {angle_other} degrees at rest, and in a trip by "
                f"up to {YAWS:g} times that [assumed]: hang them {required_distance:.2g} m apart, or "
                "see their "
                "clearance in wind's verdict"
            )


def _reach(rope: OneRope, yaw: float) -> float:
    """Return how far a leg moves out of plane in a trip [m], by the loop's `yaw` at rest [rad]."""
    quarter_turn = 0.5 * math.pi
    yaw_in_trip = max(-quarter_turn, min(YAWS * yaw, quarter_turn))
    return 0.5 * rope.scene.layout.spacing * math.sin(yaw_in_trip)


def _frequencies(scene: Scene, travel: float) -> str:
    # a rope that is computed as rigid or planar swings out of its plane too
    rope = NativeRope(scene.with_(model=replace(scene.model, fidelity="torsional")))
    status = rope.initialize(0.0, EndMotion(y=0.5 * travel), EndMotion(y=0.5 * travel))
    if not status.valid:
        return status.message
    try:
        modes = natural_modes(rope, MODES)
    except ValueError as error:
        return str(error)
    texts = []
    for frequency, out_of_plane in zip(modes.frequencies, modes.out_of_plane, strict=True):
        direction = "out of" if out_of_plane > 0.5 else "in"
        texts.append(f"{frequency:.3g} Hz {direction} plane")
    return ", ".join(texts)
