"""A hoist before it is wound: its values with their sources, and what follows from them."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from hoist_demo.cases.case import Case
from hoist_demo.cases.rules import RuleInputs
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.design.statics import at_rest, pulls, reached, static_slip_safeties
from hoist_demo.files.registry import rope_parameters
from hoist_demo.files.values import GIVEN, STATUSES, ParameterValue
from hoist_demo.files.writing import hoist_text
from hoist_demo.parameters import SIDES
from hoist_demo.parameters.quantity import Value
from hoist_demo.report.rows import SummaryRow, render
from hoist_demo.ropes.definition import OneRope, ropes_of
from hoist_demo.study.provenance import SETTING, SourcedValue, host_provenance, statuses
from hoist_demo.study.run import RunData, build, from_landing
from rope_model import BalanceRope, EndMotion, RopeSimulator, balance_rope
from rope_model.simulation.outputs.modal import natural_modes

MODES = 4  #: Number of the rope's lowest modes in the table.
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
    status, stated = statuses(provenance), case.values
    stated_of = {"": stated} | {f"{one.name}.": one.values for one in case.distinct_ropes}

    def entry(name: str, value: Value, of: str = "") -> ParameterValue:
        source_status = status.get(f"{of}{name}", SETTING)
        file_status = source_status if source_status in STATUSES else GIVEN
        own = stated_of.get(of, {}).get(name) or stated.get(name)
        if (
            source_status == SETTING or name == _SPACING
        ):  # that of several ropes has their places in it
            file_status = GIVEN if isinstance(value, str | bool) else "assumed"
            file_status = own.status if own is not None and own.value == value else file_status
        return ParameterValue(
            value, file_status, own.source if own is not None and name in stated else ""
        )

    level = ropes[0].level or case.level
    lines = {"controller": entry("controller", run.controller), "level": entry("level", level)}
    lines |= {one.name: entry(one.name, one.value) for one in host_provenance(run, {})}
    names = rope_parameters()
    ropes = [
        replace(one, parameters={**one.parameters, _SPACING: _spacing(one, run)}) for one in ropes
    ]
    first = ropes[0]
    alike = {
        key
        for key in names
        if all(one.parameters.get(key) == first.parameters[key] for one in ropes)
    }
    shared = {key for key in alike if not key.startswith(("rope.", "left.", "right."))}
    lines |= {
        key: entry(key, first.parameters[key], first.prefix) for key in names if key in shared
    }
    tables = []
    for rope in ropes:
        own = {
            key: value
            for key, value in rope.parameters.items()
            if key in names and key not in shared
        }
        placed: dict[str, Value] = {"rope.number": run.hoist.tail_rope_number}
        if rope.name:
            placed = {
                "rope.name": rope.name,
                **{f"rope.{key}": x for key, x in vars(rope.suspension).items()},
            }
        if rope.breaks:
            placed |= dict(zip(("rope.breaks_at", "rope.breaks_s"), rope.breaks, strict=True))
        tables.append(
            {key: entry(key, value, rope.prefix) for key, value in {**placed, **own}.items()}
        )
    return hoist_text(case.name, lines, tables)


_SPACING = "layout.spacing"


def _spacing(rope: RopeData, run: RunData) -> float:
    """Return the spacing of the conveyances' centres [m], from a rope's and its place."""
    own, offset = float(rope.parameters[_SPACING]), rope.suspension
    set_spacing = float(run.rope_values.get(_SPACING, rope_parameters()[_SPACING].start))
    return (
        set_spacing
        if set_spacing + offset.x_right - offset.x_left == own
        else own - offset.x_right + offset.x_left
    )


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
    """Return all judgements of a hoist before it is wound: bounds, remarks on values and on ropes.

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
        return f"{count} problem{'s' if count > 1 else ''} found" if count else "no problems found"

    @property
    def exit_code(self) -> int:
        """Exit code of `check`."""
        return 1 if self.problems else 0


def checks(case: Case) -> list[CheckRow]:
    """Return a row for each bound of a hoist at rest, in its trip and in emergency stops."""
    return [*_slip_checks(case), *_drive_checks(case)]


def _slip_checks(case: Case) -> Iterator[CheckRow]:
    """Yield a row for each instant at which the head ropes must hold on the sheave."""
    limit = case.hoist.tension_ratio_limit
    for one in static_slip_safeties(case.hoist, case.winding):
        problem = (
            f"slip safety {one.when} is {one.safety:.3g} (tension ratio {one.ratio:.3g}, limit "
            f"{limit:.3g}), and {one.required:g} is asked for: more weight on the light side, a "
            f"better lining, or a gentler {'stop' if 'stop' in one.when else 'trip'}"
        )
        holds = one.safety >= one.required
        quantity = f"slip safety {one.when}, without swing"
        yield CheckRow(_HOLD, quantity, f"{one.safety:.3g}", f"{one.required:g}", holds, problem)


def _drive_checks(case: Case) -> Iterator[CheckRow]:
    """Yield a row for each limit of motor and brake."""
    hoist, trip, brake = case.hoist, reached(case.winding), case.hoist.brake
    inputs, radius = RuleInputs(hoist, trip, hoist), hoist.sheave_radius
    speed = max(0.0, trip.speed - 0.5 * trip.acceleration**2 / trip.jerk)  # at full acceleration
    power = inputs.torque(speed**2 / (2.0 * trip.acceleration)) * speed / radius
    gently = "wind more gently (winding.acceleration, winding.speed)"
    asks = f"which speeding up with the payload asks for: raise it, or {gently}"
    limits = [("torque_limit", hoist.torque_limit, inputs.torque(), "N m", asks)]
    limits += [("power_limit", hoist.power_limit or math.inf, power, "W", asks)]
    if brake is not None:
        holding = radius * hoist.imbalance()
        asks = "which holds the heavier side: fit a stronger brake"
        limits.append(("brake.torque", brake.torque, holding, "N m", asks))
        first = brake.first_stage * brake.torque
        if trip.emergency_law == "two-stage" and brake.torque >= holding:
            # the second stage holds what the first lets run
            asks = (
                f"of which the first stage gives {first:.3g} N m to hold the heavier side: until "
                f"first_stage_time = {brake.first_stage_time:g} s it runs on; raise the first "
                "stage, or shorten it"
            )
            limits.append(
                (
                    "brake.first_stage",
                    brake.first_stage,
                    holding / brake.torque,
                    "of brake.torque",
                    asks,
                )
            )
    for name, limit, asked, unit, asks in limits:
        problem = f"hoist.{name} = {limit:g} {unit} must be at least {asked:.3g} {unit}, {asks}"
        yield CheckRow(
            _DRIVE,
            f"hoist.{name}",
            f"{limit:g} {unit}",
            f"{asked:.3g} {unit}",
            limit >= asked,
            problem,
        )


def examine(case: Case, name: str, values: Values) -> tuple[str, HoistCheck]:
    """Return the table of what follows from a hoist, and its check.

    RuntimeError where a rope cannot hang.
    """
    checked = checks(case)
    text, warned = _consequences(case, name, values, checked)
    return text, HoistCheck(tuple(checked), (*case.remarks, *warned))


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
    warned, yaws = [], dict[str, float]()
    ropes = ropes_of(case, from_landing(build(name, values)), {}, case.level).ropes
    for rope in ropes:
        whose = f"{rope.name}: " if rope.name else ""
        plant = balance_rope(rope.scene)
        for height, signals in at_rest(
            plant, hoist, [0.0, 0.5 * hoist.shaft_travel, hoist.shaft_travel]
        ):
            group = f"{whose}{_AT_REST} {height:g} m"
            yaws[rope.name] = max(yaws.get(rope.name, 0.0), signals["loop.yaw"], key=abs)
            pull = [-1e-3 * signals[f"{end}.fy"] for end in SIDES]
            rows += [
                SummaryRow(
                    group,
                    "its pull on the left and right conveyance",
                    f"{pull[0]:.4g} and {pull[1]:.4g} kN",
                ),
                SummaryRow(group, "loop's lowest point", signals["loop.y"], "m"),
                SummaryRow(group, "loop's yaw", math.degrees(signals["loop.yaw"]), "deg"),
                SummaryRow(group, "torque at the left end", abs(signals["left.my"]), "N.m"),
            ]
            rows += [
                SummaryRow(group, key.replace(".", " to ", 1), value, "m")
                for key, value in signals.items()
                if key.startswith("clearance.") and abs(value) < 1e3
            ]
        model = f"{plant.fidelity} with {plant.elements} elements ({plant.fidelity_reason})"
        rows.append(SummaryRow(f"{whose}Model", "fidelity and mesh", model))
        warned += [f"{whose}{text}" for text in plant.warnings().values()]
        rows.append(
            SummaryRow(
                f"{whose}Model", "frequencies, mid-trip", _frequencies(plant, hoist.shaft_travel)
            )
        )
    return render(rows), list(dict.fromkeys([*warned, *_neighbours(ropes, yaws)]))


def _neighbours(ropes: Sequence[OneRope], yaws: Mapping[str, float]) -> Iterator[str]:
    """Return remarks on ropes that may touch as their loops yaw by `yaw` [rad] at rest.

    They yaw more in a trip.
    """
    for one, other in combinations(ropes, 2):
        (x, _, z), (x1, _, z1) = one.suspension.origin, other.suspension.origin
        reach, reach1 = (
            0.5
            * r.scene.layout.spacing
            * math.sin(max(-0.5 * math.pi, min(YAWS * yaws[r.name], 0.5 * math.pi)))
            for r in (one, other)
        )
        least = abs(reach - reach1) + 0.5 * (one.scene.rope.diameter + other.scene.rope.diameter)
        if abs(x - x1) < one.scene.layout.spacing and abs(z - z1) < least:
            angles = " and ".join(f"{math.degrees(yaws[r.name]):.2g}" for r in (one, other))
            yield (
                f"{one.name} and {other.name}, {abs(z - z1):.3g} m apart in z, may touch: their "
                f"loops yaw by up to {angles} degrees at rest, and in a trip by up to {YAWS:g} "
                f"times that [assumed]: hang them {least:.2g} m apart, or see their clearance in "
                "wind's verdict"
            )


def _frequencies(rope: BalanceRope, travel: float) -> str:
    status = rope.initialize(0.0, EndMotion(y=0.5 * travel), EndMotion(y=0.5 * travel))
    if not status.valid:
        return status.message
    # matrices are those of the rope in Python, which is not hung up again: without a compiler that
    # takes seconds
    scene, state = rope.scene, rope.state
    model = RopeSimulator(scene.with_(solver=replace(scene.solver, kernels="portable"))).model
    try:
        modes = natural_modes(model.system(state), state.motion.q, MODES)
    except ValueError as error:
        return str(error)
    modes_shown = zip(modes.frequencies, modes.out_of_plane, strict=True)
    return ", ".join(
        f"{f:.3g} Hz {'out of' if out > 0.5 else 'in'} plane" for f, out in modes_shown
    )
