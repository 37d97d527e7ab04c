"""Sources of the numbers that a run rests on, each with its status.

What was set has the status that its file states, else ``given``: whoever set it knows its source.
What was not is of the case: ``published`` where the case's source states it, else ``assumed``,
which is ours.  A rope's parameter that is neither is the FMU's, ``exported`` with it.  A
``setting`` is no datum: it says what is computed and how.
"""

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from hoist_demo.cases.case import Case
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.files.registry import CONTROLLER, host_parameters, rope_parameters
from hoist_demo.files.values import ASSUMED, DERIVED, GIVEN, VARIED
from hoist_demo.parameters.quantity import Value
from hoist_demo.run.data import CONTROLLER_BY_SECTION, RunData
from rope_model.files import whole_file
from rope_model.texts import csv_cell

SETTING = "setting"
#: Statuses in the order of the reports.
_FIRST = (
    "contradicted",
    VARIED,
    GIVEN,
    "data sheet",
    "measured",
    "calibrated",
    DERIVED,
    "published",
    "exported",
)
STATUSES = (*_FIRST, ASSUMED, SETTING)
#: Groups of the host and of the rope whose values are no data.
_SETTINGS = ("coupling", "arrival", "mesh", "accuracy", "solver", "model", "station")


class SourcedValue(NamedTuple):
    """Value of a run with its status."""

    name: str
    value: Value
    unit: str
    status: str


def host_provenance(run: RunData, status_by_name: Mapping[str, str]) -> list[SourcedValue]:
    """Return the sources of the host's data.

    ``status_by_name`` has those of values set beside those of the run.
    """
    sourced = []
    for name, value, unit in _leaves(run):
        if name in status_by_name:
            status = status_by_name[name]
        elif name.partition(".")[0] not in _SETTINGS and _is_number(value):
            status = run.status_by_name.get(name, ASSUMED)
        else:
            status = SETTING
        sourced.append(_sourced(name, value, unit, status))
    return sourced


def _sourced(name: str, value: Value, unit: str, status: str) -> SourcedValue:
    """Return a value with its status; one that differs between runs has no number."""
    return SourcedValue(name, VARIED if status == VARIED else value, unit, status)


def rope_provenance(
    case: Case, rope: RopeData, status_by_name: Mapping[str, str]
) -> list[SourcedValue]:
    """Return the sources of one balance rope's data; ``status_by_name`` has those of set values."""
    sourced = []
    for name, value in rope.parameters.items():
        status = _status_of(name, value, case, status_by_name)
        sourced.append(_sourced(name, rope.display(name), rope.units.get(name, ""), status))
    return sourced


def _status_of(name: str, value: Value, case: Case, status_by_name: Mapping[str, str]) -> str:
    if name.partition(".")[0] in _SETTINGS:
        return SETTING
    if name in status_by_name:
        return status_by_name[name]
    if not _is_number(value):
        return SETTING
    parameter = rope_parameters().get(name)
    default = None if parameter is None else parameter.start
    if value != case.rope.get(name, default):
        return "exported"
    is_ours = parameter is not None and "[assumed]" in parameter.meaning
    of_rope = name in case.rope and name.startswith("rope.")
    if is_ours or of_rope or name in case.status_by_name:
        return case.status_by_name.get(name, ASSUMED)
    return SETTING


def _leaves(run: RunData) -> Iterator[tuple[str, Value, str]]:
    """Yield name, value and unit of each single value of the host that the run uses.

    Parts that are None are left out.
    """
    for name, value in run.host_values().items():
        controller = CONTROLLER_BY_SECTION.get(name.partition(".")[0], run.controller)
        if controller == run.controller and name != CONTROLLER.name:
            yield name, value, host_parameters()[name].unit


def _is_number(value: Value) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def statuses(data: Iterable[SourcedValue]) -> dict[str, str]:
    """Return the status of each value by name."""
    return {one.name: one.status for one in data}


def write_data(data: Sequence[SourcedValue], path: Path) -> Path:
    """Write the data as CSV, settings included, and return the path."""
    with whole_file(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(SourcedValue._fields)
        writer.writerows(map(csv_cell, one) for one in data)
    return path
