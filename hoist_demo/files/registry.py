"""All parameters of runs: the host's as ``section.field``, those of rope and shaft by FMI name.

Every value is checked for its unit, its type and, one at a time, its bounds: the data classes check
themselves, and the FMU is asked to initialize with the value.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cache, reduce
from typing import Any

from pydantic import Field, ValidationError, create_model

from hoist_demo.control.controller import Gains
from hoist_demo.files.reading import table_of
from hoist_demo.parameters import SIDES, Arrival, Coupling, Hoist, Winding
from hoist_demo.parameters.quantity import FileParameter, NumberRange, Value, leaves
from hoist_demo.parameters.trip_design import CONTROLLERS, Shaper, TrajectoryOptions
from rope_model import Scene
from rope_model.scene_names import choices_of, named_parameters

SECTIONS: dict[str, type[Any]] = {
    "hoist": Hoist,
    "winding": Winding,
    "coupling": Coupling,
    "gains": Gains,
    "shaper": Shaper,
    "trajectory": TrajectoryOptions,
    "arrival": Arrival,
}
CONTROLLER = FileParameter("controller", "1", "String", "pi-feed-forward", choices=CONTROLLERS)
_Data = create_model("Data", **{name: (kind, kind()) for name, kind in SECTIONS.items()})  # type: ignore[call-overload]


def data_of(values: Mapping[str, Value]) -> dict[str, Any]:
    """Return the data of all sections with values by their names in files.

    A part of which none is given is None.
    """
    nested: dict[str, Any] = {}
    for name in filter(host_parameters().__contains__, values):
        *tables, key = name.split(".")
        reduce(lambda inner, one: inner.setdefault(one, {}), tables, nested)[key] = values[name]
    try:
        return dict(_Data.model_validate(nested))
    except ValidationError as error:
        lines = (
            f"{one['loc'][0]}: {one.get('ctx', {}).get('error', one['msg'])}"
            for one in error.errors()
        )
        raise ValueError("\n".join(lines)) from error


@cache
def rope_parameters() -> dict[str, FileParameter]:
    """Return the parameters of a rope and its surroundings by FMI name."""
    by_name: dict[str, FileParameter] = {}
    for p in named_parameters(Scene()):
        by_name[p.name] = FileParameter(
            p.name,
            unit=p.facts.unit or "1",
            kind=p.kind,
            start=p.value,
            bounds=NumberRange(p.minimum, p.maximum),
            choices=choices_of(p.name),
            meaning=p.facts.description,
        )
    return by_name


SWIVELS = "swivels"  #: Table with parameters of both swivels.


@cache
def swivel_parameters() -> tuple[FileParameter, ...]:
    """Return the parameters of both swivels, which count less than those of one."""
    of_left = (p for p in rope_parameters().values() if p.name.startswith("left.swivel."))
    return tuple(replace(p, name=p.name.replace("left.swivel", SWIVELS)) for p in of_left)


def at_both_ends(values: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Return values by name, with those of ``swivels`` repeated for both ends."""
    expanded: dict[str, Any] = {}
    for key, value in sorted(values, key=lambda item: not item[0].startswith(f"{SWIVELS}.")):
        if key.startswith(f"{SWIVELS}."):
            name = key.removeprefix(f"{SWIVELS}.")
            for end in SIDES:
                expanded[f"{end}.swivel.{name}"] = value
        else:
            expanded[key] = value
    return expanded


@cache
def host_parameters() -> dict[str, FileParameter]:
    """Return the parameters of hoist, trip, controller and coupling by their names in files."""
    by_name = {CONTROLLER.name: CONTROLLER}
    for section, data in SECTIONS.items():
        for p in leaves(data, f"{section}."):
            by_name[p.name] = p
    return by_name


@cache
def group_table(group: str, leaf: Callable[[FileParameter], Any]) -> Any:
    """Return the type of a group's table; ``leaf`` gives the types of its parameters."""
    every = (*host_parameters().values(), *rope_parameters().values(), *swivel_parameters())
    return table_of(group, [p for p in every if p.name.startswith(f"{group}.")], leaf)


def run_fields(leaf: Callable[[FileParameter], Any]) -> dict[str, Any]:
    """Return the fields of a model with all parameters of a run, of types by ``leaf``."""
    names = (*host_parameters(), *rope_parameters())
    groups = dict.fromkeys(name.partition(".")[0] for name in names if name != CONTROLLER.name)
    tables = {group: (group_table(group, leaf), Field(default=None)) for group in groups}
    return {CONTROLLER.name: (leaf(CONTROLLER), Field(default=None)), **tables}


def parameters(rope: Mapping[str, FileParameter] | None = None) -> dict[str, FileParameter]:
    """Return all parameters of runs by name.

    ``rope`` are those of an FMU, in the place of a scene's.
    """
    by_name = {**host_parameters(), **(rope_parameters() if rope is None else rope)}
    by_name.pop("inputs_at_step_end", None)
    return by_name
