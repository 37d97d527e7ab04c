"""The file of a hoist with every value of a run, its status and its source."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from hoist_demo.cases.case import Case
from hoist_demo.cases.writing import hoist_text
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.files.registry import rope_parameters
from hoist_demo.files.values import ASSUMED, GIVEN, STATUSES, ParameterValue
from hoist_demo.parameters.quantity import Value
from hoist_demo.run.data import RunData, build_single_trip
from hoist_demo.run.provenance import SETTING, SourcedValue, host_provenance, statuses
from hoist_demo.run.ropes import ropes_of

_SPACING = "layout.spacing"


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
        """Return the entry of a value; ``prefix`` is that of one of several ropes."""
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
    values: dict[str, Value] = {}
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


def _spacing(rope: RopeData, run: RunData) -> float:
    """Return the spacing of the conveyances' centres [m], from a rope's and its place."""
    of_rope = float(rope.parameters[_SPACING])
    set_spacing = float(run.rope_values.get(_SPACING, rope_parameters()[_SPACING].start))
    if rope.suspension.end_distance(set_spacing) == of_rope:
        return set_spacing
    return of_rope - rope.suspension.x_right + rope.suspension.x_left


class _WoundHoist(NamedTuple):
    """Run that winds a hoist, its ropes, and the sources of both."""

    run: RunData
    ropes: list[RopeData]
    provenance: list[SourcedValue]


def as_file(case: Case, name: str, values: Mapping[str, Value]) -> str:
    """Return the complete file of a hoist.

    ``name`` is how it is found, ``values`` are set beside it.
    """
    wound = _wound_hoist(case, name, values)
    return complete_file(case, wound.run, wound.ropes, wound.provenance)


def hoist_provenance(
    case: Case, name: str, values: Mapping[str, Value] | None = None
) -> list[SourcedValue]:
    """Return the provenance of all values.

    ``name`` is how the hoist is found, ``values`` are set beside its file.
    """
    return _wound_hoist(case, name, values or {}).provenance


def _wound_hoist(case: Case, name: str, values: Mapping[str, Value]) -> _WoundHoist:
    run = build_single_trip(name, values)
    ropes = ropes_of(case, run, {}, case.level)
    provenance = [*host_provenance(run, {}), *ropes.provenance({})]
    return _WoundHoist(replace(run, hoist=ropes.hoist), ropes.data(), provenance)
