"""Structures of scenes and end motions for ctypes, generated from their dataclasses.

In C the real numbers of a group come first, then its integers, each in the order of the dataclass; a word becomes its
index in the list of choices.
"""

import ctypes
from dataclasses import fields
from typing import Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

from rope_model.boundary.end_paths import EndMotion
from rope_model.parameters import PARAMETER_GROUPS, Scene, Swivel
from rope_model.shaft_parameters import PARTS, Shaft

#: cache of the parameters' types by data class
_HINTS_BY_TYPE: dict[Any, dict[str, Any]] = {}


class ParameterMember(NamedTuple):
    """Parameter in C."""

    name: str
    real: bool  # a double, else an int
    length: int = 0  # length of an array, or 0


def members(kind: type[Any]) -> tuple[ParameterMember, ...]:
    """Return the members of a group's structure."""
    hints = _hints(kind).items()
    lengths = {
        name: len(get_args(hint)) if get_origin(hint) is tuple else 0 for name, hint in hints
    }
    unsorted = [ParameterMember(name, hint is float, lengths[name]) for name, hint in hints]
    return tuple(sorted(unsorted, key=lambda member: not member.real))


def _hints(kind: type[Any]) -> dict[str, Any]:
    """Return the types of the parameters by name."""
    if kind not in _HINTS_BY_TYPE:
        _HINTS_BY_TYPE[kind] = get_type_hints(kind)
    return _HINTS_BY_TYPE[kind]


def _structure(kind: type[Any]) -> type[ctypes.Structure]:
    numbers = [(m, ctypes.c_double if m.real else ctypes.c_int) for m in members(kind)]
    fields = [(m.name, number * m.length if m.length else number) for m, number in numbers]
    return type(kind.__name__, (ctypes.Structure,), {"_fields_": fields})


#: structures of the groups of a scene
GROUP_STRUCTURES = {kind: _structure(kind) for kind in dict.fromkeys(PARAMETER_GROUPS.values())}


class ShaftStructure(ctypes.Structure):
    """rope_model.shaft_parameters.Shaft."""

    _fields_ = tuple((name, GROUP_STRUCTURES[kind]) for name, kind in PARTS.items())


_SCENE_TYPES: dict[Any, Any] = {
    **GROUP_STRUCTURES,
    Shaft: ShaftStructure,
    Swivel: GROUP_STRUCTURES[Swivel] * 2,
}
_NAMES = {
    "left": "swivels",
    "right": "swivels",
}  #: names of parts of a scene in C, where they differ


class SceneStructure(ctypes.Structure):
    """All parameters of a rope."""

    _fields_ = tuple(
        {
            _NAMES.get(name, name): _SCENE_TYPES[of] for name, of in get_type_hints(Scene).items()
        }.items()
    )


class EndMotionStructure(ctypes.Structure):
    """Motion of a suspension point: x and z from the nominal point, y the height in the shaft, yaw about Y."""

    _fields_ = tuple((field.name, ctypes.c_double) for field in fields(EndMotion))


def scene_structure(scene: Scene) -> SceneStructure:
    """Return the scene as a structure of C."""
    parts = {name: _fill(part) for name, part in vars(scene).items()}
    swivels = (GROUP_STRUCTURES[Swivel] * 2)(parts.pop("left"), parts.pop("right"))
    return SceneStructure(swivels=swivels, **parts)


def _fill(group: Any) -> ctypes.Structure:
    if isinstance(group, Shaft):
        return ShaftStructure(**{name: _fill(part) for name, part in vars(group).items()})
    values = {
        name: _value(getattr(group, name), hint) for name, hint in _hints(type(group)).items()
    }
    return GROUP_STRUCTURES[type(group)](**values)


def _value(value: Any, hint: Any) -> Any:
    if get_origin(hint) is Literal:
        return get_args(hint).index(value)
    return tuple(value) if get_origin(hint) is tuple else value
