"""Signatures in C of Python functions: their names and types follow from name, module and annotations."""

import inspect
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, is_dataclass
from math import prod
from types import ModuleType
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from rope_model.boundary.end_paths import EndMotion
from rope_model.boundary.input_path import PathMeasures
from rope_model.method.mesh_pattern import Pattern
from rope_model.parameters import PARAMETER_GROUPS
from rope_model.physics.air import AirCoefficients
from rope_model.physics.centreline import SuspensionPoint
from rope_model.physics.element import ElementParameters
from rope_model.physics.elementary import Scalar
from rope_model.physics.inextensible import SuspensionMotion
from rope_model.state import RopeState

#: names of structures in C, where they differ
_IN_C: dict[type[Any], str] = {RopeState: "State"}
#: structure in C of each protocol
_STRUCTURES: dict[Any, type[Any]] = {SuspensionPoint: EndMotion, SuspensionMotion: EndMotion}
#: records that are arrays of their numbers in C; a constant there has the length
ARRAY_RECORDS: tuple[type[Any], ...] = (PathMeasures, AirCoefficients, ElementParameters)


@dataclass(frozen=True)
class Argument:
    """Argument of a C function: a number, a choice, an array of numbers, or a structure."""

    name: str
    structure: type[Any] | None = None
    shape: tuple[int, ...] = ()  # lengths of an array
    whole: bool = False  # integers, as the code of a choice
    words: tuple[Any, ...] = ()  # of a choice

    def declaration(self, constant: bool = True) -> str:
        """Return the declaration in C.  Structures and arrays are ``constant``, or receive results."""
        qualifier = "const " if constant else ""
        if self.structure is not None:
            return f"{qualifier}{name_in_c(self.structure)} *{self.name}"
        number = "int" if self.whole else "double"
        if self.shape:
            lengths = "".join(f"[{length}]" for length in self.shape)
            return f"{qualifier}{number} {self.name}{lengths}"
        return f"{number} {self.name}"


@dataclass(frozen=True)
class Formula:
    """Python function that becomes a C function."""

    function: Callable[..., Any]

    @property
    def name(self) -> str:
        """Name in C."""
        return function_in_c(self.function)

    @property
    def arguments(self) -> list[Argument]:
        """Arguments in C, without the array that receives the results."""
        return [
            argument(name, self._owner if name == "self" else hint)
            for name, hint in annotations(self.function).items()
        ]

    @property
    def result(self) -> Argument | None:
        """Array that receives the results; None for a function that returns a number or a structure."""
        hint = self._returned
        if hint in ARRAY_RECORDS:
            return Argument("result", shape=(length_of(hint),))
        shape = shape_of(hint)
        return Argument("result", shape=shape) if shape else None

    @property
    def returned(self) -> type[Any] | None:
        """Structure that the function returns; None for a number, or where an array receives the results."""
        hint = self._returned
        return hint if self.result is None and is_structure(hint) else None

    @property
    def return_type(self) -> str:
        """Type of the function in C."""
        if self.result is not None:
            return "void"
        return "double" if self.returned is None else name_in_c(self.returned)

    def prototype(self) -> str:
        """Return the prototype in C."""
        declared = [argument.declaration() for argument in self.arguments]
        if self.result is not None:
            declared.append(self.result.declaration(constant=False))
        return f"{self.return_type} {self.name}({', '.join(declared)})"

    @property
    def _returned(self) -> Any:
        return get_type_hints(self.function, include_extras=True).get("return")

    @property
    def _owner(self) -> Any:
        """Class of a method."""
        return getattr(
            sys.modules[self.function.__module__], self.function.__qualname__.split(".")[0]
        )


def annotations(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the annotations of the parameters, in their order; None for those without."""
    hints = get_type_hints(function, include_extras=True)
    return {name: hints.get(name) for name in inspect.signature(function).parameters}


def argument(name: str, hint: Any) -> Argument:
    """Return the argument of a parameter with the annotation ``hint``; raises TypeError if C has no type for it."""
    if hint in (Scalar, float):
        return Argument(name)
    if get_origin(hint) is Literal:
        return Argument(name, whole=True, words=get_args(hint))
    if get_origin(hint) is Annotated:
        whole = int in hint.__metadata__
        return Argument(name, shape=shape_of(hint), whole=whole)
    groups = [part for part in get_args(hint) if part in PARAMETER_GROUPS.values()]
    structure = groups[0] if groups else _STRUCTURES.get(hint, hint)
    if is_structure(structure) or structure is Pattern:
        return Argument(name, structure)
    raise TypeError(
        f"{name} has the annotation {hint}, which has no type in C: annotate it with Scalar, a "
        "choice (Literal), a Vector with its length, as Vector3 or InnerCounts, or a structure"
    )


def shape_of(hint: Any) -> tuple[int, ...]:
    """Return () for a number, or the lengths of an array: of its annotation, or of a nested tuple of numbers."""
    if get_origin(hint) is Annotated:
        return tuple(length for length in hint.__metadata__ if length is not int)
    parts = get_args(hint) if get_origin(hint) is tuple else ()
    return (len(parts), *shape_of(parts[0])) if parts else ()


def length_of(kind: type[Any]) -> int:
    """Return the number of numbers in a record."""
    hints = get_type_hints(kind, include_extras=True)
    return sum(prod(shape_of(hint)) for hint in hints.values())


def function_in_c(function: Callable[..., Any]) -> str:
    """Return the name of a function in C, which tells its module, or of a method its class."""
    *owner, name = function.__qualname__.rpartition("<locals>.")[2].split(".")
    room = snake_case(owner[0]) if owner else _last_part(function.__module__)
    return _with_room(room, name)


def constant_in_c(module: ModuleType, name: str) -> str:
    """Return the name of a constant in C, which tells its module."""
    return _with_room(_last_part(module.__name__).upper(), name)


def snake_case(name: str) -> str:
    """Return the name of a class in lower case, with its words apart."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()


def _last_part(module: str) -> str:
    return module.rpartition(".")[2]


def _with_room(room: str, name: str) -> str:
    """Return ``name`` behind the name of its room, unless both have a word in common."""
    if set(room.split("_")) & set(name.split("_")):
        return name
    return f"{room}_{name}"


def name_in_c(kind: type[Any]) -> str:
    """Return the name of a structure in C."""
    return _IN_C.get(kind, kind.__name__)


def is_structure(hint: Any) -> bool:
    """Return whether a parameter with this annotation is a structure in C."""
    return is_dataclass(hint) or hasattr(hint, "_fields")
