"""Keys of a study: the host's data as `section.field`, and the FMU's parameters by name.

Every value is checked for its unit, its type and, one at a time, its bounds: the data classes check themselves, and
the FMU is asked to initialize with the value.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache
from typing import Any, Literal, get_args, get_origin, get_type_hints

from hoist_demo.control.controller import Gains
from hoist_demo.design.controllers import CONTROLLERS
from hoist_demo.design.optimal_trajectory import TrajectoryOptions
from hoist_demo.design.shaping import Shaper
from hoist_demo.files.reading import table_of
from hoist_demo.parameters import Arrival, Coupling, Hoist, Winding
from hoist_demo.parameters.quantity import Parameter, fmi_unit, meaning_of, units_of
from rope_model import Scene
from rope_model.scene_names import choices_of, named_parameters

_KINDS = {bool: "Boolean", int: "Integer", str: "String", float: "Real"}


def leaves(data: type[Any], prefix: str = "") -> Iterator[Parameter]:
    """All single values of a data class, by dotted names; `brake: Brake | None` stands for the brake's own."""
    hints, units = get_type_hints(data), units_of(data)
    for field in fields(data):
        inner = _inner(hints[field.name])
        if inner is not None:
            yield from leaves(inner, f"{prefix}{field.name}.")
            continue
        if get_origin(hints[field.name]) is Literal:
            choices = get_args(hints[field.name])
            yield Parameter(f"{prefix}{field.name}", "1", "String", choices=choices, meaning=meaning_of(field))
            continue
        kinds = [_KINDS[t] for t in (hints[field.name], *get_args(hints[field.name])) if t in _KINDS]
        if kinds:
            numeric = kinds[0] in ("Real", "Integer")
            if numeric and field.name not in units:
                raise ValueError(
                    f"{data.__name__}.{field.name} must state its unit: make it with `quantity(default, unit)`"
                )
            unit = fmi_unit(units[field.name]) if numeric else "1"
            yield Parameter(f"{prefix}{field.name}", unit, kinds[0], meaning=meaning_of(field))


def with_values(data: Any, values: Mapping[str, object]) -> Any:
    """A copy with the given values by dotted name, checked as a whole; a part that was None starts from defaults."""
    direct: dict[str, object] = {}
    parts: dict[str, dict[str, object]] = {}
    for name, value in values.items():
        head, _, rest = name.partition(".")
        if rest:
            parts.setdefault(head, {})[rest] = value
        else:
            direct[head] = value
    for head, inside in parts.items():
        part = getattr(data, head)
        if part is None:
            kind = _inner(get_type_hints(type(data))[head])
            assert kind is not None  # the catalogue has let the name pass
            part = kind()
        direct[head] = with_values(part, inside)
    return replace(data, **direct)


def _inner(hint: Any) -> type[Any] | None:
    """The data class that a hint names, alone or beside None."""
    return next((t for t in (hint, *get_args(hint)) if isinstance(t, type) and is_dataclass(t)), None)


SECTIONS: dict[str, type[Any]] = {
    "hoist": Hoist,
    "winding": Winding,
    "coupling": Coupling,
    "gains": Gains,
    "shaper": Shaper,
    "trajectory": TrajectoryOptions,
    "arrival": Arrival,
}

RESERVED = {"inputs_at_step_end": "the host sets it"}
#: Names of earlier versions and those of today.
RENAMED = {
    "model.rung": ["model.fidelity"],
    "mesh.leg_growth": ["mesh.grading_length"],
    **{f"hoist.shaft.{name}": [f"hoist.drive_shaft.{name}"] for name in ("motor_mass", "stiffness", "damping")},
}
_OF_PLACE = {
    "x_left": "from the left conveyance's centre to where the rope hangs, to the right",
    "x_right": "the same at the right conveyance",
    "z": "from the conveyances' centres to where the rope hangs, out of their plane",
    "breaks_at": "time of the rope's break; none without it",
    "breaks_s": "place of the break, from the left end along the rope",
}
#: where a rope of several hangs and breaks
PLACE_PARAMETERS = {
    f"rope.{name}": Parameter(f"rope.{name}", "s" if name == "breaks_at" else "m", "Real", meaning=meaning)
    for name, meaning in _OF_PLACE.items()
}
#: parts of a run that no file's table sets
CONTROLLER = Parameter("controller", "1", "String", "pi-feed-forward", choices=CONTROLLERS)


@cache
def rope_parameters() -> dict[str, Parameter]:
    """Return the parameters of a rope and its surroundings by FMI name."""
    return {
        p.name: Parameter(
            p.name, p.facts.unit or "1", p.kind, p.value, p.minimum, p.maximum, choices_of(p.name), p.facts.description
        )
        for p in named_parameters(Scene())
    }


@cache
def host_parameters() -> dict[str, Parameter]:
    """Return the parameters of hoist, trip, controller and coupling by their names in files."""
    return {p.name: p for section, data in SECTIONS.items() for p in leaves(data, f"{section}.")}


def of_run(leaf: Callable[[Parameter], Any]) -> dict[str, Any]:
    """Return the fields of a model with all parameters of a run by their names, each of the type that `leaf` gives."""
    groups: dict[str, list[Parameter]] = {}
    for p in (*host_parameters().values(), *rope_parameters().values()):
        groups.setdefault(p.name.partition(".")[0], []).append(p)
    tables: dict[str, Any] = {group: (table_of(group, members, leaf) | None, None) for group, members in groups.items()}
    return tables | {"controller": (leaf(CONTROLLER) | None, None)}


class Catalogue:
    """All parameters of runs, for keys that are no table's: --set NAME=VALUE."""

    def __init__(self, rope: Mapping[str, Parameter] | None = None) -> None:
        """`rope` are the parameters of an FMU; those of a scene without it."""
        own = rope_parameters() if rope is None else rope
        self._parameters = {"controller": CONTROLLER, **host_parameters()}
        self._parameters |= {name: p for name, p in own.items() if name not in RESERVED}

    def __contains__(self, key: str) -> bool:
        return key in self._parameters

    def __getitem__(self, key: str) -> Parameter:
        """The parameter; a `ValueError` for an unknown key names the nearest ones."""
        if key in RESERVED:
            raise ValueError(f"{key} cannot be chosen, {RESERVED[key]}: leave it out")
        if key not in self._parameters:
            raise ValueError(f"{key} is not a parameter: {cure_of(key, self._parameters)}")
        return self._parameters[key]

    def units(self, keys: Iterable[str]) -> dict[str, str]:
        """Unit of each key."""
        return {key: self[key].unit for key in keys}


def cure_of(key: str, known: Iterable[str] = ()) -> str:
    """Return what may have been meant by an unknown key; `known` are the names there, else all parameters."""
    if key in RESERVED:
        return f"{RESERVED[key]}: leave it out"
    names = tuple(known) or (*host_parameters(), *rope_parameters(), "controller")
    near = RENAMED.get(key) or [name for name in names if name.lower() == key.lower()]
    near = near or difflib.get_close_matches(key, names, n=3)
    near = near or [name for name in names if name.split(".")[-1] == key.split(".")[-1]][:3]
    return f"did you mean {' or '.join(near)}?" if near else f"sections are {', '.join(SECTIONS)}, or an FMU name"
