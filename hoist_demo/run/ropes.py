"""The balance ropes of one hoist, each a [[rope]] of its file, checked before winding."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations

from hoist_demo.cases.case import BalanceRopeData, Case
from hoist_demo.cases.rules import case_with_values
from hoist_demo.cosimulation.drive_signals import DRIVE_UNITS
from hoist_demo.cosimulation.participants.breaking_rope import Break, BreakingRope
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.cosimulation.participants.rope_group import (
    CONTACT_ENERGIES,
    SUMS,
    GroupedRope,
    RopeGroup,
    WholeRope,
)
from hoist_demo.cosimulation.schemes.interface import RopePlant
from hoist_demo.files.registry import rope_parameters
from hoist_demo.files.values import DERIVED, ParameterValue, values_of
from hoist_demo.parameters import Hoist, hoist_with
from hoist_demo.parameters.problems import Problems
from hoist_demo.parameters.quantity import Value
from hoist_demo.parameters.suspension import SuspensionOffset
from hoist_demo.recording.nearness import RopePair, pairs
from hoist_demo.recording.time_series import Recording
from hoist_demo.run.data import RunData, fmu_part
from hoist_demo.run.provenance import SourcedValue, rope_provenance
from rope_model import SIDES, Level, Neighbours, Scene

_ROPE_STIFFNESS = "contact.rope_stiffness"
#: First parts of other signals' names: a rope's signals begin with its name.
_RESERVED_NAMES = tuple(
    dict.fromkeys(signal.partition(".")[0] for signal in (*SUMS, *CONTACT_ENERGIES, *DRIVE_UNITS))
)


@dataclass(frozen=True)
class OneRope:
    """One of the ropes: its data, its suspension, and its break."""

    name: str  # "" of the only one, or of equal ones
    parameters: Mapping[str, Value]  # values by FMI name; the level has the rest
    level: Level
    case: Case  # the hoist with this rope alone
    suspension: SuspensionOffset = field(default_factory=SuspensionOffset)
    breaks: Break | None = None
    # recorded outputs; None: all but the expensive added masses
    outputs: Collection[str] | None = None
    fmu: Callable[[], FmuRope] | None = None  # loads the one that is wound instead

    @cached_property
    def scene(self) -> Scene:
        """Scene of the rope: its complete data."""
        return rope_scene(self.parameters, self.level)

    @cached_property
    def plant(self) -> WholeRope | FmuRope:
        """Rope to be wound, with its break; the first request loads its FMU or makes it in C."""
        if self.fmu is not None:
            return self.fmu()
        rope = InProcessRope(self.scene, self.outputs, self.name)
        data = self.scene.rope
        if self.breaks is None:
            return rope
        breaks = replace(self.breaks, gravity=self.scene.layout.gravity)
        return BreakingRope(rope, data.mass_per_length, data.length, breaks)

    def data(self) -> RopeData:
        """Return the identity of the rope for the reports."""
        if self.breaks is None:
            breaks = None
        else:
            breaks = (self.breaks.t, self.breaks.s)
        return replace(self.plant.data(), name=self.name, suspension=self.suspension, breaks=breaks)


@dataclass(frozen=True)
class Ropes:
    """Balance ropes of a hoist, and the run that winds them."""

    case: Case
    run: RunData
    ropes: tuple[OneRope, ...]

    @cached_property
    def plant(self) -> RopePlant:
        """Plant that stands for all ropes; the first request loads the FMU or makes the ropes."""
        if not self.case.distinct_ropes:
            return self.ropes[0].plant
        group = [GroupedRope(rope.name, rope.plant, rope.suspension) for rope in self.ropes]
        if not self.touching:
            return RopeGroup(group)
        neighbours = Neighbours(
            [rope.scene for rope in self.ropes], [rope.suspension.origin for rope in self.ropes]
        )
        return RopeGroup(group, neighbours)

    @property
    def touching(self) -> bool:
        """True if the ropes press each other."""
        return len(self.ropes) > 1 and self.ropes[0].scene.shaft.contact.rope_stiffness > 0.0

    @property
    def hoist(self) -> Hoist:
        """Hoist of the run, with these ropes."""
        if not self.case.distinct_ropes:
            return self.run.hoist
        data = [rope.scene.rope for rope in self.ropes]
        return hoist_with(self.run.hoist, [(rope.mass_per_length, rope.length) for rope in data])

    def data(self) -> list[RopeData]:
        """Return the identities of the ropes for the reports."""
        return [rope.data() for rope in self.ropes]

    def pairs(self, recording: Recording) -> list[RopePair]:
        """Return the pairs of ropes in the record of a run."""
        if not (isinstance(self.plant, RopeGroup) and recording.signals):
            return []
        ropes = [
            (rope.name, rope.suspension.origin, rope.scene.rope.diameter) for rope in self.ropes
        ]
        return pairs(recording, ropes, self.plant.accounts())

    def provenance(self, status_by_name: Mapping[str, str]) -> list[SourcedValue]:
        """Return the provenance of the ropes' data, under each rope's name.

        ``status_by_name`` as ``rope_provenance``.
        """
        rows = []
        for rope, data in zip(self.ropes, self.data(), strict=True):
            for row in rope_provenance(rope.case, data, status_by_name):
                rows.append(row._replace(name=f"{data.prefix}{row.name}"))
        return rows


def ropes_of(
    case: Case,
    run: RunData,
    overrides: Mapping[str, Value | ParameterValue],
    level: Level,
    outputs: Collection[str] | None = None,
) -> Ropes:
    """Return the ropes of a hoist with ``overrides`` as if they stood in its file.

    A ValueError lists all problems.

    ``outputs`` are those that are recorded of each rope, as of ``OneRope``.
    """
    if not case.distinct_ropes:
        parameters = {**run.rope_values, **fmu_part(values_of(overrides))}
        return Ropes(case, run, (OneRope("", parameters, level, case, outputs=outputs),))
    case = case_with_values(case, overrides)
    guards = _guards(run.rope_values)
    for rope in case.distinct_ropes:
        guards |= _guards(rope.parameters)
    ropes = []
    with Problems() as problems:
        if guards:
            problems.append(
                f"{min(guards)} must be left out: guards of several ropes are not computed"
            )
        for rope in case.distinct_ropes:
            if rope.name in _RESERVED_NAMES:
                reserved = ", ".join(_RESERVED_NAMES)
                cause = f"signals of the rope begin with it, and {reserved} are taken"
                problems.append(f"rope name = {rope.name!r} must be another: {cause}")
            with problems.at(f"rope {rope.name}"):
                ropes.append(replace(_rope(rope, rope.parameters, level, case), outputs=outputs))
    group = Ropes(case, run, tuple(ropes))
    if group.touching:
        _require_distinct_places(ropes)
    return group


def _guards(values: Mapping[str, Value]) -> set[str]:
    """Return the parameters of guards that are set."""
    defaults = rope_parameters()
    return {
        key
        for key, value in values.items()
        if key.startswith("guard.") and value != defaults[key].start
    }


def require_unbroken(case: Case, what: str) -> None:
    """Refuse a rope that breaks, where ``what`` has no place for it."""
    for rope in case.distinct_ropes:
        if rope.breaks:
            raise ValueError(
                f"rope {rope.name}: breaks_at = {rope.breaks['breaks_at']:g} s must be left out, "
                f"for {what}: `balance-rope wind` computes the break"
            )


def _require_distinct_places(ropes: Sequence[OneRope]) -> None:
    """Refuse ropes that cannot press each other."""
    pressed = f"{_ROPE_STIFFNESS} = {ropes[0].scene.shaft.contact.rope_stiffness:g}"
    alone = f"or set {_ROPE_STIFFNESS} = 0: each rope is then alone"
    problems = Problems(
        f"rope {rope.name}: model.fidelity = {rope.scene.model.fidelity!r} must be torsional or "
        f"spatial with {pressed}, for ropes press each other out of plane: choose one, {alone}"
        for rope in ropes
        if rope.scene.model.fidelity not in ("torsional", "spatial")
    )
    for one, other in combinations(ropes, 2):
        distance = min(math.dist(one.suspension.at(end), other.suspension.at(end)) for end in SIDES)
        required_distance = 0.5 * (one.scene.rope.diameter + other.scene.rope.diameter)
        if distance < required_distance:
            problems.append(
                f"rope {other.name}: an end that is {distance:g} m from that of {one.name} must be at "
                f"least {required_distance:g} m away with {pressed}, or they touch where they "
                "hang: move it by "
                f"z or x_left and x_right, {alone}"
            )
    problems.refuse()


def _rope(
    rope: BalanceRopeData, parameters: Mapping[str, Value], level: Level, case: Case
) -> OneRope:
    """Return the rope between its points of suspension on the conveyances.

    Their centres are layout.spacing apart.
    """
    suspension = SuspensionOffset(**rope.suspension)
    spacing = rope_scene(parameters, level, suspension).layout.spacing
    breaks = None
    if rope.breaks:
        breaks = Break(rope.breaks["breaks_at"], rope.breaks["breaks_s"])
    derived_spacing = ParameterValue(spacing, DERIVED, "the rope's place")
    placed = replace(rope, values={**rope.values, "layout.spacing": derived_spacing})
    one = OneRope(
        rope.name,
        parameters={**parameters, "layout.spacing": spacing},
        level=level,
        case=case.with_rope(placed),
        suspension=suspension,
        breaks=breaks,
    )
    _ = one.scene  # checks it
    return one
